#include "forward/lateral/half_space_walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"

namespace kappamu::forward {

namespace {

constexpr std::size_t most_indices = 4;
using Weights = std::array<double, most_indices>;

/// Logarithmic bins; both ends hold what lies beyond them.
struct Bins {
  static constexpr double per_octave = 30.0;
  double first = 0.0;  ///< lower edge of bin 0
  int count = 0;

  int of(double x) const {
    return std::clamp(static_cast<int>(std::log2(std::max(x, first) / first) * per_octave), 0,
                      count - 1);
  }
  double edge(int i) const { return first * std::exp2(i / per_octave); }
};
// Beyond 6e4/σs' a path counts only where a < 1e-4; beyond r = 2e3/σs' only where k < 1e-3.
constexpr Bins paths{1e-3, 26 * 30}, radii{1e-3, 21 * 30};
constexpr double longest_path = 6e4;
// Russian roulette by path length [1/σs']: without absorption half the work would go into the one
// photon in a hundred whose path absorption makes irrelevant.
constexpr double first_roulette = 4.0, roulette_chance = 1.0 / 3.0;

/// Weight that left, [index][path][radius].
using Exits = std::vector<double>;

std::size_t exit_bin(int index, double path, double radius) {
  return (static_cast<std::size_t>(index) * paths.count + paths.of(path)) * radii.count +
         radii.of(radius);
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// In (0, 1).
  double operator()() {
    state_ += 0x9E3779B97F4A7C15ULL;
    return uniform(state_);
  }
  /// A point evenly on the unit circle.
  std::array<double, 2> direction() {
    for (;;) {
      const double x = 2.0 * (*this)() - 1.0, y = 2.0 * (*this)() - 1.0, r = x * x + y * y;
      if (r <= 1.0 && r > 1e-12) return {(x * x - y * y) / r, 2.0 * x * y / r};
    }
  }

 private:
  std::uint64_t state_;
};

/// As core's fresnel_internal(), without its checks: this is the walk's innermost step.
double reflected(double index, double cos_inside) {
  const double sin2 = index * index * (1.0 - cos_inside * cos_inside);
  if (sin2 >= 1.0) return 1.0;
  const double cos_outside = std::sqrt(1.0 - sin2);
  const double s = (index * cos_inside - cos_outside) / (index * cos_inside + cos_outside);
  const double p = (index * cos_outside - cos_inside) / (index * cos_outside + cos_inside);
  return 0.5 * (s * s + p * p);
}

class Walk {
 public:
  Walk(const WalkOptions& options, std::uint64_t seed)
      : g_(options.anisotropy), indices_(options.indices), random_(seed) {}

  void photon(Exits& exits) {
    x_ = y_ = z_ = path_ = ux_ = uy_ = 0.0;
    uz_ = 1.0;
    weight_.fill(0.0);
    std::fill_n(weight_.begin(), indices_.size(), 1.0);
    double next_roulette = first_roulette;
    for (;;) {
      const double step = -std::log(random_()) * (1.0 - g_);
      if (z_ + step * uz_ < 0.0) {
        if (!meet_surface(exits)) return;
        continue;  // the rest of the step is as long as a new one
      }
      move(step);
      if (path_ > next_roulette) {
        if (path_ > longest_path || !survives(roulette_chance)) return;
        next_roulette *= 4.0;
      }
      scatter();
    }
  }

 private:
  void move(double step) {
    x_ += step * ux_;
    y_ += step * uy_;
    z_ += step * uz_;
    path_ += step;
  }

  bool survives(double chance) {
    if (random_() > chance) return false;
    for (double& w : weight_) w /= chance;
    return true;
  }

  bool meet_surface(Exits& exits) {
    const double before = largest();
    move(-z_ / uz_);
    z_ = 0.0;
    uz_ = -uz_;
    const double radius = std::hypot(x_, y_);
    for (std::size_t i = 0; i < indices_.size(); ++i) {
      const double r = reflected(indices_[i], uz_);
      if (r < 1.0) exits[exit_bin(static_cast<int>(i), path_, radius)] += weight_[i] * (1.0 - r);
      weight_[i] *= r;
    }
    const double after = largest();
    return after >= 0.5 * before || survives(after / before);
  }

  double largest() const { return *std::max_element(weight_.begin(), weight_.end()); }

  void scatter() {
    double c = 2.0 * random_() - 1.0;
    if (std::abs(g_) > 1e-6) {
      const double q = (1.0 - g_ * g_) / (1.0 + g_ * c);
      c = std::clamp((1.0 + g_ * g_ - q * q) / (2.0 * g_), -1.0, 1.0);
    }
    const double s = std::sqrt(1.0 - c * c);
    const auto [cp, sp] = random_.direction();
    const double across = ux_ * ux_ + uy_ * uy_;
    if (across < 1e-12) {
      ux_ = s * cp;
      uy_ = s * sp;
      uz_ = std::copysign(c, c * uz_);
      return;
    }
    const double t = s / std::sqrt(across);
    const double ux = t * (ux_ * uz_ * cp - uy_ * sp) + ux_ * c;
    const double uy = t * (uy_ * uz_ * cp + ux_ * sp) + uy_ * c;
    uz_ = -t * across * cp + uz_ * c;
    // Rounding lets the length drift by 1e-16 a step; one step of Newton holds it at 1.
    const double scale = 1.5 - 0.5 * (ux * ux + uy * uy + uz_ * uz_);
    ux_ = ux * scale;
    uy_ = uy * scale;
    uz_ *= scale;
  }

  double g_;
  const std::vector<double>& indices_;
  Random random_;
  double x_ = 0.0, y_ = 0.0, z_ = 0.0, path_ = 0.0;
  double ux_ = 0.0, uy_ = 0.0, uz_ = 1.0;
  Weights weight_{};
};

/// Mean of J₀(kr) over the ring of a bin.
double ring_mean(double k, double inner, double outer) {
  if (k * outer < 1e-4) return 1.0;
  return 2.0 * (outer * ::j1(k * outer) - inner * ::j1(k * inner)) /
         (k * (outer * outer - inner * inner));
}

/// Σ w e^(−aℓ) J₀(kr) over one index's exits; points of equal k share the sum over radii.
std::vector<double> transform(std::span<const double> exits, std::span<const LateralPoint> points) {
  std::vector<double> result;
  std::vector<double> along(paths.count), ring(radii.count);
  double last_k = -1.0;
  for (const LateralPoint& point : points) {
    if (point.k != last_k) {
      last_k = point.k;
      for (int r = 0; r < radii.count; ++r) {
        ring[r] = ring_mean(last_k, r == 0 ? 0.0 : radii.edge(r), radii.edge(r + 1));
      }
      for (int p = 0; p < paths.count; ++p) {
        double sum = 0.0;
        const double* row = &exits[static_cast<std::size_t>(p) * radii.count];
        for (int r = 0; r < radii.count; ++r) sum += row[r] * ring[r];
        along[p] = sum;
      }
    }
    double sum = 0.0;
    for (int p = 0; p < paths.count; ++p) {
      sum += along[p] * std::exp(-point.a * std::sqrt(paths.edge(p) * paths.edge(p + 1)));
    }
    result.push_back(sum);
  }
  return result;
}

}  // namespace

WhiteReflectance walk_half_space(const WalkOptions& options, std::span<const LateralPoint> points) {
  check(std::abs(options.anisotropy) < 1.0 && options.batches >= 2 && !options.indices.empty() &&
            options.indices.size() <= most_indices,
        "walk_half_space: options out of bounds");
  const std::size_t indices = options.indices.size(), size = indices * points.size();
  const std::uint64_t each = std::max<std::uint64_t>(1, options.photons / options.batches);
  std::vector<std::vector<double>> batches(options.batches);
  for_rows(options.batches, [&](int batch) {
    Exits exits(indices * paths.count * radii.count);
    Walk walk(options, key_of({options.seed, static_cast<std::uint64_t>(batch)}));
    for (std::uint64_t photon = 0; photon < each; ++photon) walk.photon(exits);
    for (std::size_t i = 0; i < indices; ++i) {
      const std::size_t one = exits.size() / indices;
      for (const double sum : transform(std::span(exits).subspan(i * one, one), points)) {
        batches[batch].push_back(sum / static_cast<double>(each));
      }
    }
  });
  WhiteReflectance result{std::vector<double>(size), std::vector<double>(size)};
  const double n = options.batches;
  for (std::size_t i = 0; i < size; ++i) {
    double mean = 0.0, spread = 0.0;
    for (const auto& batch : batches) mean += batch[i] / n;
    for (const auto& batch : batches) spread += (batch[i] - mean) * (batch[i] - mean);
    result.value[i] = mean;
    result.standard_error[i] = std::sqrt(spread / (n * (n - 1.0)));
  }
  return result;
}

}  // namespace kappamu::forward

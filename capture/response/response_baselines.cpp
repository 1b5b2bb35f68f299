#include "capture/response/response_baselines.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "core/error.h"

namespace kappamu::capture {
namespace {

// A code between two of the 256 knots of g; for eight bits the codes are the knots.
struct Place {
  int knot = 0;
  double weight_1 = 0.0;  // share of knot + 1
  double hat = 0.0;       // weight
};

class Knots {
 public:
  explicit Knots(int bit_depth) : codes_(1 << bit_depth) {}

  static constexpr int count = 256;
  int codes() const { return codes_; }
  // Eq. (4) plus 1, as OpenCV has it: the first and the last code would have no weight at all.
  static double hat(double knot) { return std::min(knot, count - 1 - knot) + 1.0; }
  Place at(int code) const {
    const double knot = static_cast<double>(code) * (count - 1) / (codes_ - 1);
    const int low = std::min(static_cast<int>(knot), count - 2);
    return {low, knot - low, hat(knot)};
  }

 private:
  int codes_;
};

void check_samples(const std::vector<PixelSamples>& stacks, const std::string& name) {
  const bool any = std::any_of(stacks.begin(), stacks.end(), [](const PixelSamples& stack) {
    return stack.exposure_s.size() > 1 && !stack.codes.empty();
  });
  if (!any) {
    throw InputError(name +
                     ": the exposure stacks do not hold enough to recover the camera's response "
                     "(no pixel is seen in two exposures); add exposure times.");
  }
}

// Linear interpolation over codes that no sample has; the nearest known value beyond them.
void fill_gaps(std::vector<double>& curve, const std::vector<std::uint8_t>& known) {
  std::size_t last = curve.size();
  for (std::size_t code = 0; code < curve.size(); ++code) {
    if (known[code] == 0) continue;
    const std::size_t first = last == curve.size() ? 0 : last + 1;
    for (std::size_t gap = first; gap < code; ++gap) {
      const double share =
          last == curve.size() ? 1.0 : static_cast<double>(gap - last) / (code - last);
      curve[gap] = last == curve.size() ? curve[code] * gap / std::max<std::size_t>(code, 1)
                                        : curve[last] + share * (curve[code] - curve[last]);
    }
    last = code;
  }
  for (std::size_t code = last + 1; code < curve.size(); ++code) {
    curve[code] = curve[last] * static_cast<double>(code) /
                  static_cast<double>(std::max<std::size_t>(last, 1));
  }
}

}  // namespace

PixelSamples sample_pixels(std::span<const ExposedFrame> stack, int channel, std::size_t most) {
  PixelSamples samples;
  if (stack.empty()) return samples;
  for (const ExposedFrame& frame : stack) samples.exposure_s.push_back(frame.exposure_s);
  const Image<std::uint16_t>& shape = stack.front().codes;
  const auto channels = static_cast<std::size_t>(shape.channels());
  const std::size_t pixels = shape.size() / channels;
  const std::size_t stride = std::max<std::size_t>(1, (pixels + most - 1) / most);
  for (std::size_t pixel = 0; pixel < pixels; pixel += stride) {
    std::vector<std::uint16_t> codes;
    codes.reserve(stack.size());
    for (const ExposedFrame& frame : stack) {
      codes.push_back(frame.codes.values()[pixel * channels + static_cast<std::size_t>(channel)]);
    }
    samples.codes.push_back(std::move(codes));
  }
  return samples;
}

std::vector<double> recover_debevec_malik(const std::vector<PixelSamples>& stacks, int bit_depth,
                                          double lambda, const std::string& name) {
  check_samples(stacks, name);
  const Knots knots(bit_depth);
  constexpr int n = Knots::count;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd coupling(n);
  // Each pixel's ln E is eliminated from its equations w² (g(z_j) - ln E - ln t_j)² at once.
  for (const PixelSamples& stack : stacks) {
    for (const std::vector<std::uint16_t>& codes : stack.codes) {
      coupling.setZero();
      double weights = 0.0;
      double times = 0.0;
      std::vector<int> touched;
      for (std::size_t j = 0; j < codes.size(); ++j) {
        const Place place = knots.at(codes[j]);
        const double w = place.hat * place.hat;
        const double log_time = std::log(stack.exposure_s[j]);
        const std::array<double, 2> phi{1.0 - place.weight_1, place.weight_1};
        for (int a = 0; a < 2; ++a) {
          for (int b = 0; b < 2; ++b) {
            matrix(place.knot + a, place.knot + b) += w * phi[a] * phi[b];
          }
          right[place.knot + a] += w * phi[a] * log_time;
          coupling[place.knot + a] += w * phi[a];
          touched.push_back(place.knot + a);
        }
        weights += w;
        times += w * log_time;
      }
      std::sort(touched.begin(), touched.end());
      touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
      for (const int a : touched) {
        for (const int b : touched) matrix(a, b) -= coupling[a] * coupling[b] / weights;
        right[a] -= coupling[a] * times / weights;
      }
    }
  }
  for (int k = 1; k + 1 < n; ++k) {
    const double w = lambda * Knots::hat(k);
    const Eigen::Vector3d second(w, -2.0 * w, w);
    matrix.block<3, 3>(k - 1, k - 1) += second * second.transpose();
  }
  matrix(n / 2, n / 2) += 1.0;  // g(128) = 0; nothing else fixes the constant
  const Eigen::VectorXd g = matrix.ldlt().solve(right);
  std::vector<double> curve;
  curve.reserve(static_cast<std::size_t>(knots.codes()));
  for (int code = 0; code < knots.codes(); ++code) {
    const Place place = knots.at(code);
    curve.push_back(
        std::exp(g[place.knot] * (1.0 - place.weight_1) + g[place.knot + 1] * place.weight_1));
  }
  return curve;
}

std::vector<double> recover_robertson(const std::vector<PixelSamples>& stacks, int bit_depth,
                                      int rounds, const std::string& name) {
  check_samples(stacks, name);
  const std::size_t count = std::size_t{1} << bit_depth;
  std::vector<double> bell(count);
  std::vector<double> curve(count);
  for (std::size_t code = 0; code < count; ++code) {
    const double share = static_cast<double>(code) / static_cast<double>(count - 1);
    bell[code] = robertson_bell(static_cast<float>(share));
    curve[code] = 2.0 * share;
  }
  constexpr double least_change = 1e-5;
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> sums(count, 0.0);
    std::vector<double> counts(count, 0.0);
    for (const PixelSamples& stack : stacks) {
      for (const std::vector<std::uint16_t>& codes : stack.codes) {
        double weighted = 0.0;
        double weights = 0.0;
        for (std::size_t j = 0; j < codes.size(); ++j) {
          const double t = stack.exposure_s[j];
          weighted += bell[codes[j]] * t * curve[codes[j]];
          weights += bell[codes[j]] * t * t;
        }
        if (!(weights > 0.0)) continue;
        const double radiance = weighted / weights;
        for (std::size_t j = 0; j < codes.size(); ++j) {
          if (bell[codes[j]] <= 0.0) continue;
          sums[codes[j]] += stack.exposure_s[j] * radiance;
          counts[codes[j]] += 1.0;
        }
      }
    }
    std::vector<double> next(count, 0.0);
    std::vector<std::uint8_t> known(count, 0);
    for (std::size_t code = 0; code < count; ++code) {
      if (counts[code] == 0.0) continue;
      next[code] = sums[code] / counts[code];
      known[code] = 1;
    }
    if (std::find(known.begin(), known.end(), 1) == known.end()) break;
    fill_gaps(next, known);
    const double middle = next[count / 2];
    double change = 0.0;
    for (std::size_t code = 0; code < count; ++code) {
      next[code] /= middle;
      change += std::abs(next[code] - curve[code]);
    }
    curve = std::move(next);
    if (change < least_change * static_cast<double>(count)) break;
  }
  return curve;
}

std::vector<double> normalised_response(std::vector<double> curve, double black_level) {
  make_rising(curve);
  const auto low = static_cast<std::size_t>(
      std::clamp(std::floor(black_level), 0.0, static_cast<double>(curve.size()) - 2.0));
  const double share = black_level - static_cast<double>(low);
  const double black = curve[low] + share * (curve[low + 1] - curve[low]);
  const double range = curve.back() - black;
  for (double& value : curve) value = (value - black) / range;
  return curve;
}

int make_rising(std::vector<double>& linear) {
  struct Pool {
    double sum;
    int count;
  };
  std::vector<Pool> pools;
  for (const double value : linear) {
    pools.push_back({value, 1});
    while (pools.size() > 1) {
      const Pool last = pools.back();
      const Pool before = pools[pools.size() - 2];
      if (before.sum / before.count < last.sum / last.count) break;
      pools.pop_back();
      pools.back() = {before.sum + last.sum, before.count + last.count};
    }
  }
  int changed = 0;
  std::size_t at = 0;
  for (const Pool& pool : pools) {
    if (pool.count > 1) changed += pool.count;
    for (int i = 0; i < pool.count; ++i) linear[at++] = pool.sum / pool.count;
  }
  const double least_step = 1e-9;
  for (std::size_t code = 1; code < linear.size(); ++code) {
    linear[code] = std::max(linear[code], linear[code - 1] + least_step);
  }
  return changed;
}

}  // namespace kappamu::capture

#include "inverse/problem/lit_face.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>

#include "core/error.h"
#include "core/numbers/median.h"
#include "core/optics.h"
#include "core/shown_text.h"
#include "forward/analytic/homogeneous_block.h"
#include "forward/lateral/lateral_reflectance.h"

namespace kappamu::inverse {

namespace {

// Indices that the table of forward/lateral holds.
constexpr double least_index = 1.33, most_index = 1.5;
constexpr double most_anisotropy = 0.95;  // of the same, and its end
// Beyond this the reflectance depends on the phase function, not on g alone [1/mm].
constexpr double highest_frequency = 0.5;
constexpr double fast_share = 1e-3;

Eigen::Map<const Eigen::MatrixXd> as_image(const std::vector<double>& maps, std::size_t picture,
                                           const FaceShape& face) {
  return {maps.data() + picture * face.cells(), face.nu, face.nv};
}

/// Of wave (u, v) of the face's cosines [1/mm].
double frequency_of(const FaceShape& face, double voxel_mm, Eigen::Index u, Eigen::Index v) {
  return std::hypot(0.5 * static_cast<double>(u) / face.nu,
                    0.5 * static_cast<double>(v) / face.nv) /
         voxel_mm;
}

/// μa and σs' [1/mm]; without scattering the table has no answer.
std::array<double, 2> coefficients(double kappa, double mu) {
  const double transport = 1.0 / (3.0 * kappa);
  return {mu, std::max(transport - mu, 0.01 * transport)};
}

/// Standard deviation of white noise in one picture [v][u] under slowly varying `light` [v][u]: of
/// what light explains, offset and slope, the second difference in both directions, two pixels
/// apart, since neighbours share camera pixels. 0 where too little is used.
double white_noise(const FaceShape& face, std::span<const float> value,
                   std::span<const double> light, std::span<const std::uint8_t> used) {
  double count = 0.0, mean_light = 0.0, mean = 0.0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (used[i] == 0) continue;
    ++count;
    mean_light += (light[i] - mean_light) / count;
    mean += (value[i] - mean) / count;
  }
  double square = 0.0, product = 0.0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (used[i] == 0) continue;
    square += (light[i] - mean_light) * (light[i] - mean_light);
    product += (light[i] - mean_light) * (value[i] - mean);
  }
  const double slope = square > 0.0 ? product / square : 0.0;
  constexpr int apart = 2;
  constexpr std::array<double, 3> difference{1.0, -2.0, 1.0};
  std::vector<double> sizes;
  for (int v = apart; v + apart < face.nv; ++v) {
    for (int u = apart; u + apart < face.nu; ++u) {
      double sum = 0.0;
      bool whole = true;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) {
          const auto i = static_cast<std::size_t>((v + apart * dv) * face.nu + u + apart * du);
          whole = whole && used[i] != 0;
          sum += difference[static_cast<std::size_t>(dv + 1)] *
                 difference[static_cast<std::size_t>(du + 1)] * (value[i] - slope * light[i]);
        }
      }
      if (whole) sizes.push_back(std::abs(sum));
    }
  }
  constexpr std::size_t enough = 50;
  if (sizes.size() < enough) return 0.0;
  constexpr double middle = 0.6744897501960817;  // of |e| of a standard normal number
  constexpr double white = 6.0;                  // √Σ of the squared weights
  return upper_median(std::move(sizes)) / (middle * white);
}

std::vector<double> in_voxels(const SurfaceMeasurements& m, int pattern) {
  const std::size_t cells = m.lit_shape().cells();
  const auto first =
      m.irradiance.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(pattern) * cells);
  return {first, first + static_cast<std::ptrdiff_t>(cells)};
}

/// One picture's lit pixels, from `first` on, weigh alike: their variance is its mean over them, or
/// the square of their white noise where that is more. Weights by each noisy value would follow the
/// dark ones.
void weigh_alike(const FaceShape& face, const std::vector<double>& light, std::size_t first,
                 LitPixelUse& use) {
  SurfaceMeasurements& m = use.measurements;
  const auto part = [&](const auto& all) { return std::span(all).subspan(first, face.cells()); };
  const double noise = white_noise(face, part(m.value), light, part(m.mask));
  double count = 0.0, mean = 0.0, variance = 0.0;
  for (std::size_t i = first; i < first + face.cells(); ++i) {
    if (m.lit[i] == 0) continue;
    ++count;
    mean += (m.value[i] - mean) / count;
    variance += (m.variance[i] - variance) / count;
  }
  if (count == 0.0 || !(mean > 0.0)) return;
  if (noise / mean > use.noise) {
    use.noise = noise / mean;
    use.stated = std::sqrt(variance) / mean;
  }
  for (std::size_t i = first; i < first + face.cells(); ++i) {
    if (m.lit[i] != 0) m.variance[i] = static_cast<float>(std::max(variance, noise * noise));
  }
}

}  // namespace

LitFace::LitFace(const Problem& problem)
    : setup_(problem.setup),
      face_(problem.lit_shape()),
      patterns_(problem.patterns),
      index_(std::clamp(problem.setup.eta, least_index, most_index)),
      cosines_u_(face_.nu),
      cosines_v_(face_.nv) {
  for (int m = 0; m < patterns_; ++m) {
    if (problem.lateral.empty() || problem.lateral[static_cast<std::size_t>(m)] == 0) continue;
    pictures_.push_back(m);
    const Eigen::MatrixXd light = as_image(problem.irradiance, static_cast<std::size_t>(m), face_);
    irradiance_.insert(irradiance_.end(), light.data(), light.data() + light.size());
    waves_.push_back(to_waves(cosines_u_, cosines_v_, light));
  }
}

/// What open sides leave of the light that mirrors would keep, of each of pictures_ [v][u]; empty:
/// all.
std::vector<double> LitFace::by_sides(double kappa, double mu) const {
  if (setup_.sides == Sides::mirror) return {};
  std::vector<int> u(static_cast<std::size_t>(face_.nu)), v(static_cast<std::size_t>(face_.nv));
  std::iota(u.begin(), u.end(), 0);
  std::iota(v.begin(), v.end(), 0);
  const auto exitance = [&](Sides sides) {
    forward::GridSetup setup = setup_;
    setup.sides = sides;
    return forward::HomogeneousBlock(setup, setup.lit_face, irradiance_, {u, v})
        .exitance(kappa, mu);
  };
  std::vector<double> left = exitance(Sides::open);
  const std::vector<double> kept = exitance(Sides::mirror);
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = kept[i] > 0.0 ? left[i] / kept[i] : 1.0;
  return left;
}

std::vector<double> LitFace::exitance(double kappa, double mu) const {
  const auto [mua, musp] = coefficients(kappa, mu);
  const forward::LateralReflectance slab({index_, lit_anisotropy, setup_.thickness_mm()});
  const double enters = boundary_constants(index_).normal_transmittance;
  const double voxel_mm = setup_.shape.voxel_mm;
  constexpr int intervals = 512;  // linear between: within 2e-5
  const double highest = frequency_of(face_, voxel_mm, face_.nu, face_.nv);
  std::vector<double> reflectance;
  for (int k = 0; k <= intervals; ++k) {
    reflectance.push_back(enters * slab(highest * k / intervals, mua, musp).reflectance);
  }
  Eigen::MatrixXd answer(face_.nu, face_.nv);
  for (Eigen::Index v = 0; v < face_.nv; ++v) {
    for (Eigen::Index u = 0; u < face_.nu; ++u) {
      const double at = frequency_of(face_, voxel_mm, u, v) / highest * intervals;
      const auto below = static_cast<std::size_t>(at);
      const double share = at - std::floor(at);
      answer(u, v) = (1.0 - share) * reflectance[below] + share * reflectance[below + 1];
    }
  }
  const std::vector<double> sides = by_sides(kappa, mu);
  std::vector<double> all(static_cast<std::size_t>(patterns_) * face_.cells(), 0.0);
  for (std::size_t k = 0; k < pictures_.size(); ++k) {
    const Eigen::MatrixXd left = from_waves(cosines_u_, cosines_v_, waves_[k].cwiseProduct(answer));
    double* const picture = all.data() + static_cast<std::size_t>(pictures_[k]) * face_.cells();
    for (std::size_t i = 0; i < face_.cells(); ++i) {
      picture[i] =
          std::max(left.data()[i], 0.0) * (sides.empty() ? 1.0 : sides[k * face_.cells() + i]);
    }
  }
  return all;
}

double LitFace::error(double kappa, double mu) const {
  const auto [mua, musp] = coefficients(kappa, mu);
  const forward::LateralReflectance stated({index_, lit_anisotropy}),
      more({index_, std::min(lit_anisotropy + lit_anisotropy_deviation, most_anisotropy)}),
      less({index_, lit_anisotropy - lit_anisotropy_deviation});
  double largest = 0.0;
  for (const double f : {0.0, 0.5 * highest_frequency}) {
    const double by_g =
        0.5 * std::log(more(f, mua, musp).reflectance / less(f, mua, musp).reflectance);
    largest = std::max(largest, std::hypot(stated.relative_error(f, mua, musp), by_g));
  }
  return largest;
}

bool varies_slowly(const FaceShape& face, double voxel_mm, const std::vector<double>& irradiance) {
  const Eigen::MatrixXd waves =
      to_waves(CosineTransform(face.nu), CosineTransform(face.nv), as_image(irradiance, 0, face));
  const double highest = std::min(highest_frequency, 0.25 / voxel_mm);
  double slow = waves(0, 0) * waves(0, 0), fast = 0.0;
  for (Eigen::Index v = 0; v < face.nv; ++v) {
    for (Eigen::Index u = 0; u < face.nu; ++u) {
      if (u == 0 && v == 0) continue;
      (frequency_of(face, voxel_mm, u, v) > highest ? fast : slow) += waves(u, v) * waves(u, v);
    }
  }
  return slow > 0.0 && fast <= fast_share * slow;
}

LitPixelUse with_lit_pixels(const SurfaceMeasurements& m) {
  if (m.lit.empty()) throw InputError("no pixel was measured where light falls");
  if (m.light != Light::collimated) {
    throw InputError("where diffuse light falls, no table of transport is at hand");
  }
  if (m.eta < least_index || m.eta > most_index) {
    throw InputError("the table of transport holds for eta from " + shown_number(least_index) +
                     " to " + shown_number(most_index) + ", not for " + shown_number(m.eta));
  }
  LitPixelUse use{m};
  SurfaceMeasurements& used = use.measurements;
  const FaceShape face = m.lit_shape();
  if (used.mask.empty()) used.mask.assign(m.value.size(), 1);
  bool any = false;
  for (int pattern = 0; pattern < m.patterns; ++pattern) {
    const std::vector<double> light = in_voxels(m, pattern);
    const bool slow =
        m.seen_on(pattern) == m.lit_face && varies_slowly(face, m.grid.voxel_mm, light);
    for (std::size_t c = 0; c < m.channels.size(); ++c) {
      const std::size_t first =
          (c * static_cast<std::size_t>(m.patterns) + static_cast<std::size_t>(pattern)) *
          face.cells();
      for (std::size_t i = first; i < first + face.cells(); ++i) {
        if (used.lit[i] == 0) continue;
        used.lit[i] = slow ? 1 : 0;
        used.mask[i] = slow ? 1 : 0;
        any = any || slow;
      }
      if (slow) weigh_alike(face, light, first, use);
    }
  }
  if (!any) {
    throw InputError(
        "no pattern's light varies slowly enough over the face, as even light and "
        "sinusoids up to 0.5 /mm do");
  }
  return use;
}

void use_lit_pixels(SurfaceMeasurements& measurements) {
  try {
    measurements = with_lit_pixels(measurements).measurements;
  } catch (const InputError&) {
    return;  // its light is another
  }
}

}  // namespace kappamu::inverse

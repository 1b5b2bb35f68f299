#include "calib/light/shared_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/numbers/cosine_transform.h"
#include "core/numbers/octave.h"
#include "core/shown_text.h"

namespace kappamu::calib {
namespace {

/// Measured over 28 x 31 mm of even phantoms by an instrument for spatial frequency domain imaging
/// (docs/calibration.md, "Errors that pixels share").
constexpr SmoothError usual_instrument{2e-3, 5e-3};
/// Of the simulated rig, whose target and light are even (docs/calibration.md).
constexpr SmoothError unseen{1e-4, 1e-4};
constexpr SmoothError unseen_front_lit{4e-4, 8e-4};

/// Of the patterns that were photographed more than once, each pair's; nothing without any.
std::optional<double> repeated_error(const SurfaceMeasurements& m) {
  constexpr float dark = 0.1F;  // of the brightest value: room light and glare rule below
  const std::size_t lit = m.lit_shape().cells();
  const std::size_t seen = m.seen_shape().cells();
  double sum = 0.0;
  int pairs = 0;
  const auto light = [&](int pattern) {
    return m.irradiance.begin() + pattern * static_cast<std::ptrdiff_t>(lit);
  };
  for (int a = 0; a < m.patterns; ++a) {
    for (int b = a + 1; b < m.patterns; ++b) {
      if (m.seen_on(a) != m.seen_on(b)) continue;
      if (!std::equal(light(a), light(a) + static_cast<std::ptrdiff_t>(lit), light(b))) continue;
      for (std::size_t c = 0; c < m.channels.size(); ++c) {
        const std::size_t first = (c * m.patterns + a) * seen, second = (c * m.patterns + b) * seen;
        FaceMap map{m.seen_shape(), std::vector<double>(seen, 0.0), std::vector<double>(seen, 0.0)};
        const float brightest =
            *std::max_element(m.value.begin() + static_cast<std::ptrdiff_t>(first),
                              m.value.begin() + static_cast<std::ptrdiff_t>(first + seen));
        for (std::size_t i = 0; i < seen; ++i) {
          const double mean = 0.5 * (m.value[first + i] + m.value[second + i]);
          const bool used = m.mask.empty() || (m.mask[first + i] != 0 && m.mask[second + i] != 0);
          if (!used || mean < dark * brightest) continue;
          // Both err: half of the difference's square is each one's.
          map.relative[i] = (m.value[first + i] - m.value[second + i]) / (std::sqrt(2.0) * mean);
          map.variance[i] = 0.5 * (m.variance[first + i] + m.variance[second + i]) / (mean * mean);
        }
        const double error = octave_error(map);
        if (!std::isfinite(error)) continue;
        sum += error * error;
        ++pairs;
      }
    }
  }
  if (pairs == 0) return std::nullopt;
  return std::sqrt(sum / pairs);
}

std::string percent(double share) {
  return shown_number(100.0 * share, "%.2g") + " %";
}

}  // namespace

double octave_error(const FaceMap& map) {
  const FaceShape& face = map.shape;
  Eigen::MatrixXd image = Eigen::MatrixXd::Zero(face.nu, face.nv);
  double noise = 0.0, mean = 0.0;
  std::size_t used = 0;
  for (std::size_t i = 0; i < face.cells(); ++i) {
    if (!(map.variance[i] > 0.0)) continue;
    mean += map.relative[i];
    noise += map.variance[i];
    ++used;
  }
  if (2 * used < face.cells()) return std::numeric_limits<double>::quiet_NaN();
  mean /= static_cast<double>(used);
  noise /= static_cast<double>(used);
  for (std::size_t i = 0; i < face.cells(); ++i) {
    if (map.variance[i] > 0.0) image.data()[i] = map.relative[i] - mean;
  }
  const Eigen::MatrixXd waves = to_waves(CosineTransform(face.nu), CosineTransform(face.nv), image);
  // Shorter waves belong to the noise from voxel to voxel that the variances state.
  constexpr double shortest = 0.25;  // [1/voxel]
  double power = 0.0, of_one = 0.0;  // of_one: what an error of 1 in each octave has
  for (int v = 0; v < face.nv; ++v) {
    for (int u = 0; u < face.nu; ++u) {
      const double f = std::hypot(0.5 * u / face.nu, 0.5 * v / face.nv);
      if (f == 0.0 || f >= shortest) continue;
      of_one += 1.0 / octave_waves(f * f);
      power += waves(u, v) * waves(u, v) - noise * static_cast<double>(used) / face.cells();
    }
  }
  const double share_used = static_cast<double>(used) / static_cast<double>(face.cells());
  return of_one > 0.0 ? std::sqrt(std::max(0.0, power) / share_used / of_one) : 0.0;
}

SharedError shared_error(const capture::Session& session, const WhiteReference& white,
                         const SurfaceMeasurements& measurements) {
  if (session.smooth_error) return {*session.smooth_error, "stated by the session"};
  const std::optional<double> common = white.smooth_error;
  const std::optional<double> repeated = repeated_error(measurements);
  const std::optional<double> own = repeated ? repeated : white.level_error;
  SmoothError error = usual_instrument;
  std::string source = "not measured: those of a usual instrument";
  if (common || own) {
    constexpr double own_per_common = usual_instrument.own / usual_instrument.common;
    error = {common ? *common : *own / own_per_common, own ? *own : *common * own_per_common};
    source = std::string("common ") +
             (common ? "from the white target's unevenness" : "in proportion to own") + ", own " +
             (repeated ? "from patterns photographed twice"
              : own    ? "from the white target under several values"
                       : "in proportion to common");
  }
  const SmoothError& least = measurements.lit_is_seen() ? unseen_front_lit : unseen;
  error = {std::min(1.0, std::hypot(error.common, least.common)),
           std::min(1.0, std::hypot(error.own, least.own))};
  return {error, percent(error.common) + " common to all patterns, " + percent(error.own) +
                     " of each; " + source};
}

}  // namespace kappamu::calib

#include "inverse/validation/validation_patterns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "core/error.h"

namespace kappamu::inverse {

namespace {

using Point = std::array<double, 2>;

double distance(const Point& a, const Point& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1]);
}

/// Centroid of each pattern's light, as fractions of the lit face; the middle for none.
std::vector<Point> centroids(const SurfaceMeasurements& measurements) {
  const FaceShape lit = measurements.lit_shape();
  std::vector<Point> points;
  for (int m = 0; m < measurements.patterns; ++m) {
    Point sum{0.0, 0.0};
    double total = 0.0;
    for (int v = 0; v < lit.nv; ++v) {
      for (int u = 0; u < lit.nu; ++u) {
        const double light =
            measurements.irradiance[(static_cast<std::size_t>(m) * lit.nv + v) * lit.nu + u];
        sum[0] += light * (u + 0.5) / lit.nu;
        sum[1] += light * (v + 0.5) / lit.nv;
        total += light;
      }
    }
    points.push_back(total > 0.0 ? Point{sum[0] / total, sum[1] / total} : Point{0.5, 0.5});
  }
  return points;
}

template <class T>
std::vector<T> slices(const std::vector<T>& values, std::size_t outer, std::size_t patterns,
                      std::size_t cells, std::span<const int> chosen) {
  std::vector<T> kept;
  if (values.empty()) return kept;
  for (std::size_t c = 0; c < outer; ++c) {
    for (const int m : chosen) {
      const auto first = values.begin() + static_cast<std::ptrdiff_t>(
                                              (c * patterns + static_cast<std::size_t>(m)) * cells);
      kept.insert(kept.end(), first, first + static_cast<std::ptrdiff_t>(cells));
    }
  }
  return kept;
}

/// The pictures of the same light on the other face: they would show the fit what validates it.
void add_other_faces(const SurfaceMeasurements& measurements, std::vector<int>& chosen) {
  if (!measurements.two_faces()) return;
  const std::size_t cells = measurements.lit_shape().cells();
  const auto light = [&](int m) {
    return std::span(measurements.irradiance).subspan(static_cast<std::size_t>(m) * cells, cells);
  };
  for (int m = 0; m < measurements.patterns; ++m) {
    if (std::ranges::find(chosen, m) != chosen.end()) continue;
    const bool same = std::ranges::any_of(
        chosen, [&](int other) { return std::ranges::equal(light(m), light(other)); });
    if (same) chosen.push_back(m);
  }
  if (static_cast<int>(chosen.size()) == measurements.patterns) {
    throw InputError(
        "all pictures are of the light that would be kept out of the fit: one light "
        "is fitted without validation");
  }
}

}  // namespace

int usual_validation_count(int patterns) {
  constexpr int fewest = 4;
  constexpr int share = 16;
  return patterns < fewest ? 0 : std::max(1, patterns / share);
}

int count_lights(const SurfaceMeasurements& m) {
  const std::vector<double> irradiance(m.irradiance.begin(), m.irradiance.end());
  return Views(irradiance, m.patterns, m.seen_face, m.seen_faces).lights();
}

std::vector<int> choose_validation_patterns(const SurfaceMeasurements& measurements, int count) {
  if (count < 0 || count >= measurements.patterns) {
    throw InputError("cannot keep " + std::to_string(count) + " of " +
                     std::to_string(measurements.patterns) +
                     " patterns out of the fit; give fewer than were measured");
  }
  const std::vector<Point> points = centroids(measurements);
  const Point middle{0.5, 0.5};
  std::vector<int> inner(points.size());
  std::iota(inner.begin(), inner.end(), 0);
  // Equal distances up to rounding of the centroids keep the order of the patterns.
  const auto rank = [&](int m) {
    return std::lround(1e6 * distance(points[static_cast<std::size_t>(m)], middle));
  };
  std::stable_sort(inner.begin(), inner.end(), [&](int a, int b) { return rank(a) < rank(b); });
  const int quarter = std::max(count, measurements.patterns / 4);
  inner.resize(static_cast<std::size_t>(quarter));

  std::vector<int> chosen;
  while (static_cast<int>(chosen.size()) < count) {
    int best = inner.front();
    double farthest = -1.0;
    for (const int m : inner) {
      if (std::find(chosen.begin(), chosen.end(), m) != chosen.end()) continue;
      double nearest = std::numeric_limits<double>::infinity();
      for (const int other : chosen) {
        nearest = std::min(nearest, distance(points[static_cast<std::size_t>(m)],
                                             points[static_cast<std::size_t>(other)]));
      }
      if (nearest <= farthest) continue;
      farthest = nearest;
      best = m;
    }
    chosen.push_back(best);
  }
  add_other_faces(measurements, chosen);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

SurfaceMeasurements select_patterns(const SurfaceMeasurements& measurements,
                                    std::span<const int> patterns) {
  for (const int m : patterns) {
    if (m < 0 || m >= measurements.patterns) {
      throw InputError("there is no pattern " + std::to_string(m) + "; " +
                       std::to_string(measurements.patterns) + " were measured, numbered from 0");
    }
  }
  const std::size_t channels = measurements.channels.size();
  const auto count = static_cast<std::size_t>(measurements.patterns);
  const std::size_t lit = measurements.lit_shape().cells();
  const std::size_t seen = measurements.seen_shape().cells();
  SurfaceMeasurements selected;
  selected.grid = measurements.grid;
  selected.eta = measurements.eta;
  selected.lit_face = measurements.lit_face;
  std::vector<Face> faces;
  for (const int m : patterns) faces.push_back(measurements.seen_on(m));
  selected.seen_face = measurements.seen_face;
  set_seen_faces(std::move(faces), selected.seen_face, selected.seen_faces);
  selected.quantity = measurements.quantity;
  selected.light = measurements.light;
  selected.sides = measurements.sides;
  selected.channels = measurements.channels;
  selected.patterns = static_cast<int>(patterns.size());
  selected.cameras = measurements.cameras;
  selected.smooth_error = measurements.smooth_error;
  selected.irradiance = slices(measurements.irradiance, 1, count, lit, patterns);
  selected.value = slices(measurements.value, channels, count, seen, patterns);
  selected.variance = slices(measurements.variance, channels, count, seen, patterns);
  selected.mask = slices(measurements.mask, channels, count, seen, patterns);
  selected.lit = slices(measurements.lit, channels, count, seen, patterns);
  return selected;
}

SurfaceMeasurements without_patterns(const SurfaceMeasurements& measurements,
                                     std::span<const int> patterns) {
  std::vector<int> others;
  for (int m = 0; m < measurements.patterns; ++m) {
    if (std::find(patterns.begin(), patterns.end(), m) == patterns.end()) others.push_back(m);
  }
  return select_patterns(measurements, others);
}

ValidationScore validation_score(const Medium& medium, const SurfaceMeasurements& validation,
                                 int channel, const PredictOptions& options,
                                 const ModelError& model_error, const DataTermOptions& data_term) {
  const Problem problem = make_problem(validation, channel, options.convention, model_error);
  const double per_value = exitance_per_value(validation, problem.setup);
  ValidationScore score;
  PredictOptions of_channel = options;
  of_channel.channel = channel;
  score.prediction = predict(medium, validation, of_channel);
  std::vector<double> exitance;
  for (const float value : score.prediction) exitance.push_back(per_value * value);
  const DataTerm term = evaluate(problem, exitance, data_term);
  const std::size_t cells = problem.seen_shape().cells();
  score.chi2_per_value = term.chi2_per_value;
  const std::size_t first = score.prediction.size() * static_cast<std::size_t>(channel);
  score.pattern_error.resize(static_cast<std::size_t>(validation.patterns));
  for (std::size_t i = 0; i < score.prediction.size(); ++i) {
    if (problem.weight[i] == 0.0) continue;
    score.pattern_error[i / cells].add(per_value * score.prediction[i], problem.data[i],
                                       per_value * per_value * validation.variance[first + i]);
  }
  for (const AppearanceError& error : score.pattern_error) score.error.add(error);
  return score;
}

}  // namespace kappamu::inverse

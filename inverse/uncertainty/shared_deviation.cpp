#include "inverse/uncertainty/shared_deviation.h"

#include <algorithm>
#include <cmath>

#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::shared_deviation;

struct Spread {
  double sum = 0.0, squares = 0.0;
  int count = 0;

  void add(double value) {
    sum += value;
    squares += value * value;
    ++count;
  }
  double mean() const { return sum / count; }
  double variance() const { return std::max(0.0, squares / count - mean() * mean()); }
};

}  // namespace

double SharedDeviation::kappa_at(std::size_t slice) const {
  return slice_log_kappa.empty() ? log_kappa : std::max(log_kappa, slice_log_kappa.at(slice));
}

double SharedDeviation::mu_at(std::size_t slice) const {
  return slice_log_mu.empty() ? log_mu : std::max(log_mu, slice_log_mu.at(slice));
}

double contrast_deviation(const Volume<double>& kappa, Face lit) {
  const GridShape& shape = kappa.shape();
  const FaceShape face = face_shape(shape, lit);
  Spread means;
  double within = 0.0;
  for (int depth = 0; depth < shape.extent(axis_of(lit)); ++depth) {
    Spread layer;
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        layer.add(std::log(kappa[face_cell(shape, lit, u, v, depth)]));
      }
    }
    means.add(layer.mean());
    within = std::max(within, layer.variance());
  }
  return std::hypot(share_within_layer * std::sqrt(within),
                    share_of_means * std::sqrt(means.variance()));
}

SharedDeviation shared_deviation(double contrast, const EvenChange& unresolved) {
  return {std::hypot(contrast, unresolved_kappa_of_truth * unresolved.log_kappa),
          std::hypot(mu_over_kappa * contrast, unresolved_mu_of_truth * unresolved.log_mu)};
}

}  // namespace kappamu::inverse

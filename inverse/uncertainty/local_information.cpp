#include "inverse/uncertainty/local_information.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "core/numbers/gaussian_sum.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::local_information;

void distribute(Vector& variance, const Vector& beforehand, const Vector& sensitivity,
                const MediumSpace& space) {
  const Face across = all_faces[2 * static_cast<std::size_t>(space.depth_axis)];
  const FaceShape face = face_shape(space.shape, across);
  const Vector inside = gaussian_sum(Vector(face.cells(), 1.0), face, pooling, 1);
  std::vector<std::size_t> layer(face.cells());  // its voxels
  Vector information(face.cells());
  for (int depth = 0; depth < space.depth(); ++depth) {
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        layer[static_cast<std::size_t>(v * face.nu + u)] =
            face_cell(space.shape, across, u, v, depth);
      }
    }
    for (std::size_t k = 0; k < layer.size(); ++k) {
      information[k] = sensitivity[layer[k]] * sensitivity[layer[k]];
    }
    information = gaussian_sum(information, face, pooling, 1);
    for (std::size_t k = 0; k < layer.size(); ++k) information[k] /= inside[k];
    const double mean = std::accumulate(information.begin(), information.end(), 0.0) /
                        static_cast<double>(layer.size());
    if (mean <= 0.0) continue;
    for (std::size_t k = 0; k < layer.size(); ++k) {
      double& here = variance[layer[k]];
      const double before = 1.0 / beforehand[layer[k]];
      here = 1.0 / (before + std::max(0.0, 1.0 / here - before) * information[k] / mean);
    }
  }
}

}  // namespace

CoefficientPair distributed(CoefficientPair variance, const CoefficientPair& beforehand,
                            const CoefficientPair& sensitivity, const MediumSpace& space) {
  distribute(variance.log_kappa, beforehand.log_kappa, sensitivity.log_kappa, space);
  distribute(variance.log_mu, beforehand.log_mu, sensitivity.log_mu, space);
  return variance;
}

}  // namespace kappamu::inverse

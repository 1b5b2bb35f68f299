#include "core/numbers/gaussian_sum.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <numbers>

namespace kappamu {

std::vector<double> gaussian_sum(const std::vector<double>& map, FaceShape face, double width,
                                 int power) {
  if (width == 0.0) return map;
  const int reach = static_cast<int>(std::ceil(3.0 * width));
  std::vector<double> kernel;
  for (int d = 0; d <= reach; ++d) kernel.push_back(std::exp(-0.5 * power * d * d / width / width));
  const auto along = [&](const std::vector<double>& from, int count, int stride, int lines,
                         int line_stride) {
    std::vector<double> to(from.size(), 0.0);
    for (int line = 0; line < lines; ++line) {
      for (int i = 0; i < count; ++i) {
        double sum = 0.0;
        for (int j = std::max(0, i - reach); j <= std::min(count - 1, i + reach); ++j) {
          sum += kernel[static_cast<std::size_t>(std::abs(i - j))] *
                 from[static_cast<std::size_t>(line * line_stride + j * stride)];
        }
        to[static_cast<std::size_t>(line * line_stride + i * stride)] = sum;
      }
    }
    return to;
  };
  return along(along(map, face.nu, 1, face.nv, face.nu), face.nv, face.nu, face.nu, 1);
}

Volume<double> gaussian_means(const Volume<double>& field, Face from,
                              const std::vector<double>& fwhm_mm) {
  const GridShape& shape = field.shape();
  const FaceShape face = face_shape(shape, from);
  Volume<double> means(shape);
  const int depth = shape.extent(axis_of(from));
  for (int k = 0; k < depth; ++k) {
    const double width =
        fwhm_mm[static_cast<std::size_t>(k)] / std::sqrt(8.0 * std::numbers::ln2) / shape.voxel_mm;
    std::vector<double> layer(face.cells(), 0.0);
    double weights = 0.0;
    for (int j = 0; j < depth; ++j) {
      const double weight = j == k ? 1.0 : std::exp(-0.5 * std::pow((j - k) / width, 2));
      weights += weight;
      if (weight == 0.0) continue;
      for (int v = 0; v < face.nv; ++v) {
        for (int u = 0; u < face.nu; ++u) {
          layer[static_cast<std::size_t>(v * face.nu + u)] +=
              weight * field[face_cell(shape, from, u, v, j)];
        }
      }
    }
    layer = gaussian_sum(layer, face, width, 1);
    const std::vector<double> inside =
        gaussian_sum(std::vector<double>(face.cells(), weights), face, width, 1);
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        const auto i = static_cast<std::size_t>(v * face.nu + u);
        means[face_cell(shape, from, u, v, k)] = layer[i] / inside[i];
      }
    }
  }
  return means;
}

}  // namespace kappamu

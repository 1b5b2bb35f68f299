#include "core/numbers/gaussian_sum.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>

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

}  // namespace kappamu

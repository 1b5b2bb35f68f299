#include "forward/dipole/sum_check.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/random.h"

namespace kappamu::forward::dipole {

namespace {

constexpr std::size_t checked_triangles = 32;

}  // namespace

SumCheck::SumCheck(const TriangleMesh& mesh, const Surface& surface, std::span<const double> area,
                   std::uint64_t seed)
    : mesh_(mesh), surface_(surface) {
  std::vector<double> sum(surface.size());
  std::partial_sum(area.begin(), area.end(), sum.begin());
  for (std::size_t i = 0; i < checked_triangles; ++i) {
    const double at = sum.back() * (static_cast<double>(i) + uniform(key_of({seed, i}))) /
                      static_cast<double>(checked_triangles);
    const auto found = std::upper_bound(sum.begin(), sum.end(), at);
    checked_.push_back(std::min(static_cast<std::size_t>(found - sum.begin()), surface.size() - 1));
  }
}

std::vector<double> SumCheck::exact(const Profile& profile, Placement placement,
                                    std::span<const double> irradiance) const {
  return direct_sum(mesh_, surface_, profile, placement, irradiance, checked_);
}

double SumCheck::error(std::span<const double> exact, std::span<const double> exitance) const {
  std::vector<double> here;
  for (const std::size_t t : checked_) here.push_back(exitance[t]);
  if (std::any_of(exact.begin(), exact.end(), [](double value) { return value > 0.0; })) {
    return difference(exact, here);
  }
  return std::any_of(exitance.begin(), exitance.end(), [](double value) { return value > 0.0; })
             ? 1.0
             : 0.0;
}

double SumCheck::difference(std::span<const double> exact, std::span<const double> other) const {
  double squares = 0.0, size = 0.0;
  for (std::size_t i = 0; i < checked_.size(); ++i) {
    squares += std::pow(other[i] - exact[i], 2);
    size += exact[i] * exact[i];
  }
  return size > 0.0 ? std::sqrt(squares / size) : 0.0;
}

}  // namespace kappamu::forward::dipole

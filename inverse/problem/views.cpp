#include "inverse/problem/views.h"

#include <algorithm>
#include <numeric>

namespace kappamu::inverse {

Views::Views(std::span<const double> irradiance, int pictures, Face face,
             const std::vector<Face>& faces)
    : faces_(face) {
  const auto count = static_cast<std::size_t>(pictures);
  if (faces.empty()) {
    first_.resize(count);
    std::iota(first_.begin(), first_.end(), std::size_t{0});
    return;
  }
  faces_ = forward::SeenFaces({face, opposite(face)});
  const std::size_t cells = irradiance.size() / count;
  const auto light = [&](std::size_t m) { return irradiance.subspan(m * cells, cells); };
  for (std::size_t m = 0; m < count; ++m) {
    const auto known = std::find_if(first_.begin(), first_.end(), [&](std::size_t other) {
      return std::ranges::equal(light(m), light(other));
    });
    light_.push_back(static_cast<std::size_t>(known - first_.begin()));
    if (known == first_.end()) first_.push_back(m);
    face_.push_back(faces[m] == face ? 0 : 1);
  }
}

std::vector<double> Views::of_lights(std::vector<double> of_pictures) const {
  if (plain()) return of_pictures;
  const std::size_t size = of_pictures.size() / light_.size();
  std::vector<double> kept(first_.size() * size);
  for (std::size_t l = 0; l < first_.size(); ++l) {
    std::copy_n(of_pictures.begin() + static_cast<std::ptrdiff_t>(first_[l] * size), size,
                kept.begin() + static_cast<std::ptrdiff_t>(l * size));
  }
  return kept;
}

std::vector<double> Views::pictures(std::vector<double> exitance) const {
  if (plain()) return exitance;
  const std::size_t pixels = exitance.size() / (first_.size() * faces_.list.size());
  std::vector<double> maps(light_.size() * pixels);
  for (std::size_t m = 0; m < light_.size(); ++m) {
    std::copy_n(exitance.begin() + static_cast<std::ptrdiff_t>(place(m) * pixels), pixels,
                maps.begin() + static_cast<std::ptrdiff_t>(m * pixels));
  }
  return maps;
}

std::vector<double> Views::exitance(std::vector<double> pictures) const {
  if (plain()) return pictures;
  const std::size_t pixels = pictures.size() / light_.size();
  std::vector<double> all(first_.size() * faces_.list.size() * pixels, 0.0);
  for (std::size_t m = 0; m < light_.size(); ++m) {
    for (std::size_t k = 0; k < pixels; ++k) {
      all[place(m) * pixels + k] += pictures[m * pixels + k];
    }
  }
  return all;
}

}  // namespace kappamu::inverse

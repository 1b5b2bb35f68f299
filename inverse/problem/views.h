// The pictures of a problem, [M][v][u], and the solves they come from: a light whose block is seen
// on two faces is solved once and gives two pictures.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/grid.h"
#include "forward/operator.h"

namespace kappamu::inverse {

class Views {
 public:
  /// `irradiance` [M][...] of each picture. `faces` [M] of each; empty: all are seen on `face`, and
  /// every picture has a light of its own.
  Views(std::span<const double> irradiance, int pictures, Face face,
        const std::vector<Face>& faces);

  const forward::SeenFaces& faces() const { return faces_; }
  /// L, different ones.
  int lights() const { return static_cast<int>(first_.size()); }
  /// [L][...] of values [M][...] that pictures of one light have alike.
  std::vector<double> of_lights(std::vector<double> of_pictures) const;
  /// [M][v][u] of exitance [L][face][v][u].
  std::vector<double> pictures(std::vector<double> exitance) const;
  /// Its transpose: what no picture shows is 0.
  std::vector<double> exitance(std::vector<double> pictures) const;

 private:
  bool plain() const { return faces_.list.size() == 1; }
  /// Where picture m stands in exitance, in maps.
  std::size_t place(std::size_t m) const { return light_[m] * faces_.list.size() + face_[m]; }

  forward::SeenFaces faces_;
  std::vector<std::size_t> first_;  ///< [L] first picture of each light
  std::vector<std::size_t> light_;  ///< [M]; not filled where there is one face
  std::vector<std::size_t> face_;   ///< [M] in faces(); the same
};

}  // namespace kappamu::inverse

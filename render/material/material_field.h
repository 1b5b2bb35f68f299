// Coefficients that vary over an object: a function of the place in it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>

#include "core/object_medium.h"

namespace kappamu::render {

/// A point of an object and the point of its surface that is closest to it.
struct Place {
  Eigen::Vector3d point{0.0, 0.0, 0.0};    ///< in the object's frame [mm]
  double depth = 0.0;                      ///< below the surface, 0 outside [mm]
  Eigen::Vector3d surface{0.0, 0.0, 0.0};  ///< [mm]
  Eigen::Vector3d normal{0.0, 0.0, 1.0};   ///< outward there, of unit length
  int triangle = 0;                        ///< that holds it
  Eigen::Vector3d weights{1.0, 0.0, 0.0};  ///< barycentric
};

/// κ and μ of R, G, B.
using ColourCoefficients = std::array<Coefficients, 3>;

class MaterialField {
 public:
  virtual ~MaterialField() = default;
  virtual ColourCoefficients at(const Place& place) const = 0;
  /// Size of its smallest structure [mm]; infinite where it has none.
  virtual double detail_mm() const { return std::numeric_limits<double>::infinity(); }
  /// Whether at() asks for the point alone at all depths from `shallow` to `deep` [mm], one of
  /// which the place then states.
  virtual bool of_point_alone(double /*shallow*/, double /*deep*/) const { return false; }
};

}  // namespace kappamu::render

// The one door into the inverse problem: what the surface of a block sends out under each light
// pattern. Synthetic, real and Monte Carlo data all enter here (docs/formats.md, "Surface
// measurements").
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/grid.h"
#include "core/names.h"

namespace kappamu {

enum class Quantity {
  exitance,        ///< flux per area leaving the surface, in units of the rig's white irradiance
  radiance_normal  ///< radiance along the outward normal, in the same unit per steradian
};
enum class Light {
  collimated,  ///< a projector's beam at normal incidence: first-collision source
  diffuse      ///< light entering diffusely: boundary source
};
enum class Sides {
  open,   ///< Robin condition on the four side faces, as on the others
  mirror  ///< no flux through the four side faces
};

inline constexpr Names<Quantity, 2> quantity_names{
    {{"exitance", Quantity::exitance}, {"radiance_normal", Quantity::radiance_normal}}};
inline constexpr Names<Light, 2> light_names{
    {{"collimated", Light::collimated}, {"diffuse", Light::diffuse}}};
inline constexpr Names<Sides, 2> sides_names{{{"open", Sides::open}, {"mirror", Sides::mirror}}};
inline std::string to_string(Quantity quantity) {
  return name_of(quantity_names, quantity);
}
inline std::string to_string(Light light) {
  return name_of(light_names, light);
}
inline std::string to_string(Sides sides) {
  return name_of(sides_names, sides);
}
Quantity quantity_from_string(const std::string& name);  ///< throws InputError
Light light_from_string(const std::string& name);        ///< throws InputError
Sides sides_from_string(const std::string& name);        ///< throws InputError

/// Errors that neighbouring pixels have in common, of scale, response, light and pose: root mean
/// square of each octave of spatial frequency, relative to the values [dimensionless].
struct SmoothError {
  double common = 0.0;  ///< shared by all patterns
  double own = 0.0;     ///< of each pattern by itself
  bool none() const { return common == 0.0 && own == 0.0; }
  bool operator==(const SmoothError&) const = default;
};

/// Where pinhole cameras stand, at most one before each face [mm], in the block's frame: the outer
/// corner of voxel (0, 0, 0) is the origin.
using Cameras = std::map<Face, Eigen::Vector3d>;

struct SurfaceMeasurements {
  GridShape grid;
  double eta = 1.3;  ///< relative refractive index of the medium [dimensionless]
  Face lit_face = Face::z_minus;
  Face seen_face = Face::z_plus;  ///< of the first pattern; of all where seen_faces is empty
  /// [M] of each pattern, where some are seen on seen_face and some on its opposite; else empty.
  std::vector<Face> seen_faces;
  Quantity quantity = Quantity::exitance;
  Light light = Light::collimated;
  Sides sides = Sides::open;
  std::vector<std::string> channels;  ///< C names, such as "R", "G", "B"
  int patterns = 0;                   ///< M
  /// That took the pictures, where it is known that `value` is radiance over radiance_per_exitance:
  /// transport then predicts the radiance towards them. Empty: `value` is exitance.
  Cameras cameras;

  std::vector<float>
      irradiance;  ///< [M][v][u] on the lit face, incident before Fresnel, relative to white
  std::vector<float> value;  ///< [C][M][v][u] mean over each surface voxel of the seen face
  std::vector<float>
      variance;              ///< [C][M][v][u] variance of `value`, its unit squared; > 0 where used
  SmoothError smooth_error;  ///< of `value`, beside its variance
  std::vector<std::uint8_t> mask;  ///< [C][M][v][u] 1 = use, 0 = leave out; empty = use all
  /// [C][M][v][u] 1 = measured where light falls, which diffusion does not describe, and left out
  /// by `mask` for that alone; empty: none.
  std::vector<std::uint8_t> lit;

  FaceShape lit_shape() const { return face_shape(grid, lit_face); }
  FaceShape seen_shape() const { return face_shape(grid, seen_face); }
  bool two_faces() const { return !seen_faces.empty(); }
  bool lit_is_seen() const { return two_faces() || lit_face == seen_face; }
  Face seen_on(int pattern) const {
    return two_faces() ? seen_faces[static_cast<std::size_t>(pattern)] : seen_face;
  }
};

/// The faces of some patterns as `seen_face` and `seen_faces` state them: a list of one face alone
/// is no list.
void set_seen_faces(std::vector<Face> of_patterns, Face& seen_face, std::vector<Face>& seen_faces);

/// Throws InputError naming the field unless sizes agree and every used value is finite with a
/// positive finite variance. `source` names the folder it came from.
void validate(const SurfaceMeasurements& measurements, const std::string& source);

}  // namespace kappamu

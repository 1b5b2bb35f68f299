// Deformations of a mesh's vertices: each moves points, globally or inside a ball with a soft edge.
// Twist and bend are A. Barr's (Global and local deformations of solid primitives, SIGGRAPH 1984),
// noise along the normals is [M] 6, figure 6.5. Lengths in mm, in the object's frame.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/mesh/triangle_mesh.h"
#include "core/names.h"

namespace kappamu::render {

/// The ball that a deformation is limited to. The weight is 1 inside, 0 outside, and falls over the
/// outer share `edge` of the radius, its slope continuous.
struct DeformBrush {
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  double radius_mm = 1.0;
  double edge = 1.0;  ///< 0 to 1

  double weight(const Eigen::Vector3d& point) const;
  bool operator==(const DeformBrush&) const = default;
};

/// What `amount` moves a point of weight 1 by, and which other parameters count:
enum class DeformKind {
  pull,     ///< mm along `axis`; needs a brush
  dent,     ///< mm inwards, along the mean normal in the brush, which it needs; below 0: a bump
  twist,    ///< degrees about `axis` through `centre_mm`, growing over `length_mm` of it
  bend,     ///< degrees that the stretch `length_mm` of `axis` turns by, towards `towards`
  inflate,  ///< mm along the normal
  noise,    ///< mm along the normal times smooth noise between -1 and 1
  scale     ///< factor about `centre_mm`, along `axis` where there is one, else in all directions
};

/// Amounts by name, in their units, within bounds.
struct DeformAmount {
  const char* name;
  double least, most;
};
inline constexpr Names<DeformKind, 7> deform_kinds{{{"pull", DeformKind::pull},
                                                    {"dent", DeformKind::dent},
                                                    {"twist", DeformKind::twist},
                                                    {"bend", DeformKind::bend},
                                                    {"inflate", DeformKind::inflate},
                                                    {"noise", DeformKind::noise},
                                                    {"scale", DeformKind::scale}}};
DeformAmount amount_of(DeformKind kind);

struct Deformation {
  DeformKind kind = DeformKind::pull;
  double amount = 0.0;
  std::optional<DeformBrush> brush{};                   ///< none: the whole object
  std::optional<Eigen::Vector3d> axis{};                ///< of unit length; none: +y
  Eigen::Vector3d towards = Eigen::Vector3d::UnitX();   ///< of bend, not along the axis
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< of twist, bend and scale
  std::optional<double> length_mm{};  ///< centred at `centre_mm`; none: all of the object
  double wavelength_mm = 1.0;         ///< of noise
  Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();  ///< of noise: moves it through space
  std::uint64_t seed = 1;                               ///< of noise

  bool operator==(const Deformation&) const = default;
};

/// "twist of 90 degrees".
std::string described(const Deformation& deformation);

/// One after the other; triangles stay. Throws InputError where a brush holds no vertex.
TriangleMesh deformed(TriangleMesh mesh, std::span<const Deformation> deformations);

/// The same, of a body that must remain one. Throws InputError naming the first deformation that
/// makes the surface cross itself, turn inside out, or press a triangle flat.
TriangleMesh deformed_body(const TriangleMesh& rest, std::span<const Deformation> deformations);

}  // namespace kappamu::render

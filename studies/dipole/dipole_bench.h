// Dipole models measured: cost and error of the hierarchy in [M]'s three modes, form factors over a
// random sweep, profiles against transport in a half-space, and the energy of thin cylinders. Every
// number of docs/dipole.md.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "device/context.h"
#include "forward/dipole/profile/profile.h"
#include "studies/subject.h"

namespace kappamu::studies {

/// Of a torus, around the tube and around the torus: 2·m·n triangles.
struct Quads {
  int tube, around;
};
/// [M] Table 3: 2,016 to 500,240 triangles.
inline constexpr std::array<Quads, 5> hierarchy_quads{
    {{16, 63}, {34, 120}, {66, 248}, {132, 499}, {260, 962}}};

/// Of the form of [M]'s ring.
TriangleMesh torus(const Quads& quads, double size_mm);
/// Of Jensen et al. 2001 at η = 1.3, lengths times `scale`.
std::vector<forward::dipole::Profile> red_green_blue_marble(double scale);

/// One torus on one device.
struct HierarchyCost {
  Json row;                              ///< of section hierarchy
  std::vector<Eigen::Array4f> exitance;  ///< of the last frame on the fly
};
HierarchyCost hierarchy_cost(device::Context& context, const Quads& quads, int repetitions,
                             std::uint64_t seed);

/// Rows per number of triangles.
void dipole_hierarchy(const Request& request, Progress& progress, const Save& save);
/// Rows per mesh and kind of list: its steps by one work-item, and shared by a group.
void dipole_lists(const Request& request, Progress& progress, const Save& save);
/// Rows per size of a marble torus: near triangles by form factors and by even points ([M] table
/// 5).
void dipole_point_sampling(const Request& request, Progress& progress, const Save& save);
/// Rows per object that deforms.
void dipole_deform(const Request& request, Progress& progress, const Save& save);
/// Rows per method and criterion.
void dipole_form_factors(const Request& request, Progress& progress, const Save& save);
/// Rows per albedo and refractive index.
void dipole_profiles(const Request& request, Progress& progress, const Save& save);
/// Rows per scene, kind of samples and their number.
void dipole_importance(const Request& request, Progress& progress, const Save& save);
/// Rows per height of a marble cylinder.
void dipole_energy(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::studies

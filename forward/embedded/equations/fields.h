// Between fields on the unknowns and what lies on the surface or in the cubes. Loads and means use
// the same weights, so that reciprocity is exact.
#pragma once

#include "core/object_medium.h"
#include "forward/embedded/equations/node_space.h"
#include "forward/embedded/geometry/cut_mesh.h"

namespace kappamu::forward::embedded {

/// Values of a field at a cube's corners, x fastest.
std::array<double, 8> corner_values(const NodeSpace& space, std::size_t cube,
                                    const std::vector<double>& field);
/// Adds a power per corner of a cube [mm²] to a load.
void add_load(const NodeSpace& space, std::size_t cube, const std::array<double, 8>& power,
              std::vector<double>& load);

/// Adds ∫ flux N dA, a flux per triangle (dimensionless, of unit irradiance).
void add_surface_load(const CutMesh& mesh, const NodeSpace& space, const std::vector<double>& flux,
                      std::vector<double>& load);
/// Mean of a field over each of `triangles` triangles.
std::vector<double> triangle_means(const CutMesh& mesh, const NodeSpace& space,
                                   const std::vector<double>& field, std::size_t triangles);
/// ∫ μ φ dV [mm²].
double absorbed_power(const CutMesh& mesh, const NodeSpace& space,
                      const std::vector<Coefficients>& coefficients,
                      const std::vector<double>& field);

}  // namespace kappamu::forward::embedded

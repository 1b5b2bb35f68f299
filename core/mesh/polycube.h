// Polycubes: sets of cells of the integer lattice, mapped roughly into an object ([W] 5.1; Tarini
// et al. 2004). A polycube is valid where it is one piece, is not empty, and its surface is a
// manifold: no two of its cells meet in an edge or a corner alone.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace kappamu {

struct Polycube {
  std::vector<Eigen::Vector3i> cells;    ///< different, sorted: z slowest, x fastest
  std::vector<Eigen::Vector3i> corners;  ///< of all cells, different, sorted alike
  std::vector<Eigen::Vector3d> mapped;   ///< where each of `corners` lies in the object [mm]
  std::string file;                      ///< it was read from, for messages; empty: none
};

inline constexpr std::size_t most_polycube_cells = 2'000'000;

/// What is wrong with the set of cells, in words that follow "the polycube"; nothing: it is valid.
std::optional<std::string> polycube_problem(const std::vector<Eigen::Vector3i>& cells);

/// Whether the surface is a manifold at a corner, by which of the eight cells there are filled (bit
/// by the cell's place in x, y, z).
bool manifold_corner(unsigned filled);

/// Handles through the cells of a valid polycube, by the Euler characteristic of its surface.
int genus(const std::vector<Eigen::Vector3i>& cells);

/// Of a closed mesh of one component.
int genus(const TriangleMesh& mesh);

/// Cells sorted, each once; their corners, mapped to `origin` + `spacing`·place [mm].
Polycube lattice_polycube(std::vector<Eigen::Vector3i> cells, const Eigen::Vector3d& origin,
                          double spacing);

}  // namespace kappamu

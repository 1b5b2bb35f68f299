// Polygrids from closed meshes ([W] 5.1 and figure 4, without hand work).
//
// A polycube of the object's topology is found by voxels, refined to the number of nodes asked for,
// covered by one layer of cells (forward/polygrid/polygrid.h), and mapped into the object: the
// layer's outer corners lie on the surface and slide along it, all others are free, and one energy
// of angles and sizes evens them out. It takes the place of Turk's repulsion on the surface and of
// the variance of link lengths within ([W] 5.1), which both admit inverted cells.
#pragma once

#include <string>
#include <vector>

#include "core/mesh/polycube.h"
#include "core/mesh/triangle_mesh.h"
#include "core/progress.h"
#include "forward/polygrid/polygrid.h"

namespace kappamu::forward {

struct PolygridOptions {
  int cells = 20'000;  ///< interior nodes asked for; what comes is within a third of it
  /// Distance of the first interior nodes from the surface, along the inward normal, over the mean
  /// distance of neighbouring boundary nodes ([W] 5.1: a tenth); 0 leaves them at the middle of
  /// their cells, as finite volumes have it. Nodes never leave their cells.
  double first_layer = 0.1;
  /// That a person has drawn (io/polycube_file.h); `cells` chooses its refinement. None: one is
  /// found.
  const Polycube* drawn = nullptr;
};

struct PolygridQuality {
  /// Scaled Jacobian: least of a cell's eight corners, 1 for a box, not positive: inverted.
  double least_jacobian = 0.0, mean_jacobian = 0.0;
  int inverted = 0;  ///< cells whose scaled Jacobian is not positive
  /// Mean over cells of the largest over the smallest of three edge lengths (each the mean of
  /// four).
  double mean_aspect = 0.0;
  double volume_spread = 0.0;  ///< standard deviation of cells' volumes over their mean
  double volume_ratio = 0.0;   ///< of the polygrid's volume and the mesh's
  /// Distance of the mesh from the polygrid's surface, over the mean distance of boundary nodes.
  double mean_gap = 0.0, largest_gap = 0.0;
  int cells = 0, boundary_nodes = 0;
  int refinement = 1;        ///< cells of the grid along an edge of a cell of the polycube
  double cpu_seconds = 0.0;  ///< processor time of the whole
};

struct MadePolygrid {
  Polygrid grid;
  Polycube polycube;  ///< what the grid was refined from, its corners as mapped first
  PolygridQuality quality;
  std::vector<std::string> warnings;  ///< sentences
};

/// `mesh` as check_mesh() leaves it [mm]. Throws InputError, with one sentence, for options out of
/// range, a mesh that is not closed or has several components, and where no polycube of the
/// object's topology is found, or the drawn one has another, or its map leaves inverted cells.
MadePolygrid make_polygrid(const TriangleMesh& mesh, const PolygridOptions& options,
                           Progress& progress);

}  // namespace kappamu::forward

#include "forward/polygrid/shape/make_polygrid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/mesh/edges.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/closest_point.h"
#include "forward/polygrid/shape/layered_lattice.h"
#include "forward/polygrid/shape/map_cells.h"
#include "forward/polygrid/shape/measure_quality.h"
#include "forward/polygrid/shape/place_nodes.h"
#include "forward/polygrid/shape/voxel_polycube.h"

namespace kappamu::forward {

namespace {

constexpr int least_cells = 100, most_cells = 4'000'000;
/// Cells of the grid along an edge of a cell of the polycube, in the order they are tried. The
/// fewer cells the polycube has, the more regular is the grid and the worse are the cells of thin
/// parts: 2 is the largest that keeps them good on most objects (docs/polygrid.md).
constexpr std::array<int, 3> refinements{2, 1, 4};
constexpr int finest_drawn_refinement = 64;
/// Of a drawn polycube and the object: no map is tried beyond.
constexpr double other_size = 4.0;
/// What is asked of a grid. Where no refinement reaches it, the best is returned with a warning.
constexpr double good_jacobian = 0.2, good_gap = 1.5, good_volume = 0.1;  // of |ratio - 1|
/// Area of a mended voxel surface over the object's: 1.5 is the mean over directions, mending evens
/// it.
constexpr double voxel_area = 1.3;

constexpr MapEffort of_polycube{20, 0.3, 30.0, 1, false};
constexpr MapEffort of_refined{10, 10.0, 30.0, 1, false};
constexpr MapEffort of_grid{10, 10.0, 3000.0, 3, true};
/// Where the worst cell is below spare_jacobian after that.
constexpr MapEffort of_worst_cells{6, 300.0, 3000.0, 8, true};
constexpr double spare_jacobian = 0.25;

void refuse_unless_closed(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) throw InputError("The mesh has no triangles.");
  const std::vector<Edge> edges = edges_of(mesh.triangles);
  for_each_edge(edges, [&](std::size_t begin, std::size_t end) {
    if (end - begin == 2 && edges[begin].rises != edges[begin + 1].rises) return;
    throw InputError(
        "A polygrid is made of a closed mesh whose triangles face outwards; an edge of triangle " +
        std::to_string(edges[begin].triangle) + " is open or shared by triangles that disagree.");
  });
  const int components = oriented_alike(mesh.triangles).components;
  if (components != 1) {
    throw InputError("A polygrid is made of a mesh in one piece; this one has " +
                     std::to_string(components) + ".");
  }
}

double least_jacobian(const Polygrid& grid) {
  double least = 1.0;
  for (std::size_t k = 0; k < grid.cell.size(); ++k) {
    least = std::min(least, scaled_jacobian(grid, k));
  }
  return least;
}

class Maker {
 public:
  Maker(const TriangleMesh& mesh, const PolygridOptions& options, Progress& progress)
      : mesh_(mesh), options_(options), progress_(progress), start_(processor_seconds()) {
    if (options.cells < least_cells || options.cells > most_cells) {
      throw InputError("A polygrid has " + std::to_string(least_cells) + " to " +
                       std::to_string(most_cells) + " cells, not " + std::to_string(options.cells) +
                       ".");
    }
    if (!(options.first_layer >= 0.0 && options.first_layer <= 1.0)) {
      throw InputError("The polygrid's first layer lies 0 to 1 spacings below the surface, not " +
                       shown_number(options.first_layer, "%.2g") + ".");
    }
    refuse_unless_closed(mesh);
    const double volume = enclosed_volume(mesh);
    if (!(volume > 0.0)) {
      throw InputError(
          "A polygrid is made of a mesh whose triangles face outwards; these face in.");
    }
    surface_.emplace(mesh);
    const Surface samples = surface_of(mesh);
    target_.emplace(MapTarget{*surface_, mesh.vertices, volume});
    for (const double area : samples.area) area_ += area;
    target_->samples.insert(target_->samples.end(), samples.position.begin(),
                            samples.position.end());
  }

  /// Edge of voxels that gives as many cells as asked for, the layer upon them included [mm].
  double cell_edge() const {
    constexpr int passes = 50;
    double edge = std::cbrt(target_->volume / options_.cells);
    for (int pass = 0; pass < passes; ++pass) {
      edge = std::cbrt((target_->volume + voxel_area * area_ * edge) / options_.cells);
    }
    return edge;
  }

  /// Nothing: the map leaves inverted cells.
  std::optional<MadePolygrid> from(const Polycube& polycube, int refinement) {
    LayeredLattice lattice = layered_lattice(polycube, 0.5);
    const auto map = [&](const MapEffort& effort) {
      const std::string cells = std::to_string(lattice.grid.cell.size()) + " cells";
      return map_cells(lattice, *target_, effort, [&] {
        progress_.update("polygrid", 0.9 * lattice.cells_across / refinement, cells);
      });
    };
    if (!map(of_polycube)) return std::nullopt;
    MadePolygrid made;
    made.polycube = polycube;
    std::copy_n(lattice.grid.corner.begin(), polycube.mapped.size(), made.polycube.mapped.begin());
    while (lattice.cells_across < refinement) {
      int factor = 2;
      while (refinement / lattice.cells_across % factor != 0) ++factor;
      lattice = refined(lattice, factor);
      if (lattice.cells_across < refinement && !map(of_refined)) return std::nullopt;
    }
    if (!map(of_grid)) return std::nullopt;
    if (const double before = least_jacobian(lattice.grid); before < spare_jacobian) {
      const std::vector<Eigen::Vector3d> corner = lattice.grid.corner;
      if (!map(of_worst_cells) || least_jacobian(lattice.grid) <= before) {
        lattice.grid.corner = corner;
      }
    }
    made.grid = std::move(lattice.grid);
    place_nodes(made.grid, *surface_, options_.first_layer);
    made.quality = measure_quality(made.grid, mesh_);
    made.quality.refinement = refinement;
    if (made.quality.inverted > 0) return std::nullopt;
    return made;
  }

  MadePolygrid finished(MadePolygrid made) const {
    made.quality.cpu_seconds = processor_seconds() - start_;
    const PolygridQuality& quality = made.quality;
    if (quality.least_jacobian < good_jacobian) {
      made.warnings.push_back("The polygrid's worst cell has a scaled Jacobian of " +
                              shown_number(quality.least_jacobian, "%.2g") + ", below " +
                              shown_number(good_jacobian, "%.2g") +
                              ": the solution is less accurate there.");
    }
    if (quality.largest_gap > good_gap) {
      made.warnings.push_back(
          "The polygrid leaves parts of the object out, up to " +
          shown_number(quality.largest_gap * boundary_spacing(made.grid), "%.2g") +
          " mm away from it: they are too thin for its cells, take more.");
    }
    if (std::abs(quality.volume_ratio - 1.0) > good_volume) {
      made.warnings.push_back("The polygrid has " + shown_number(quality.volume_ratio, "%.2g") +
                              " times the object's volume, where parts are too thin for its cells: "
                              "take more.");
    }
    return made;
  }

 private:
  const TriangleMesh& mesh_;
  const PolygridOptions& options_;
  Progress& progress_;
  double start_, area_ = 0.0;
  std::optional<ClosestPoint> surface_;
  std::optional<MapTarget> target_;
};

bool good(const PolygridQuality& quality) {
  return quality.least_jacobian >= good_jacobian && quality.largest_gap <= good_gap &&
         std::abs(quality.volume_ratio - 1.0) <= good_volume;
}

/// Up to 3, larger is better.
double score(const PolygridQuality& quality) {
  return std::min(1.0, quality.least_jacobian / good_jacobian) +
         std::min(1.0, good_gap / quality.largest_gap) +
         std::min(1.0, good_volume / std::abs(quality.volume_ratio - 1.0));
}

/// From `options.drawn`.
MadePolygrid made_of_drawn(const TriangleMesh& mesh, const PolygridOptions& options,
                           Progress& progress) {
  const Polycube& polycube = *options.drawn;
  const std::string named =
      polycube.file.empty() ? "The polycube" : polycube.file + ": the polycube";
  if (const auto problem = polycube_problem(polycube.cells)) {
    throw InputError(named + " " + *problem + ".");
  }
  Maker maker(mesh, options, progress);
  if (genus(polycube.cells) != genus(mesh)) {
    throw InputError(named + " has genus " + std::to_string(genus(polycube.cells)) + ", the mesh " +
                     std::to_string(genus(mesh)) + "; give it as many holes as the object.");
  }
  Eigen::AlignedBox3d drawn;
  for (const Eigen::Vector3d& corner : polycube.mapped) drawn.extend(corner);
  const Eigen::AlignedBox3d object = bounding_box(mesh);
  const double size = drawn.diagonal().norm(), of_object = object.diagonal().norm();
  if (!drawn.intersects(object) || size > other_size * of_object || of_object > other_size * size) {
    throw InputError(named + " lies off the object or is of another size: its box has a diagonal " +
                     "of " + shown_number(size, "%.3g") + " mm, the object's one of " +
                     shown_number(of_object, "%.3g") +
                     " mm; draw it in mm about the middle of the object's box.");
  }
  const LayeredLattice lattice = layered_lattice(polycube, 0.5);
  const auto layer = static_cast<double>(lattice.grid.boundary_cell.size());
  const double core = static_cast<double>(polycube.cells.size());
  int refinement = 1;
  // Of the two counts about the one asked for, the closer.
  const auto count = [&](double n) { return core * n * n * n + layer * n * n; };
  while (refinement < finest_drawn_refinement && std::abs(count(refinement + 1) - options.cells) <
                                                     std::abs(count(refinement) - options.cells)) {
    ++refinement;
  }
  auto made = maker.from(polycube, refinement);
  if (!made) {
    throw InputError(named +
                     " gives a map into the object with inverted cells; draw it closer to " +
                     "the object's shape, in mm of the object's frame.");
  }
  return maker.finished(std::move(*made));
}

}  // namespace

MadePolygrid make_polygrid(const TriangleMesh& mesh, const PolygridOptions& options,
                           Progress& progress) {
  if (options.drawn != nullptr) return made_of_drawn(mesh, options, progress);
  Maker maker(mesh, options, progress);
  const int handles = genus(mesh);
  const double edge = maker.cell_edge();
  std::optional<MadePolygrid> best;
  bool mapped_none = true;
  for (const int refinement : refinements) {
    const auto polycube = voxel_polycube(mesh, refinement * edge, handles, [&] {
      progress.update("polygrid", 0.0, std::to_string(options.cells) + " cells");
    });
    if (!polycube) continue;
    mapped_none = false;
    auto made = maker.from(*polycube, refinement);
    if (!made) continue;
    if (!best || score(made->quality) > score(best->quality)) best = std::move(made);
    if (good(best->quality)) break;
  }
  if (best) return maker.finished(std::move(*best));
  throw InputError(mapped_none
                       ? "No polycube of " + std::to_string(options.cells) +
                             " cells has the object's topology, genus " + std::to_string(handles) +
                             ": its parts or holes are too thin for them; take more cells."
                       : "Every polygrid of " + std::to_string(options.cells) +
                             " cells has inverted ones in this object: take more cells.");
}

}  // namespace kappamu::forward

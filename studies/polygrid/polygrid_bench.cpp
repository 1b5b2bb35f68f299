#include "studies/polygrid/polygrid_bench.h"

#include <cstdint>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/mesh/shapes.h"
#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/shape/make_polygrid.h"
#include "io/mesh_file.h"
#include "io/npy.h"
#include "io/polycube_file.h"
#include "studies/polygrid/laplacian_weights.h"
#include "studies/subjects.h"

namespace kappamu::studies {

namespace {

constexpr double size_mm = 40.0;
constexpr int tessellation = 80;

struct Object {
  std::string name;
  TriangleMesh mesh;
};

std::vector<Object> objects_of(const Request& request) {
  std::vector<Object> objects;
  const std::vector<std::string> files = request.words("files");
  if (files.empty()) {
    for (const NamedShape& shape : named_shapes()) {
      objects.push_back({std::string(shape.name), make_shape(shape.name, size_mm, tessellation)});
    }
  }
  for (const std::string& file : files) {
    objects.push_back(
        {std::filesystem::path(file).stem().string(), fitted(io::read_body(file).mesh, size_mm)});
  }
  return objects;
}

/// What studies/polygrid_picture.py draws: corners of the boundary nodes' faces, each cell's scaled
/// Jacobian there, and what became of its six weights (WeightKind).
void write_surface(const forward::Polygrid& grid, const LaplacianWeights& weights,
                   const std::string& stem) {
  std::vector<float> faces, jacobians;
  std::vector<std::uint8_t> kinds;
  for (std::size_t k = 0; k < grid.boundary_cell.size(); ++k) {
    const auto cell = static_cast<std::size_t>(grid.boundary_cell[k]);
    for (const int c : forward::side_corners(grid.boundary_side[k])) {
      const auto corner =
          static_cast<std::size_t>(grid.cell_corners[cell][static_cast<std::size_t>(c)]);
      for (const double x : grid.corner[corner]) faces.push_back(static_cast<float>(x));
    }
    jacobians.push_back(static_cast<float>(forward::scaled_jacobian(grid, cell)));
    kinds.push_back(static_cast<std::uint8_t>(weights.kind[cell]));
  }
  io::write_npy(stem + "-faces.npy", {grid.boundary_cell.size(), 4, 3}, faces);
  io::write_npy(stem + "-jacobian.npy", {grid.boundary_cell.size()}, jacobians);
  io::write_npy(stem + "-weights.npy", {grid.boundary_cell.size()}, kinds);
}

Json measured(const Object& object, int cells, const Request& request, Progress& progress) {
  Json row{{"object", object.name}, {"asked", cells}};
  try {
    const forward::MadePolygrid made = forward::make_polygrid(
        object.mesh, {cells, forward::PolygridOptions{}.first_layer}, progress);
    const forward::PolygridQuality& q = made.quality;
    const LaplacianWeights weights = laplacian_weights(node_grid(made.grid));
    row.update({{"cells", q.cells},
                {"boundary", q.boundary_nodes},
                {"refinement", q.refinement},
                {"inverted", q.inverted},
                {"least_jacobian", q.least_jacobian},
                {"mean_jacobian", q.mean_jacobian},
                {"aspect", q.mean_aspect},
                {"negative_weights", weights.negative},
                {"ill_conditioned", weights.ill_conditioned},
                {"volume_spread", q.volume_spread},
                {"volume_ratio", q.volume_ratio},
                {"mean_gap", q.mean_gap},
                {"largest_gap", q.largest_gap},
                {"cpu_s", q.cpu_seconds},
                {"warnings", made.warnings}});
    if (request.has("write")) {
      const std::string stem =
          (request.folder / (object.name + "-" + std::to_string(cells))).string();
      write_surface(made.grid, weights, stem);
      io::write_polycube(made.polycube, stem + ".polycube.json");
    }
  } catch (const InputError& error) {
    row["refused"] = error.what();
  }
  return row;
}

void measure(const Request& request, Progress& progress, const Save& save) {
  std::vector<int> counts;
  if (request.has("cells")) {
    counts = {request.count("cells", 0)};
  } else if (request.size == Size::quick) {
    counts = {1'000};
  } else {
    counts = {20'000};
    if (request.size == Size::full) counts.push_back(100'000);
  }
  const std::vector<Object> objects = objects_of(request);
  Json rows = Json::array();
  for (const int cells : counts) {
    for (const Object& object : objects) {
      progress.update(
          "bench polygrid",
          static_cast<double>(rows.size()) / static_cast<double>(counts.size() * objects.size()),
          object.name);
      rows.push_back(measured(object, cells, request, progress));
      save({{"size_mm", size_mm}, {"rows", rows}});
    }
  }
}

}  // namespace

Subject polygrid_subject() {
  return {
      "polygrid",
      "Polygrids of closed meshes: quality (docs/polygrid.md), live frames "
      "(docs/polygrid-diffusion.md)",
      R"(  kappamu-studies polygrid --section polygrid -o out/ --files bunny.obj

polygrid: cells, scaled Jacobians (1: a box; not above 0: inverted), edge lengths,
nodes whose six weights (Wang et al. 2008, appendix B) are negative or ill-conditioned,
spread of volumes, distance of the mesh from the grid's surface in spacings of its
boundary nodes, processor seconds. Of the shapes known by name, or of the files.
convergence: the sum of (L - L0)^2 over that of L0^2 against nodes processed and processor
time (relaxations: serial, in double; ours: OpenCL, in float), each scheme against its own
converged answer, a cube lit on one side, from zero (Wang et al. 2008,
figure 15).
frames: milliseconds of processor time, all cores together, of the light, diffusion and
exitance of a frame whose light has moved by 2 degrees and of one in which 10,000 voxels
were edited, of the first file, at the nodes of Table III of Wang et al. 2008; elapsed: by
the clock, to be trusted on a machine that does nothing else; surface: all light enters at
the surface, as there, and no beams are followed. Medians of seven frames.)",
      {{"polygrid", "shapes and files, 20,000 and 100,000 cells", measure},
       {"convergence", "error against nodes processed, relaxations and ours", measure_convergence},
       {"frames", "live frames and edits at 62,000 to 1,500,000 nodes", measure_frames}},
      {{"files", "Meshes (default: the named shapes; of frames, spot)", Setting::Kind::words},
       {"cells", "Asked for (default 20000 and 100000; of frames, those of Table III)",
        Setting::Kind::number, 100, 4e6},
       {"write", "Also write faces with their Jacobians, and polycubes", Setting::Kind::flag}}};
}

}  // namespace kappamu::studies

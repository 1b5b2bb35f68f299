#include "bench/polygrid/polygrid_bench.h"

#include <nlohmann/json.hpp>

#include "bench/polygrid/convergence_bench.h"
#include "bench/polygrid/frames_bench.h"
#include "core/error.h"
#include "core/mesh/mesh_check.h"
#include "core/mesh/shapes.h"
#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/shape/make_polygrid.h"
#include "io/mesh_file.h"
#include "io/npy.h"
#include "io/polycube_file.h"

namespace kappamu::bench {

namespace {

constexpr double size_mm = 40.0;
constexpr int tessellation = 80;

struct Object {
  std::string name;
  TriangleMesh mesh;
};

std::vector<Object> objects_of(const Request& request) {
  std::vector<Object> objects;
  for (const NamedShape& shape : named_shapes()) {
    objects.push_back({std::string(shape.name), make_shape(shape.name, size_mm, tessellation)});
  }
  if (request.size == Size::quick) return objects;
  std::vector<std::string> files = request.words("files");
  if (files.empty()) {
    files = {"scenes/meshes/spot.ply", "scenes/meshes/bob.ply", "scenes/meshes/nefertiti.ply"};
  }
  for (const std::string& file : files) {
    objects.push_back({std::filesystem::path(file).stem().string(),
                       check_mesh(fitted(io::read_mesh(file), size_mm), file).mesh});
  }
  return objects;
}

/// What scripts/polygrid_picture.py draws: corners of the boundary nodes' faces, and each cell's
/// scaled Jacobian there.
void write_surface(const forward::Polygrid& grid, const std::string& stem) {
  std::vector<float> faces, jacobians;
  for (std::size_t k = 0; k < grid.boundary_cell.size(); ++k) {
    const auto cell = static_cast<std::size_t>(grid.boundary_cell[k]);
    for (const int c : forward::side_corners(grid.boundary_side[k])) {
      const auto corner =
          static_cast<std::size_t>(grid.cell_corners[cell][static_cast<std::size_t>(c)]);
      for (const double x : grid.corner[corner]) faces.push_back(static_cast<float>(x));
    }
    jacobians.push_back(static_cast<float>(forward::scaled_jacobian(grid, cell)));
  }
  io::write_npy(stem + "-faces.npy", {grid.boundary_cell.size(), 4, 3}, faces);
  io::write_npy(stem + "-jacobian.npy", {grid.boundary_cell.size()}, jacobians);
}

Json measured(const Object& object, int cells, const Request& request, Progress& progress) {
  Json row{{"object", object.name}, {"asked", cells}};
  try {
    const forward::MadePolygrid made = forward::make_polygrid(
        object.mesh, {cells, forward::PolygridOptions{}.first_layer}, progress);
    const forward::PolygridQuality& q = made.quality;
    row.update({{"cells", q.cells},
                {"boundary", q.boundary_nodes},
                {"refinement", q.refinement},
                {"inverted", q.inverted},
                {"least_jacobian", q.least_jacobian},
                {"mean_jacobian", q.mean_jacobian},
                {"aspect", q.mean_aspect},
                {"volume_spread", q.volume_spread},
                {"area_spread", q.area_spread},
                {"volume_ratio", q.volume_ratio},
                {"mean_gap", q.mean_gap},
                {"largest_gap", q.largest_gap},
                {"cpu_s", q.cpu_seconds},
                {"warnings", made.warnings}});
    if (request.has("write")) {
      const std::string stem =
          (request.folder / (object.name + "-" + std::to_string(cells))).string();
      write_surface(made.grid, stem);
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
      "  kappamu bench polygrid --section polygrid -o out/ --files bunny.obj\n\n"
      "polygrid: cells, scaled Jacobians (1: a box; not above 0: inverted), edge lengths,\n"
      "spread of volumes and areas, distance of the mesh from the grid's surface in spacings of "
      "its\n"
      "boundary nodes, processor seconds. Shapes known by name, then the files.\n"
      "convergence: the sum of (L - L0)^2 over that of L0^2 against nodes processed, each scheme\n"
      "against its own converged answer, a cube lit on one side, from zero (Wang et al. 2008,\n"
      "figure 15).\n"
      "frames: milliseconds of processor time, all cores together, of the light, diffusion and\n"
      "exitance of a frame whose light has moved by 2 degrees and of one whose material was\n"
      "edited, of the first file, at the nodes of Table III of Wang et al. 2008.",
      {{"polygrid", "shapes and files, 20,000 and 100,000 cells", measure},
       {"convergence", "error against nodes processed, relaxations and ours", measure_convergence},
       {"frames", "live frames and edits at 62,000 to 1,500,000 nodes", measure_frames}},
      {{"files", "Meshes (default: those of scenes/meshes)", Setting::Kind::words},
       {"cells", "Asked for (default 20000 and 100000)", Setting::Kind::number, 100, 4e6},
       {"write", "Also write faces with their Jacobians, and polycubes", Setting::Kind::flag}}};
}

}  // namespace kappamu::bench

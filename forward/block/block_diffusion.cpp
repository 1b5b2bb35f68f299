#include "forward/block/block_diffusion.h"

#include <array>

#include "core/parallel.h"
#include "forward/light/voxels.h"
#include "forward/light_entry.h"

namespace kappamu::forward::block {

namespace {

/// Beams are marched in a fixed number of parts, each with its own load: the same bits on any
/// number of cores.
constexpr std::size_t parts = 4;

}  // namespace

BlockDiffusion::BlockDiffusion(const BlockGrid& grid, const FaceMap& map, double eta,
                               const std::string& device)
    : grid_(grid), map_(map) {
  GridSetup setup;
  setup.shape = grid.shape;
  setup.eta = eta;
  SolverChoice choice = make_grid_solver(setup, device);
  solver_ = std::move(choice.solver);
  warning_ = std::move(choice.warning);
}

BlockDiffusion::~BlockDiffusion() = default;

void BlockDiffusion::set_medium(const ObjectMedium& medium) {
  medium_ = medium_on(grid_, medium);
  solver_->set_medium(medium_.kappa.values(), medium_.mu.values());
}

void BlockDiffusion::enter_beams(const ObjectProblem& problem, const ObjectLight& light,
                                 double remainder, std::span<double> load,
                                 ObjectBalance& balance) const {
  const MeshWalls walls(problem);
  std::vector<std::vector<double>> loads(light.beams.empty() ? 0 : parts);
  std::array<ObjectBalance, parts> powers;
  for_rows(static_cast<int>(loads.size()), [&](int p) {
    const auto part = static_cast<std::size_t>(p);
    loads[part].assign(load.size(), 0.0);
    const std::size_t count = light.beams.size();
    for (std::size_t k = part * count / parts; k < (part + 1) * count / parts; ++k) {
      const BeamLight beam =
          march_voxels(walls, light.beams[k], remainder, medium_, grid_.corner,
                       [&](std::size_t voxel, double power) { loads[part][voxel] += power; });
      powers[part].entering += beam.scattered[0] + beam.absorbed[0] + beam.unscattered[0];
      powers[part].absorbed += beam.absorbed[0];
      powers[part].unscattered += beam.unscattered[0];
    }
  });
  for (std::size_t part = 0; part < loads.size(); ++part) {
    balance.entering += powers[part].entering;
    balance.absorbed += powers[part].absorbed;
    balance.unscattered += powers[part].unscattered;
    for (std::size_t i = 0; i < load.size(); ++i) load[i] += loads[part][i];
  }
}

BlockAnswer BlockDiffusion::solve(const ObjectProblem& problem, const BlockAccuracy& accuracy) {
  const GridShape& shape = grid_.shape;
  const BoundaryConstants& constants = solver_->constants();
  const double h = shape.voxel_mm;
  const int lights = static_cast<int>(problem.lights.size());
  const std::size_t cells = shape.cells(), samples = problem.surface.size();
  BlockAnswer answer;
  answer.balance.resize(problem.lights.size());
  std::vector<double> load(cells * problem.lights.size(), 0.0);
  // What enters diffusely, E_t on the pixels, comes through q = 4 E_t/(1 − R_φ) of the Robin
  // condition: G_b q per pixel.
  std::vector<std::vector<double>> entering(problem.lights.size());
  const auto conductance = [&](std::size_t cell) {  // per area, G_b/h²
    return robin_conductance(medium_.kappa[cell], h, constants.A) / (h * h);
  };
  const double q_per_entering = constants.q_per_entering();
  const auto each_pixel = [&](const auto& visit) {
    std::size_t pixel = 0;
    for (const Face face : all_faces) {
      const FaceShape pixels = face_shape(shape, face);
      for (int v = 0; v < pixels.nv; ++v) {
        for (int u = 0; u < pixels.nu; ++u) visit(pixel++, face_cell(shape, face, u, v));
      }
    }
  };
  for (std::size_t l = 0; l < problem.lights.size(); ++l) {
    const ObjectLight& light = problem.lights[l];
    const std::span<double> mine = std::span(load).subspan(l * cells, cells);
    enter_beams(problem, light, accuracy.beam_remainder, mine, answer.balance[l]);
    if (light.diffuse.empty()) continue;
    entering[l] = map_.on_pixels(light.diffuse);
    for (double& flux : entering[l]) flux *= diffuse_transmittance(constants);
    each_pixel([&](std::size_t pixel, std::size_t cell) {
      answer.balance[l].entering += h * h * entering[l][pixel];
      mine[cell] += h * h * conductance(cell) * q_per_entering * entering[l][pixel];
    });
  }
  if (!source_ || source_->patterns() != lights) {
    source_ = solver_->make_field(lights);
    fluence_ = solver_->make_field(lights);
  }
  solver_->fill(*source_, load);
  answer.report = solver_->solve(*source_, *fluence_, {.tolerance = accuracy.linear_tolerance});

  std::vector<std::vector<double>> pixels(problem.lights.size());
  for (const Face face : all_faces) {
    const std::size_t count = face_shape(shape, face).cells();
    std::vector<double> dark(face == solver_->setup().lit_face ? count * problem.lights.size() : 0);
    std::vector<double> out(count * problem.lights.size());
    solver_->exitance(*fluence_, face, dark, out);
    for (std::size_t l = 0; l < pixels.size(); ++l) {
      const auto from = out.begin() + static_cast<std::ptrdiff_t>(l * count);
      pixels[l].insert(pixels[l].end(), from, from + static_cast<std::ptrdiff_t>(count));
    }
  }
  std::vector<double> weight = medium_.mu.values();
  for (double& w : weight) w *= h * h * h;
  const std::vector<double> absorbed = solver_->weighted_sums(*fluence_, weight);
  answer.exitance.reserve(samples * problem.lights.size());
  for (std::size_t l = 0; l < pixels.size(); ++l) {
    each_pixel([&](std::size_t pixel, std::size_t cell) {
      if (!entering[l].empty()) {
        pixels[l][pixel] += entering[l][pixel] * (1.0 - conductance(cell) * q_per_entering);
      }
      answer.balance[l].exiting += h * h * pixels[l][pixel];
    });
    answer.balance[l].absorbed += absorbed[l];
    const std::vector<double> mine = map_.on_triangles(pixels[l]);
    answer.exitance.insert(answer.exitance.end(), mine.begin(), mine.end());
  }
  return answer;
}

}  // namespace kappamu::forward::block

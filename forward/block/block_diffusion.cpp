#include "forward/block/block_diffusion.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "forward/light/first_collisions.h"
#include "forward/light_entry.h"

namespace kappamu::forward::block {

namespace {

using Eigen::Vector3d;

/// Beams are marched in a fixed number of parts, each with its own load: the same bits on any
/// number of cores.
constexpr std::size_t parts = 4;

/// Voxels along a chord.
class Voxels {
 public:
  explicit Voxels(const BlockGrid& grid) : grid_(grid) {}

  void start(const Chord& chord) {
    start_ = (chord.from - grid_.corner) / grid_.shape.voxel_mm;
    direction_ = chord.direction;
    at_ = 0.0;
  }

  CellStep step(double most) {
    const GridShape& shape = grid_.shape;
    const double far = most / shape.voxel_mm, step_over = 1e-12 * (1.0 + at_ + far);
    const Vector3d inside = start_ + (at_ + step_over) * direction_;
    std::array<int, 3> voxel{};
    double next = at_ + far;
    for (int axis = 0; axis < 3; ++axis) {
      const int i =
          std::clamp(static_cast<int>(std::floor(inside[axis])), 0, shape.extent(axis) - 1);
      voxel[static_cast<std::size_t>(axis)] = i;
      const double along = direction_[axis];
      if (along != 0.0)
        next = std::min(next, (i + (along > 0.0 ? 1.0 : 0.0) - start_[axis]) / along);
    }
    next = std::max(next, at_ + step_over);
    CellStep step;  // a voxel takes light as a whole, wherever it collides
    step.cell = static_cast<int>(shape.index(voxel[0], voxel[1], voxel[2]));
    step.length = std::min(most, (next - at_) * shape.voxel_mm);
    at_ = next;
    return step;
  }

 private:
  const BlockGrid& grid_;
  Vector3d start_ = Vector3d::Zero(), direction_ = Vector3d::Zero();  ///< of the chord, in voxels
  double at_ = 0.0;
};

/// What beams leave: in each voxel what they scatter first.
struct Marched {
  const Medium& medium;
  std::span<double> load;

  CellOptics optics(int cell) const {
    const auto k = static_cast<std::size_t>(cell);
    CellOptics result;
    set_lane({medium.kappa[k], medium.mu[k]}, 0, result);
    return result;
  }
  void deposit(int cell, const CornerShares& shares) {
    for (const OfChannels& share : shares) load[static_cast<std::size_t>(cell)] += share[0];
  }
  static void leave(std::size_t, const OfChannels&) {}  // a box does not meet itself again
};

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
  const Walls walls(problem);
  std::vector<std::vector<double>> loads(light.beams.empty() ? 0 : parts);
  std::array<ObjectBalance, parts> powers;
  for_rows(static_cast<int>(loads.size()), [&](int p) {
    const auto part = static_cast<std::size_t>(p);
    loads[part].assign(load.size(), 0.0);
    const std::size_t count = light.beams.size();
    for (std::size_t k = part * count / parts; k < (part + 1) * count / parts; ++k) {
      BeamPath path(walls, light.beams[k]);
      BeamLight beam = entering(path, {light.beams[k].power}, remainder);
      powers[part].entering += beam.left[0];
      Voxels voxels(grid_);
      PathPlace place;
      CellStep step;
      march([&] { return next_step(path, walls, place, voxels, step) ? &step : nullptr; }, beam,
            Marched{medium_, loads[part]});
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

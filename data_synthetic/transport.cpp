#include "data_synthetic/transport.h"

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "core/shown_text.h"
#include "data_synthetic/scene/random.h"
#include "forward/forward_model.h"

namespace kappamu::synthetic {

namespace {

/// Relative residual of every pattern: far below the noise of the brightest pixels, and within
/// reach of single precision.
constexpr double solver_tolerance = 1e-6;
constexpr double memory_bytes = 8e9;
/// Fields of a preconditioned conjugate-gradient solve and its multigrid levels.
constexpr double bytes_per_cell_and_pattern = 64.0;
constexpr int largest_batch = 16;

int batch_size(const GridShape& shape) {
  const double fits =
      memory_bytes / (bytes_per_cell_and_pattern * static_cast<double>(shape.cells()));
  int batch = largest_batch;
  while (batch > 1 && batch > fits) batch /= 2;
  return batch;
}

}  // namespace

struct Transport::Solver {
  std::unique_ptr<forward::GridSolver> grid;  ///< diffusion
  /// Monte Carlo, which needs no more than the problem.
  std::unique_ptr<forward::ForwardModel> monte_carlo;
  forward::ForwardProblem problem;
  forward::ForwardOptions options;
  std::uint64_t calls = 0;  ///< so that no two draw the same photons
  BoundaryConstants constants;
  std::string backend;
};

Transport::Transport(const Block& block, const std::string& device, const TransportChoice& choice)
    : block_(block), choice_(choice), solver_(std::make_unique<Solver>()) {
  forward::GridSetup setup;
  setup.shape = block.shape;
  setup.eta = block.eta;
  setup.lit_face = block.lit_face;
  setup.sides = block.sides;
  if (choice.method == TransportMethod::diffusion) {
    forward::SolverChoice grid = forward::make_grid_solver(setup, device);
    solver_->grid = std::move(grid.solver);
    solver_->constants = solver_->grid->constants();
    solver_->backend = solver_->grid->backend();
    warning_ = grid.warning;
    return;
  }
  solver_->monte_carlo = forward::make_forward_model("montecarlo");
  solver_->problem.setup = setup;
  solver_->options.device = device;
  solver_->options.photons = choice.photons;
  solver_->options.anisotropy = choice.anisotropy;
  solver_->constants = boundary_constants(block.eta);
  solver_->backend = device;
}

Transport::~Transport() = default;

void Transport::set_medium(const Medium& medium) {
  check(medium.kappa.shape() == block_.shape, "the medium lies on the transport grid");
  if (solver_->grid) {
    solver_->grid->set_medium(medium.kappa.values(), medium.mu.values());
  } else {
    solver_->problem.medium = medium;
  }
}

const BoundaryConstants& Transport::constants() const {
  return solver_->constants;
}

std::string Transport::backend() const {
  return solver_->backend;
}

std::string Transport::model() const {
  if (solver_->grid) return "grid diffusion, physical convention, first-collision source";
  const std::string scattering = choice_.anisotropy == 0.0
                                     ? "isotropic scattering"
                                     : "Henyey-Greenstein g " + shown_number(choice_.anisotropy);
  return "Monte Carlo radiative transfer, " + scattering + ", collimated light, " +
         std::to_string(choice_.photons) + " photons per pattern";
}

std::vector<double> Transport::diffuse(std::span<const double> light, Face face, int count) const {
  std::vector<double> out(face_shape(block_.shape, face).cells() * count);
  const auto b = solver_->grid->make_field(count);
  const auto phi = solver_->grid->make_field(count);
  solver_->grid->light_source(light, *b);
  const forward::SolveReport report =
      solver_->grid->solve(*b, *phi, {.tolerance = solver_tolerance, .max_iterations = 2000});
  if (report.termination != forward::Termination::converged) {
    throw InputError("light transport on " + backend() + " did not converge: " + report.message);
  }
  solver_->grid->exitance(*phi, face, light, out);
  return out;
}

std::vector<double> Transport::trace(std::span<const double> light, Face face, int count) const {
  solver_->problem.irradiance.assign(light.begin(), light.end());
  solver_->problem.patterns = count;
  solver_->options.seed = key_of({choice_.seed, solver_->calls++});
  Progress silent;
  forward::ForwardResult result =
      solver_->monte_carlo->solve(solver_->problem, solver_->options, silent);
  solver_->backend = result.backend;
  return std::move(result.exitance[static_cast<std::size_t>(face)]);
}

std::vector<double> Transport::exitance(std::span<const double> irradiance, Face face,
                                        const std::function<void(double)>& progress) const {
  const std::size_t lit_cells = face_shape(block_.shape, block_.lit_face).cells();
  const int patterns = static_cast<int>(irradiance.size() / lit_cells);
  const int batch = batch_size(block_.shape);
  std::vector<double> out;
  out.reserve(face_shape(block_.shape, face).cells() * patterns);
  for (int first = 0; first < patterns; first += batch) {
    const int count = std::min(batch, patterns - first);
    const std::span<const double> light = irradiance.subspan(first * lit_cells, count * lit_cells);
    const std::vector<double> maps =
        solver_->grid ? diffuse(light, face, count) : trace(light, face, count);
    out.insert(out.end(), maps.begin(), maps.end());
    if (progress) progress(static_cast<double>(first + count) / patterns);
  }
  return out;
}

std::vector<double> patch_irradiance(const FaceShape& face, int n) {
  std::vector<double> out(face.cells() * n * n);
  const auto overlap = [n](int cell, int cells, int patch) {
    const double low = static_cast<double>(patch) * cells / n;
    const double high = static_cast<double>(patch + 1) * cells / n;
    return std::max(0.0, std::min(cell + 1.0, high) - std::max<double>(cell, low));
  };
  for (int patch = 0; patch < n * n; ++patch) {
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        out[(static_cast<std::size_t>(patch) * face.nv + v) * face.nu + u] =
            overlap(u, face.nu, patch % n) * overlap(v, face.nv, patch / n);
      }
    }
  }
  return out;
}

std::vector<double> average_cells(std::span<const double> maps, const FaceShape& fine, int factor) {
  const int nu = fine.nu / factor;
  const int nv = fine.nv / factor;
  const std::size_t patterns = maps.size() / fine.cells();
  std::vector<double> out(patterns * nu * nv);
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const std::size_t m = i / fine.cells();
    const int v = static_cast<int>(i % fine.cells()) / fine.nu / factor;
    const int u = static_cast<int>(i % fine.nu) / factor;
    out[(m * nv + v) * nu + u] += maps[i] / (factor * factor);
  }
  return out;
}

std::vector<double> split_cells(std::span<const double> maps, const FaceShape& coarse, int factor) {
  const std::size_t patterns = maps.size() / coarse.cells();
  const int nu = coarse.nu * factor;
  const int nv = coarse.nv * factor;
  std::vector<double> out(patterns * nu * nv);
  for (std::size_t m = 0; m < patterns; ++m) {
    for (int v = 0; v < nv; ++v) {
      for (int u = 0; u < nu; ++u) {
        out[(m * nv + v) * nu + u] = maps[(m * coarse.nv + v / factor) * coarse.nu + u / factor];
      }
    }
  }
  return out;
}

Volume<double> split_cells(const Volume<double>& coarse, int factor) {
  Volume<double> fine(coarse.shape().refined(factor));
  for (int z = 0; z < fine.shape().nz; ++z) {
    for (int y = 0; y < fine.shape().ny; ++y) {
      for (int x = 0; x < fine.shape().nx; ++x) {
        fine(x, y, z) = coarse(x / factor, y / factor, z / factor);
      }
    }
  }
  return fine;
}

}  // namespace kappamu::synthetic

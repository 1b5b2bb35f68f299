#include "data_synthetic/transport.h"

#include <algorithm>

#include "core/error.h"
#include "forward/grid/grid_solver.h"

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
  std::unique_ptr<forward::GridSolver> grid;
};

Transport::Transport(const Block& block, const std::string& device)
    : block_(block), solver_(std::make_unique<Solver>()) {
  forward::GridSetup setup;
  setup.shape = block.shape;
  setup.eta = block.eta;
  setup.lit_face = block.lit_face;
  setup.sides = block.sides;
  forward::SolverChoice choice = forward::make_grid_solver(setup, device);
  solver_->grid = std::move(choice.solver);
  warning_ = choice.warning;
}

Transport::~Transport() = default;

void Transport::set_medium(const Medium& medium) {
  check(medium.kappa.shape() == block_.shape, "the medium lies on the transport grid");
  solver_->grid->set_medium(medium.kappa.values(), medium.mu.values());
}

const BoundaryConstants& Transport::constants() const {
  return solver_->grid->constants();
}

std::string Transport::backend() const {
  return solver_->grid->backend();
}

std::vector<double> Transport::exitance(std::span<const double> irradiance, Face face,
                                        const std::function<void(double)>& progress) const {
  const std::size_t lit_cells = face_shape(block_.shape, block_.lit_face).cells();
  const std::size_t seen_cells = face_shape(block_.shape, face).cells();
  const int patterns = static_cast<int>(irradiance.size() / lit_cells);
  const int batch = batch_size(block_.shape);
  std::vector<double> out(seen_cells * patterns);
  for (int first = 0; first < patterns; first += batch) {
    const int count = std::min(batch, patterns - first);
    const std::span<const double> light = irradiance.subspan(first * lit_cells, count * lit_cells);
    const auto b = solver_->grid->make_field(count);
    const auto phi = solver_->grid->make_field(count);
    solver_->grid->light_source(light, *b);
    const forward::SolveReport report =
        solver_->grid->solve(*b, *phi, {.tolerance = solver_tolerance, .max_iterations = 2000});
    if (report.termination != forward::Termination::converged) {
      throw InputError("light transport on " + backend() + " did not converge: " + report.message);
    }
    solver_->grid->exitance(*phi, face, light,
                            std::span(out).subspan(first * seen_cells, count * seen_cells));
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

#include <nlohmann/json.hpp>

#include "core/optics.h"
#include "core/processor_time.h"
#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/linear_solver.h"
#include "forward/polygrid/split_polygrid.h"
#include "studies/polygrid/polygrid_bench.h"
#include "studies/polygrid/relaxation.h"
#include "tests/cases/polygrid_reference.h"

namespace kappamu::studies {

namespace {

using namespace forward::polygrid;
using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double cube_mm = 10.0, cube_eta = 1.3;
constexpr Coefficients cube_medium{0.3, 0.003};
constexpr int steps_of_coarse_levels = 60, most_steps = 1000, adaptive_depth = 4,
              most_iterations = 16;

/// n³ cells of a cube.
forward::Polygrid cube(int n) {
  std::vector<Vector3d> corner;
  std::vector<Vector3i> cell;
  std::vector<std::array<int, 8>> cell_corners;
  for (int i = 0; i < (n + 1) * (n + 1) * (n + 1); ++i) {
    corner.push_back(cube_mm / n *
                     Vector3d(i % (n + 1), i / (n + 1) % (n + 1), i / (n + 1) / (n + 1)));
  }
  for (int i = 0; i < n * n * n; ++i) {
    cell.emplace_back(i % n, i / n % n, i / n / n);
    auto& corners = cell_corners.emplace_back();
    for (int c = 0; c < 8; ++c) {
      const Vector3i at = cell.back() + Vector3i(c & 1, c >> 1 & 1, c >> 2 & 1);
      corners[static_cast<std::size_t>(c)] = (at[2] * (n + 1) + at[1]) * (n + 1) + at[0];
    }
  }
  return linked(std::move(cell), std::move(cell_corners), std::move(corner));
}

/// A cube, one side lit, with the records of every scheme.
class Trial {
 public:
  explicit Trial(int n)
      : grid_(cube(n)),
        of_cell_(grid_.cell.size(), cube_medium),
        A_(boundary_constants(cube_eta).A) {
    for (const Vector3d& p : grid_.boundary_node) q_.push_back(p[2] > 0.999 * cube_mm ? 1.0 : 0.0);
    levels_ = relaxation_levels(grid_, of_cell_, q_, 3);
    exact_ = dark(levels_[0]);
    relax(levels_[0], A_, 16 * n * n, 0, exact_, {});
  }

  void plain(Json& rows) const { relaxed("plain", dark(levels_[0]), 0, {}, rows); }

  /// From the coarsest of three levels on; deep nodes stay where `depth` is not 0.
  void hierarchical(const char* name, int depth, Json& rows) const {
    Spent spent;
    const double start = processor_seconds();
    const auto count = [&](std::size_t nodes) { spent.nodes += nodes; };
    NodeFluence fluence = dark(levels_[2]);
    for (std::size_t l = 2; l > 0; --l) {
      relax(levels_[l], A_, steps_of_coarse_levels, 0, fluence, count);
      fluence = from_coarser(levels_[l - 1], fluence);
    }
    spent.seconds = processor_seconds() - start;
    relaxed(name, std::move(fluence), depth, spent, rows);
  }

  /// A row of 27 counts as four nodes of six links, a V-cycle passes every level twice.
  void ours(const std::string& device, Json& rows) const {
    const Equations equations(grid_, A_);
    const Hierarchy hierarchy(equations, grid_);
    std::vector<double> load(equations.unknowns(), 0.0);
    for (std::size_t b = 0; b < q_.size(); ++b) {
      for (const int c : forward::boundary_corners(grid_, b)) {
        load[static_cast<std::size_t>(c)] += 0.25 * grid_.area[b] * q_[b] / (2.0 * A_);
      }
    }
    const auto reference = make_reference_solver(equations);
    reference->set_media({equations.values(of_cell_)});
    std::vector<std::vector<double>> x;
    reference->solve({{0, load}}, x, 1e-10, 5000);
    const NodeFluence converged = boundary_means(x[0]);
    const auto solver = make_linear_solver(equations, hierarchy, device);
    solver->set_media({equations.values(of_cell_)});
    std::size_t per_iteration = 4 * equations.unknowns();
    for (const GraphLevel& level : hierarchy.level()) per_iteration += 2 * level.links.rows();
    for (int iterations = 1; iterations <= most_iterations; ++iterations) {
      // Kernels are compiled, and memory is there, after the first.
      std::vector<std::vector<double>> y;
      if (iterations == 1) solver->solve({{0, load}}, y, 1e-9, iterations);
      y.clear();
      const double start = processor_seconds();
      solver->solve({{0, load}}, y, 1e-9, iterations);
      rows.push_back({{"scheme", "multigrid and conjugate gradients"},
                      {"ms", 1e3 * (processor_seconds() - start)},
                      {"nodes", per_iteration * static_cast<std::size_t>(iterations)},
                      {"error", error(boundary_means(y[0]), converged)}});
    }
  }

 private:
  struct Spent {
    std::size_t nodes = 0;
    double seconds = 0.0;
  };

  static NodeFluence dark(const RelaxationLevel& level) {
    return {std::vector<double>(level.grid.node.size(), 0.0),
            std::vector<double>(level.grid.boundary_node.size(), 0.0)};
  }

  /// Σ (L − L₀)²/Σ L₀² of L = φ − q, up to a factor.
  double error(const NodeFluence& at, const NodeFluence& converged) const {
    double difference = 0.0, size = 0.0;
    for (std::size_t b = 0; b < q_.size(); ++b) {
      const double off = at.boundary[b] - converged.boundary[b],
                   value = converged.boundary[b] - q_[b];
      difference += off * off;
      size += value * value;
    }
    return difference / size;
  }

  void relaxed(const char* scheme, NodeFluence fluence, int depth, Spent spent, Json& rows) const {
    const auto record = [&] {
      rows.push_back({{"scheme", scheme},
                      {"ms", 1e3 * spent.seconds},
                      {"nodes", spent.nodes},
                      {"error", error(fluence, exact_)}});
    };
    if (spent.nodes > 0) record();
    int next = 1;
    for (int step = 1; step <= most_steps; ++step) {
      const double start = processor_seconds();
      relax(levels_[0], A_, 1, depth, fluence, [&](std::size_t nodes) { spent.nodes += nodes; });
      spent.seconds += processor_seconds() - start;
      if (step < next) continue;
      next = step + 1 + step / 4;
      record();
    }
  }

  NodeFluence boundary_means(const std::vector<double>& at_corners) const {
    NodeFluence result{{}, std::vector<double>(q_.size(), 0.0)};
    for (std::size_t b = 0; b < q_.size(); ++b) {
      for (const int c : forward::boundary_corners(grid_, b)) {
        result.boundary[b] += 0.25 * at_corners[static_cast<std::size_t>(c)];
      }
    }
    return result;
  }

  forward::Polygrid grid_;
  std::vector<Coefficients> of_cell_;
  double A_;
  std::vector<double> q_;
  std::vector<RelaxationLevel> levels_;
  NodeFluence exact_;
};

}  // namespace

void measure_convergence(const Request& request, Progress& progress, const Save& save) {
  const int n = request.size == Size::quick ? 8 : 16;
  Json rows = Json::array();
  const Trial trial(n);
  trial.plain(rows);
  progress.update("bench polygrid convergence", 0.4, "");
  trial.hierarchical("hierarchical", 0, rows);
  trial.hierarchical("adaptive", adaptive_depth, rows);
  trial.ours(request.device, rows);
  save({{"cells", n * n * n}, {"rows", rows}});
}

}  // namespace kappamu::studies

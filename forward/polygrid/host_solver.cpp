#include "forward/linear/row_solver.h"
#include "forward/polygrid/linear_solver.h"

namespace kappamu::forward::polygrid {

namespace {

using linear::Lanes;
using linear::RowLevel;
using linear::RowLevels;
using linear::RowMatrix;
using linear::RowSum;

/// All rows of symmetric matrices of whose pattern half is stored: off(m, k) is entry k of the m-th
/// used lane, diagonal(m, row) is added.
template <class Off, class Diagonal>
RowMatrix<double> whole_rows(const Pattern& half, const Lanes& lanes, const Off& off,
                             const Diagonal& diagonal) {
  struct Entry {
    int row, place;
  };
  std::vector<std::vector<Entry>> before(half.rows());  // the entries left of the diagonal
  for (std::size_t i = 0; i < half.rows(); ++i) {
    for (int k = half.start[i]; k < half.start[i + 1]; ++k) {
      const auto j = static_cast<std::size_t>(half.column[static_cast<std::size_t>(k)]);
      if (j != i) before[j].push_back({static_cast<int>(i), k});
    }
  }
  const std::size_t used = lanes.channels.size();
  return linear::make_rows(half.rows(), half.rows(), lanes.media(), [&](std::size_t i, RowSum& to) {
    const auto add = [&](int column, int place) {
      double* values = to.at(column);
      for (std::size_t m = 0; m < used; ++m) values[m] += off(m, static_cast<std::size_t>(place));
    };
    for (const Entry& entry : before[i]) add(entry.row, entry.place);
    double* own = to.at(static_cast<int>(i));
    for (std::size_t m = 0; m < used; ++m) own[m] += diagonal(m, i);
    for (int k = half.start[i]; k < half.start[i + 1]; ++k) {
      add(half.column[static_cast<std::size_t>(k)], k);
    }
  });
}

/// The equations and, to precondition them, the seven-point form and its aggregates, with one step
/// of Jacobi's relaxation by 2/3 before and after.
RowLevels make_row_levels(const Equations& equations, const Hierarchy& hierarchy,
                          const std::vector<MediumValues>& media, const Lanes& lanes) {
  std::vector<ChannelLevels> of_lane;
  for (const std::size_t c : lanes.channels) of_lane.emplace_back(hierarchy, media[c]);
  RowLevels result;
  for (std::size_t l = 0; l < hierarchy.level().size(); ++l) {
    const GraphLevel& from = hierarchy.level()[l];
    RowLevel& level = result.level.emplace_back();
    level.rows = from.links.rows();
    if (l == 0) {
      level.equations = whole_rows(
          equations.matrix(), lanes,
          [&](std::size_t m, std::size_t k) { return media[lanes.channels[m]].value[k]; },
          [](std::size_t, std::size_t) { return 0.0; });
    }
    if (l + 1 == hierarchy.level().size()) break;
    level.matrix =
        whole_rows(
            from.links, lanes,
            [&](std::size_t m, std::size_t k) { return -of_lane[m].graph[l].link[k]; },
            [&](std::size_t m, std::size_t i) { return of_lane[m].graph[l].diagonal[i]; })
            .rounded<float>();
    // The eigenvalues of diag(1/d) A of a graph lie in (0, 2].
    level.inverse_scale = linear::by_medium(level.rows, lanes, [&](std::size_t m, std::size_t i) {
      return 0.5 * of_lane[m].inverse_diagonal[l][i];
    });
    const std::size_t coarse = hierarchy.level()[l + 1].links.rows();
    level.interpolation = linear::make_rows(level.rows, coarse, 1, [&](std::size_t i, RowSum& to) {
                            *to.at(from.parent[i]) = 1.0;
                          }).rounded<float>();
    level.restriction = linear::transposed(level.interpolation, coarse);
  }
  const std::size_t size = result.level.back().rows;
  result.coarsest = linear::by_medium(
      size * size, lanes, [&](std::size_t m, std::size_t k) { return of_lane[m].coarsest[k]; });
  return result;
}

class HostSolver final : public LinearSolver {
 public:
  HostSolver(const Equations& equations, const Hierarchy& hierarchy)
      : equations_(equations), hierarchy_(hierarchy) {}

  CgReport solve(const std::vector<Load>& loads, std::vector<std::vector<double>>& x,
                 double tolerance, int most_iterations) override {
    x.resize(loads.size());
    for (auto& start : x) start.resize(equations_.unknowns(), 0.0);
    return solver_->solve(loads, x, {tolerance, most_iterations});
  }

 private:
  void media_changed(std::span<const int>) override {
    solver_ = linear::make_host_solver([this](const Lanes& lanes) {
      return make_row_levels(equations_, hierarchy_, media(), lanes);
    });
  }

  const Equations& equations_;
  const Hierarchy& hierarchy_;
  std::unique_ptr<linear::LinearSolver> solver_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_host_solver(const Equations& equations,
                                               const Hierarchy& hierarchy) {
  return std::make_unique<HostSolver>(equations, hierarchy);
}

}  // namespace kappamu::forward::polygrid

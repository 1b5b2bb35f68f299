#include "forward/polygrid/opencl/opencl_solver.h"

#include <optional>

#include "core/error.h"
#include "core/parallel.h"
#include "forward/polygrid/opencl/batch_solve.h"

namespace kappamu::forward::polygrid {

namespace {

using embedded::Lanes;

/// Stretches that hold sorted `rows` and few others.
std::vector<Stretch> stretches_of(std::span<const int> rows) {
  constexpr std::size_t gap = 64;  // a write costs more than as many rows
  std::vector<Stretch> result;
  for (const int row : rows) {
    const auto at = static_cast<std::size_t>(row);
    if (result.empty() || at > result.back().end + gap) result.push_back({at, at});
    result.back().end = at + 1;
  }
  return result;
}

std::vector<Stretch> entries_of(const Pattern& pattern, std::vector<Stretch> rows) {
  for (Stretch& stretch : rows) {
    stretch = {static_cast<std::size_t>(pattern.start[stretch.begin]),
               static_cast<std::size_t>(pattern.start[stretch.end])};
  }
  return rows;
}

class OpenclSolver final : public LinearSolver {
 public:
  OpenclSolver(const Equations& equations, const Hierarchy& hierarchy, device::Context& context,
               Precision precision, Lights lights)
      : equations_(equations),
        hierarchy_(hierarchy),
        context_(context),
        lights_(lights),
        matrix_(context, equations.matrix()) {
    if (precision == Precision::twofold && !context.info().fp64) {
      throw InputError("device '" + context.info().name + "' has no double precision");
    }
    numbers_ = {precision, context.info().fp64, context.info().kind == device::Kind::gpu};
    const auto& levels = hierarchy.level();
    for (std::size_t l = 0; l < levels.size(); ++l) {
      levels_.emplace_back(context, levels[l],
                           l + 1 < levels.size() ? levels[l + 1].links.rows() : std::size_t{0});
    }
  }

  CgReport solve(const std::vector<Load>& loads, std::vector<std::vector<double>>& x,
                 double tolerance, int most_iterations) override {
    CgReport report;
    report.residual.resize(loads.size());
    x.resize(loads.size());
    for (auto& start : x) start.resize(static_cast<std::size_t>(matrix_.rows), 0.0);
    for (const embedded::Batch& batch : embedded::batches_of(loads)) {
      batch_for(batch.lanes).solve(loads, batch.lights, x, tolerance, most_iterations, report);
    }
    return report;
  }

 private:
  void media_changed(std::span<const int> rows) override {
    std::vector<std::optional<ChannelLevels>> levels(media().size());
    for_rows(static_cast<int>(levels.size()), [&](int c) {
      levels[static_cast<std::size_t>(c)].emplace(hierarchy_, media()[static_cast<std::size_t>(c)]);
    });
    channels_.clear();
    for (auto& level : levels) channels_.push_back(std::move(*level));
    for (const auto& batch : batches_) batch->set_media(media(), channels_, changed(rows));
  }

  Changed changed(std::span<const int> rows) const {
    const std::vector<Stretch> stretches =
        rows.empty() ? std::vector<Stretch>{{0, equations_.unknowns()}} : stretches_of(rows);
    return {stretches, entries_of(equations_.matrix(), stretches),
            entries_of(equations_.links(), stretches)};
  }

  /// The one made before for the same lanes, or a new one.
  BatchSolve& batch_for(const Lanes& lanes) {
    for (const auto& batch : batches_) {
      if (batch->lanes().width == lanes.width && batch->lanes().channels == lanes.channels) {
        return *batch;
      }
    }
    batches_.push_back(
        std::make_unique<BatchSolve>(context_, numbers_, lanes, matrix_, levels_, lights_));
    batches_.back()->set_media(media(), channels_, changed({}));
    return *batches_.back();
  }

  const Equations& equations_;
  const Hierarchy& hierarchy_;
  device::Context& context_;
  Lights lights_;
  DevicePattern matrix_;
  Numbers numbers_;
  std::vector<DeviceLevel> levels_;
  std::vector<ChannelLevels> channels_;
  std::vector<std::unique_ptr<BatchSolve>> batches_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_opencl_solver(const Equations& equations,
                                                 const Hierarchy& hierarchy,
                                                 device::Context& context, Precision precision,
                                                 Lights lights) {
  return std::make_unique<OpenclSolver>(equations, hierarchy, context, precision, lights);
}

}  // namespace kappamu::forward::polygrid

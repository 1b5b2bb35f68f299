#include "forward/polygrid/opencl/opencl_solver.h"

#include <numeric>
#include <optional>

#include "core/error.h"
#include "core/parallel.h"
#include "forward/polygrid/opencl/batch_solve.h"

namespace kappamu::forward::polygrid {

namespace {

using linear::Lanes;

class OpenclSolver final : public LinearSolver {
 public:
  OpenclSolver(const Equations& equations, const Hierarchy& hierarchy, device::Context& context,
               Precision precision, Lights lights, device::Kind form)
      : hierarchy_(hierarchy),
        context_(context),
        lights_(lights),
        matrix_(context, equations.matrix()),
        all_rows_(equations.unknowns()) {
    std::iota(all_rows_.begin(), all_rows_.end(), 0);
    if (precision == Precision::twofold && !context.info().fp64) {
      throw InputError("device '" + context.info().name + "' has no double precision");
    }
    numbers_ = {precision, context.info().fp64, form == device::Kind::gpu};
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
    for (const linear::Batch& batch : linear::batches_of(loads)) {
      batch_for(packed(batch.lanes))
          .solve(loads, batch.lights, x,
                 {.most_iterations = most_iterations, .relative_energy = tolerance}, report);
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
    for (const auto& batch : batches_) {
      batch->set_media(media(), channels_, rows.empty() ? all_rows_ : rows);
    }
  }

  /// Three lanes have no fourth, save where that would cost a GPU its loads of vectors.
  Lanes packed(Lanes lanes) const {
    if (lanes.channels.size() == 3 && !numbers_.interleaved) lanes.width = 3;
    return lanes;
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
    batches_.back()->set_media(media(), channels_, all_rows_);
    return *batches_.back();
  }

  const Hierarchy& hierarchy_;
  device::Context& context_;
  Lights lights_;
  DevicePattern matrix_;
  std::vector<int> all_rows_;
  linear::Numbers numbers_;
  std::vector<DeviceLevel> levels_;
  std::vector<ChannelLevels> channels_;
  std::vector<std::unique_ptr<BatchSolve>> batches_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_opencl_solver(const Equations& equations,
                                                 const Hierarchy& hierarchy,
                                                 device::Context& context, Precision precision,
                                                 Lights lights, std::optional<device::Kind> form) {
  return std::make_unique<OpenclSolver>(equations, hierarchy, context, precision, lights,
                                        form.value_or(context.info().kind));
}

}  // namespace kappamu::forward::polygrid

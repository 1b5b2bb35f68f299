// A solver that goes batch by batch.
#pragma once

#include "forward/linear/row_solver.h"

namespace kappamu::forward::linear {

/// Assembles the levels of each batch, those of the last one kept.
class BatchSolver : public LinearSolver {
 public:
  explicit BatchSolver(Assembly assembly) : assembly_(std::move(assembly)) {}

  CgReport solve(const std::vector<Load>& b, std::vector<std::vector<double>>& x, const CgEnd& ends,
                 std::size_t level) override {
    CgReport report;
    report.residual.resize(b.size());
    x.resize(b.size());
    for (const Batch& batch : batches_of(b)) {
      if (lanes_.channels != batch.lanes.channels || lanes_.media() != batch.lanes.media()) {
        levels_ = {};
        levels_ = assembly_(batch.lanes);
        assembled(levels_);
      }
      lanes_ = batch.lanes;
      solve_batch_on(level, b, batch, x, ends, report);
    }
    return report;
  }

 protected:
  const RowLevels& levels() const { return levels_; }
  /// `levels` are those of other media; matrices may be taken out of them.
  virtual void assembled(RowLevels& /*levels*/) {}
  virtual void solve_batch_on(std::size_t level, const std::vector<Load>& b, const Batch& batch,
                              std::vector<std::vector<double>>& x, const CgEnd& ends,
                              CgReport& report) = 0;

 private:
  Assembly assembly_;
  Lanes lanes_;
  RowLevels levels_;
};

}  // namespace kappamu::forward::linear

// What a change of the data does to a fit, to first order and by fitting again.
#include "bench/inverse/dense_fit.h"

#include <gtest/gtest.h>

#include <memory>

#include "bench/cases/inverse_case.h"

namespace kappamu::bench {
namespace {

class DenseFits : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    Block block;
    block.grid = {8, 8, 4, 0.5};
    TruthSpec truth;
    truth.contrast = 2.0;
    measurements_ = expose_patches(block, make_truth(block.grid.refined(2), truth), 3);
    add_noise(measurements_, 0.01, 1);
    inverse::FitOptions options;
    options.solver.backend.device = "reference";
    options.solver.backend.precision = forward::Precision::double_precision;
    options.solver.backend.solve = {1e-9, 500};
    options.data.model_error = {0.0, 0.0};
    fit_ = std::make_unique<DenseFit>(measurements_, 0, options);
  }
  static void TearDownTestSuite() { fit_.reset(); }

  static SurfaceMeasurements measurements_;
  static std::unique_ptr<DenseFit> fit_;
};
SurfaceMeasurements DenseFits::measurements_;
std::unique_ptr<DenseFit> DenseFits::fit_;

TEST_F(DenseFits, ChangesOfDataActToFirstOrder) {
  std::vector<double> data = fit_->objective().problem().data;
  EXPECT_LT(fit_->change(data).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT(fit_->refitted(data).cwiseAbs().maxCoeff(), 1e-4);
  for (double& value : data) value *= 1.002;  // a brighter camera
  const Eigen::VectorXd found = fit_->refitted(data);
  EXPECT_GT(found.cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LT((fit_->change(data) - found).norm(), 0.1 * found.norm());
}

}  // namespace
}  // namespace kappamu::bench

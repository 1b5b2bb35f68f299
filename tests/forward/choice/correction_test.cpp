// Answers corrected by walks: exact where walks are, never worse than the answer by more than the
// noise, and the error left is the one stated.
#include "forward/choice/correction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/mesh/shapes.h"
#include "forward/choice/error_belief.h"

namespace kappamu::forward {
namespace {

TEST(ErrorBelief, IsTheLawWithoutAMeasurementAndTheMeasurementWhereItIsSharp) {
  EXPECT_NEAR(error_quantile({0.05, 0.3}, 0.5), 0.05, 1e-5);
  EXPECT_NEAR(error_quantile({0.05, 0.3}, 0.9), 0.05 * std::exp(0.3 * 1.2816), 1e-5);
  // So vague a measurement changes nothing, and so sharp a one everything.
  EXPECT_NEAR(error_quantile({0.05, 0.3, 0.0, 10.0}, 0.9), error_quantile({0.05, 0.3}, 0.9), 1e-5);
  EXPECT_NEAR(error_quantile({0.05, 0.3, 0.04 * 0.04, 1e-6}, 0.9), 0.04, 1e-4);
  double last = 0.0;
  for (double probability = 0.05; probability < 1.0; probability += 0.05) {
    const double error = error_quantile({0.05, 0.3, 0.003, 0.001}, probability);
    EXPECT_GT(error, last);
    last = error;
  }
}

TEST(NoiseThatLeaves, IsTheInverseOfWhatIsLeft) {
  EXPECT_EQ(noise_that_leaves(0.02, 0.03), std::numeric_limits<double>::infinity());
  EXPECT_EQ(noise_that_leaves(0.5, 0.03), 0.0) << "no walk corrects what lies between the nodes";
  double last = 0.0;
  for (const double wanted : {0.044, 0.047, 0.05, 0.055}) {
    const double noise = noise_that_leaves(0.06, wanted);
    EXPECT_GT(noise, last);
    const double variance = 0.44 * 0.5 * noise * noise, square = 0.06 * 0.06;
    EXPECT_NEAR(std::hypot(std::sqrt(square * variance / (square + variance)), 0.7 * 0.06), wanted,
                1e-12);
    last = noise;
  }
}

/// An exitance, an answer that errs slowly over the surface, and walks as noisy as asked.
class CorrectionTest : public testing::TestWithParam<const char*> {
 protected:
  CorrectionTest() : mesh_(make_shape(GetParam(), 10.0, 40)), surface_(surface_of(mesh_)) {
    for (const Eigen::Vector3d& p : surface_.position) {
      exact_.push_back(std::exp(0.2 * p.z()));
      answer_.push_back(exact_.back() * (1.0 + 0.1 * std::sin(0.6 * p.x() + p.y() * 0.3)));
    }
  }
  double error_of(const std::vector<double>& values) const {
    double square = 0.0, all = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      square += surface_.area[i] * std::pow(values[i] - exact_[i], 2);
      all += surface_.area[i] * exact_[i] * exact_[i];
    }
    return std::sqrt(square / all);
  }
  /// Photons of equal power.
  void walk(double photons) {
    std::mt19937_64 random(3);
    double power = 0.0;
    for (std::size_t i = 0; i < exact_.size(); ++i) power += surface_.area[i] * exact_[i];
    walk_.clear();
    noise_.clear();
    for (std::size_t i = 0; i < exact_.size(); ++i) {
      const double of_one = power / photons / surface_.area[i];
      std::poisson_distribution<int> count(exact_[i] / of_one);
      const int left = count(random);
      walk_.push_back(of_one * left);
      noise_.push_back(of_one * std::sqrt(static_cast<double>(left)));
    }
  }

  TriangleMesh mesh_;
  Surface surface_;
  std::vector<double> exact_, answer_, walk_, noise_;
};

TEST_P(CorrectionTest, LeavesWhatItStates) {
  const Correction correction(surface_);
  constexpr double expected = 1.15;  // of one draw of the walk
  const double own = error_of(answer_);
  double last = own;
  for (const double photons : {1e4, 1e5, 1e6}) {
    walk(photons);
    const double left = error_of(correction.corrected(answer_, walk_, noise_, own).exitance);
    EXPECT_LT(left, last) << photons;
    EXPECT_LT(left, expected * correction.left(answer_, walk_, noise_, own)) << photons;
    last = left;
  }
  EXPECT_LT(last, 0.3 * own) << "the share between the nodes";
}

TEST_P(CorrectionTest, KeepsTheWalksPowerAndAnExactAnswer) {
  const Correction correction(surface_);
  walk(1e4);
  double walked = 0.0, corrected = 0.0;
  const std::vector<double> better = correction.corrected(answer_, walk_, noise_, 0.05).exitance;
  for (std::size_t i = 0; i < better.size(); ++i) {
    walked += surface_.area[i] * walk_[i];
    corrected += surface_.area[i] * better[i];
  }
  EXPECT_NEAR(corrected, walked, 1e-9 * walked);
  // Where the answer is trusted the noise of walks stays out, all but that of their power.
  EXPECT_LT(error_of(correction.corrected(exact_, walk_, noise_, 1e-6).exitance), 0.03);
  // A walk without noise that agrees changes nothing.
  const std::vector<double> none(exact_.size(), 0.0);
  EXPECT_LT(error_of(correction.corrected(exact_, exact_, none, 0.1).exitance), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Shapes, CorrectionTest, testing::Values("sphere", "cube", "torus"));

}  // namespace
}  // namespace kappamu::forward

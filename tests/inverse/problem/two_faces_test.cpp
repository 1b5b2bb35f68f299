// Pictures of two faces: the objective is the sum of those of each face alone, whatever the order
// of the pictures, and a light seen on both faces is solved once.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/numbers/dot.h"
#include "inverse/problem/objective.h"
#include "tests/inverse/inverse_cases.h"

namespace kappamu::inverse {
namespace {

constexpr GridShape block{7, 5, 4, 0.4};
constexpr double tight = 1e-12;

/// Lights 0, 0, 1, 2, 1 on the faces z−, z+, z−, z+, z+.
constexpr std::array<int, 5> lights{0, 0, 1, 2, 1};
const std::vector<Face> faces{Face::z_minus, Face::z_plus, Face::z_minus, Face::z_plus,
                              Face::z_plus};

Problem of_both_faces() {
  cases::Noise noise(3);
  const Problem lit = cases::randomly_lit(block, 3, noise);
  Problem problem = lit;
  problem.seen_face = faces.front();
  problem.seen_faces = faces;
  problem.patterns = static_cast<int>(lights.size());
  problem.irradiance.clear();
  const auto cells = static_cast<std::ptrdiff_t>(problem.lit_shape().cells());
  for (const int light : lights) {
    const auto first = lit.irradiance.begin() + light * cells;
    problem.irradiance.insert(problem.irradiance.end(), first, first + cells);
  }
  for (std::size_t i = 0; i < lights.size() * problem.seen_shape().cells(); ++i) {
    problem.data.push_back(0.1 * noise.uniform());
    problem.weight.push_back(i % 7 == 0 ? 0.0 : 1.0 + noise.uniform());
  }
  return problem;
}

/// The pictures of one of the faces, as a problem of its own.
Problem of_one_face(const Problem& both, Face face) {
  Problem one = both;
  one.seen_face = face;
  one.seen_faces.clear();
  one.patterns = 0;
  one.irradiance.clear();
  one.data.clear();
  one.weight.clear();
  const auto take = [&](const std::vector<double>& from, std::size_t cells, std::size_t m,
                        std::vector<double>& to) {
    const auto first = from.begin() + static_cast<std::ptrdiff_t>(m * cells);
    to.insert(to.end(), first, first + static_cast<std::ptrdiff_t>(cells));
  };
  for (std::size_t m = 0; m < both.seen_faces.size(); ++m) {
    if (both.seen_faces[m] != face) continue;
    ++one.patterns;
    take(both.irradiance, both.lit_shape().cells(), m, one.irradiance);
    take(both.data, both.seen_shape().cells(), m, one.data);
    take(both.weight, both.seen_shape().cells(), m, one.weight);
  }
  return one;
}

class TwoFaces : public ::testing::TestWithParam<forward::SourceModel> {
 protected:
  static Backend backend() {
    return {"reference", forward::Precision::double_precision, {1e-13, 2000}, 2, 64.0};
  }
  static Problem both() {
    Problem problem = of_both_faces();
    problem.setup.source = GetParam();
    return problem;
  }
};

TEST_P(TwoFaces, ValueAndGradientAreTheSumsOverTheFaces) {
  const CoefficientPair at = cases::rough_medium(block, 0.4, 5);
  Objective together(both(), backend());
  double value = 0.0;
  CoefficientPair gradient{std::vector<double>(block.cells(), 0.0),
                           std::vector<double>(block.cells(), 0.0)};
  for (const Face face : {Face::z_minus, Face::z_plus}) {
    Objective alone(of_one_face(both(), face), backend());
    value += alone.value(at);
    const CoefficientPair own = alone.gradient();
    for (std::size_t i = 0; i < block.cells(); ++i) {
      gradient.log_kappa[i] += own.log_kappa[i];
      gradient.log_mu[i] += own.log_mu[i];
    }
  }
  EXPECT_NEAR(together.value(at), value, tight * value);
  const CoefficientPair found = together.gradient();
  const double size = std::sqrt(dot(gradient.log_kappa, gradient.log_kappa) +
                                dot(gradient.log_mu, gradient.log_mu));
  constexpr double solver = 1e-10;  // single solves to 1e-13
  for (std::size_t i = 0; i < block.cells(); ++i) {
    EXPECT_NEAR(found.log_kappa[i], gradient.log_kappa[i], solver * size) << i;
    EXPECT_NEAR(found.log_mu[i], gradient.log_mu[i], solver * size) << i;
  }
}

TEST_P(TwoFaces, TangentIsTheTransposeOfTheAdjoint) {
  Objective objective(both(), backend());
  objective.value(cases::rough_medium(block, 0.4, 5));
  const CoefficientPair direction = cases::random_direction(block, 6);
  const std::vector<double> change = objective.jacobian(direction);
  cases::Noise noise(9);
  std::vector<double> probe(change.size());
  for (double& x : probe) x = noise.normal();
  const CoefficientPair back = objective.jacobian_transpose(probe);
  const double left = dot(change, probe);
  const double right =
      dot(back.log_kappa, direction.log_kappa) + dot(back.log_mu, direction.log_mu);
  EXPECT_NEAR(left, right, 1e-9 * std::abs(left));
}

TEST_P(TwoFaces, CorrectionOfTheGridIsThatOfEachFace) {
  const CoefficientPair at = cases::rough_medium(block, 0.2, 5);
  Objective together(both(), backend());
  together.refresh_correction(refine(together.problem()), at);
  const std::vector<double>& ratio = together.correction().ratio;
  const std::size_t cells = together.problem().seen_shape().cells();
  constexpr double coarse_solves = 1e-3;  // Backend::refined_tolerance, other batches
  for (const Face face : {Face::z_minus, Face::z_plus}) {
    Objective alone(of_one_face(both(), face), backend());
    alone.refresh_correction(refine(alone.problem()), at);
    std::size_t k = 0;
    for (std::size_t m = 0; m < faces.size(); ++m) {
      if (faces[m] != face) continue;
      for (std::size_t i = 0; i < cells; ++i, ++k) {
        EXPECT_NEAR(ratio[m * cells + i], alone.correction().ratio[k], coarse_solves);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sources, TwoFaces,
                         ::testing::Values(forward::SourceModel::first_collision,
                                           forward::SourceModel::boundary),
                         [](const auto& of) {
                           return of.param == forward::SourceModel::boundary
                                      ? std::string("boundary")
                                      : std::string("first_collision");
                         });

TEST(TwoFacesCost, ALightSeenTwiceIsSolvedOnce) {
  const Problem problem = of_both_faces();
  const Views views = problem.views();
  EXPECT_EQ(views.lights(), 3);
  EXPECT_EQ(views.faces().list, (std::vector<Face>{Face::z_minus, Face::z_plus}));
  EXPECT_EQ(views.of_lights(problem.irradiance).size(), 3 * problem.lit_shape().cells());
}

TEST(TwoFacesErrors, SharedErrorsOfTheFacesAreIndependent) {
  const FaceShape face{6, 5};
  constexpr double signal_front = 80.0, signal_back = 30.0;
  const SmoothError error{2e-3, 3e-3};
  const SmoothErrorPrecision both(face, {{{0, 2}, signal_front}, {{1, 3, 4}, signal_back}}, error);
  cases::Noise noise(4);
  std::vector<double> residuals(5 * face.cells());
  for (double& x : residuals) x = noise.normal();
  std::vector<double> together = residuals;
  both.apply(together);
  const auto expect_alone = [&](const std::vector<int>& pictures, double signal) {
    std::vector<double> own;
    for (const int m : pictures) {
      const auto first = residuals.begin() + m * static_cast<std::ptrdiff_t>(face.cells());
      own.insert(own.end(), first, first + static_cast<std::ptrdiff_t>(face.cells()));
    }
    SmoothErrorPrecision(face, static_cast<int>(pictures.size()), signal, error).apply(own);
    for (std::size_t k = 0; k < own.size(); ++k) {
      const auto m = static_cast<std::size_t>(pictures[k / face.cells()]);
      EXPECT_DOUBLE_EQ(together[m * face.cells() + k % face.cells()], own[k]);
    }
  };
  expect_alone({0, 2}, signal_front);
  expect_alone({1, 3, 4}, signal_back);
}

}  // namespace
}  // namespace kappamu::inverse

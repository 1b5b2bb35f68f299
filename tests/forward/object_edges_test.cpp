// What every model of objects does at its edges (docs/limits.md, "Objects"): the answer, or the
// sentence that a person reads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/error.h"
#include "core/mesh/shapes.h"
#include "forward/registry.h"
#include "tests/forward/lit_object.h"

namespace kappamu::forward {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kappa = 0.3, mean_free_path = 3.0 * kappa;
const Coefficients marble_like{kappa, 0.01};

struct Answer {
  std::string sentences;  ///< refusal, or warnings and why candidates were left
  ObjectResult result;    ///< empty where refused

  double leaving() const {
    return result.balance.front().exiting / result.balance.front().entering;
  }
};

Answer answer(const std::string& name, TriangleMesh mesh, const Coefficients& filling) {
  LitObject object(std::move(mesh), ObjectMedium(filling));
  object.lights = {sun(object.mesh)};
  ObjectOptions options;
  options.tolerance = 0.1;
  Progress silent;
  Answer answer;
  try {
    answer.result = make_walking(name, 1e5)->solve(object.problem(), options, silent);
    for (const std::string& warning : answer.result.warnings) answer.sentences += warning + "\n";
    for (const ModelCandidate& candidate : answer.result.candidates)
      answer.sentences += candidate.model + ": " + candidate.reason + "\n";
    EXPECT_TRUE(std::ranges::all_of(answer.result.exitance,
                                    [](double e) { return std::isfinite(e) && e >= 0.0; }));
  } catch (const InputError& refusal) {
    answer.sentences = refusal.what();
  }
  return answer;
}

/// The mesh with an edge of its first triangle split at `part` of its length.
TriangleMesh with_slivers(TriangleMesh mesh, double part) {
  const int a = mesh.triangles[0][0], b = mesh.triangles[0][1];
  const auto place = [&](int v) { return mesh.vertices[static_cast<std::size_t>(v)]; };
  const int added = static_cast<int>(mesh.vertices.size());
  mesh.vertices.push_back(place(a) + part * (place(b) - place(a)));
  for (std::size_t t = 0, all = mesh.triangles.size(); t < all; ++t) {
    auto& triangle = mesh.triangles[t];
    const auto at_a = std::ranges::find(triangle, a), at_b = std::ranges::find(triangle, b);
    if (at_a == triangle.end() || at_b == triangle.end()) continue;
    auto other = triangle;
    other[static_cast<std::size_t>(at_a - triangle.begin())] = added;
    *at_b = added;
    mesh.triangles.push_back(other);
  }
  return mesh;
}

class Edges : public testing::TestWithParam<std::string> {
 protected:
  bool diffusion() const { return model().errs_by == &measured("embedded").error; }
  const ModelDescription& model() const { return object_model(GetParam()); }
  bool walks() const { return model().can.transport; }
  bool chooses() const { return model().can.chooses; }
  bool half_space() const { return !diffusion() && !walks() && !chooses(); }
};

TEST_P(Edges, SliversChangeNothingOrAreRefused) {
  const TriangleMesh cube = make_shape("cube", 8.0, 6);
  const double plain = answer(GetParam(), cube, marble_like).leaving();
  EXPECT_NEAR(answer(GetParam(), with_slivers(cube, 1e-3), marble_like).leaving(), plain,
              0.02 * plain);
  const Answer thinner = answer(GetParam(), with_slivers(cube, 1e-6), marble_like);
  if (GetParam() == "boundary_integral") {
    EXPECT_THAT(thinner.sentences,
                HasSubstr("is a sliver, its height below 1e-4 of its longest edge; remesh it or "
                          "use model embedded"));
  } else {
    EXPECT_NEAR(thinner.leaving(), plain, 0.02 * plain);
  }
}

TEST_P(Edges, ThinObjectsAreWarnedOf) {
  const std::string said =
      answer(GetParam(), make_shape("slab", 8.0, 12, 0.5 * mean_free_path / 8.0), marble_like)
          .sentences;
  if (!model().can.any_shape) {
    EXPECT_THAT(said, HasSubstr("answers for boxes along the axes whose edges are whole numbers"));
  } else if (diffusion()) {
    EXPECT_THAT(said, AllOf(HasSubstr("the model itself errs by probably more than "),
                            HasSubstr("albedo (0.99), thickness (2V/S, 0.45 mean free paths)")));
  } else if (half_space()) {
    EXPECT_THAT(said, HasSubstr("of the surface is thinner than 5 mean free paths; the dipole "
                                "creates light there"));
  } else if (chooses()) {
    EXPECT_THAT(said, AllOf(HasSubstr("embedded: not measured on objects as thin as 0.45"),
                            HasSubstr("montecarlo: ")));
  } else {
    EXPECT_EQ(said, "");
  }
}

TEST_P(Edges, PartsThinnerThanAPolycubesCellsAreReportedByPolygridAlone) {
  const Answer thin =
      answer(GetParam(), make_shape("slab", 8.0, 12, 0.05 * mean_free_path / 8.0), marble_like);
  if (GetParam() == "polygrid") {
    EXPECT_THAT(thin.sentences, HasSubstr("too thin for its cells: take more"));
  } else if (!model().can.any_shape) {
    EXPECT_THAT(thin.sentences, HasSubstr("answers for boxes along the axes"));
  } else {
    EXPECT_GT(thin.leaving(), 0.0);
  }
}

TEST_P(Edges, VoidsAreWallsOrWarnedOf) {
  const Answer hollow = answer(GetParam(), make_shape("box-with-void", 8.0, 8), marble_like);
  if (GetParam() == "polygrid") {
    EXPECT_THAT(hollow.sentences, HasSubstr("is made of a mesh in one piece; this one has 2"));
  } else if (!model().can.any_shape) {
    EXPECT_THAT(hollow.sentences, HasSubstr("answers for boxes along the axes"));
  } else if (half_space()) {
    EXPECT_THAT(hollow.sentences,
                HasSubstr("the mesh has 2 separate surfaces; the dipole sends light across the "
                          "voids and gaps between them"));
  } else {
    EXPECT_NEAR(hollow.leaving(), 0.894, 0.01);  // two million photons
  }
}

TEST_P(Edges, WithoutAbsorptionAllLightLeaves) {
  const Answer clear = answer(GetParam(), make_shape("cube", 8.0, 6), {kappa, 0.0});
  if (half_space()) {
    // The half-space keeps what passes through the object, or lets more leave than enters.
    EXPECT_THAT(clear.sentences, HasSubstr("thinner than 2 diffusion lengths"));
  } else {
    EXPECT_NEAR(clear.leaving(), 1.0, 2e-3);
  }
}

TEST_P(Edges, AlbedosWhereDiffusionIsWrongAreWarnedOf) {
  const TriangleMesh cube = make_shape("cube", 8.0, 6);
  const std::string half = answer(GetParam(), cube, {kappa, 0.5 / mean_free_path}).sentences;
  const Answer none = answer(GetParam(), cube, {kappa, 1.0 / mean_free_path});
  if (diffusion()) {
    EXPECT_THAT(half, HasSubstr("% against transport on an object of this albedo (0.5), thickness "
                                "(2V/S, 3 mean free paths) and shape"));
  } else if (half_space()) {
    EXPECT_THAT(half, HasSubstr("a share of 0.5 of collisions absorbs; diffusion is wrong"));
    EXPECT_THAT(none.sentences, HasSubstr("the dipole needs kappa > 0 and mu in 0 <= mu < "));
    return;
  } else if (chooses()) {
    EXPECT_THAT(half, HasSubstr("embedded: not measured at an albedo as low as 0.5"));
  } else {
    EXPECT_EQ(half, "");
  }
  EXPECT_EQ(none.leaving(), 0.0);
}

std::vector<std::string> all_names() {
  std::vector<std::string> names;
  for (const ModelDescription& model : object_models()) names.push_back(model.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(AllModels, Edges, testing::ValuesIn(all_names()), [](const auto& name) {
  std::string word = name.param;
  std::ranges::replace(word, '-', '_');
  return word;
});

}  // namespace
}  // namespace kappamu::forward

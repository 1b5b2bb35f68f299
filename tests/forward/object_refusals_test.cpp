// What every model of objects refuses, by whatever name it is made.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/mesh/shapes.h"
#include "forward/registry.h"
#include "tests/forward/lit_object.h"
#include "tests/sentence.h"

namespace kappamu::forward {
namespace {

std::string refusal_by(const std::string& model, const TriangleMesh& mesh) {
  LitObject object(mesh, ObjectMedium(Coefficients{0.3, 0.01}));
  object.lights = {sky(object.surface)};
  ObjectOptions options;
  options.tolerance = 0.2;
  Progress silent;
  return sentence_of([&] { make_walking(model, 1e3)->solve(object.problem(), options, silent); },
                     "nothing refused");
}

class Refusals : public testing::TestWithParam<std::string> {};

TEST_P(Refusals, OfMeshesThatAreOpenFlippedOrInsideOut) {
  const TriangleMesh whole = make_shape("cube", 6.0, 3);
  EXPECT_EQ(refusal_by(GetParam(), whole), "nothing refused");
  TriangleMesh open = whole;
  open.triangles.pop_back();
  EXPECT_THAT(refusal_by(GetParam(), open),
              testing::HasSubstr("the mesh is open at an edge of triangle"));
  TriangleMesh flipped = whole;
  std::swap(flipped.triangles[5][0], flipped.triangles[5][1]);
  EXPECT_THAT(refusal_by(GetParam(), flipped), testing::HasSubstr("face opposite ways"));
  EXPECT_THAT(refusal_by(GetParam(), turned_inside_out(whole)),
              testing::HasSubstr("encloses no volume"));
}

INSTANTIATE_TEST_SUITE_P(AllModels, Refusals, testing::ValuesIn(object_model_names()),
                         [](const auto& name) {
                           std::string word = name.param;
                           std::replace(word.begin(), word.end(), '-', '_');
                           return word;
                         });

}  // namespace
}  // namespace kappamu::forward

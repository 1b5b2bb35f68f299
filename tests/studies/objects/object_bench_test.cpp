// Patches, references and errors of the bench of objects by their laws, and every model there is on
// a toy scene.
#include "studies/objects/object_bench.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "core/mesh/shapes.h"
#include "forward/registry.h"
#include "studies/objects/object_case.h"
#include "studies/objects/object_measurement.h"
#include "studies/objects/object_reference.h"
#include "tests/sentence.h"
#include "tests/studies/bench_tools.h"

namespace kappamu::studies {
namespace {

using testing::HasSubstr;

constexpr double rounding = 1e-12;
constexpr const char* meshes = KAPPAMU_SOURCE_DIR "/scenes/meshes";
constexpr const char* volume = KAPPAMU_SOURCE_DIR "/studies/objects/volume";

TEST(Patches, HoldTheWholeSurfaceAndKeepIntegrals) {
  const TriangleMesh mesh = make_shape("torus", 3.0, 20);
  const Surface surface = surface_of(mesh);
  const forward::Patches patches = forward::make_patches(surface, bounding_box(mesh), 6);
  EXPECT_GT(patches.size(), 50U);
  EXPECT_LT(patches.size(), surface.size() / 4);
  const double area = std::accumulate(surface.area.begin(), surface.area.end(), 0.0);
  EXPECT_NEAR(std::accumulate(patches.area.begin(), patches.area.end(), 0.0), area,
              rounding * area);
  std::vector<double> height;
  for (const Eigen::Vector3d& p : surface.position) height.push_back(5.0 + p.z());
  double of_samples = 0.0, of_patches = 0.0;
  for (std::size_t i = 0; i < surface.size(); ++i) of_samples += surface.area[i] * height[i];
  const std::vector<double> means = patches.mean(height, surface);
  for (std::size_t p = 0; p < patches.size(); ++p) of_patches += patches.area[p] * means[p];
  EXPECT_NEAR(of_patches, of_samples, rounding * of_samples);
}

TEST(Patches, SeparateTheTwoSidesOfASheet) {
  const TriangleMesh mesh = make_shape("sheet", 3.0, 40);
  const Surface surface = surface_of(mesh);
  const forward::Patches patches = forward::make_patches(surface, bounding_box(mesh), 4);
  std::vector<double> side;
  for (const Eigen::Vector3d& normal : surface.normal) side.push_back(normal.z());
  for (const double mean : patches.mean(side, surface)) {
    EXPECT_NEAR(std::abs(std::abs(mean) - 0.5), 0.5, rounding);  // 1, -1, or 0 on the rim
  }
}

TEST(ObjectError, IsTheDifferencesShareAndLeavesOutTheNoise) {
  const Patches patches{{}, {1.0, 3.0}};
  const ObjectReference exact{{2.0, 2.0}, {0.0, 0.0}};
  EXPECT_EQ(error_against(exact, patches, {2.0, 2.0}, 0.0).two_norm, 0.0);
  const ObjectError tenth = error_against(exact, patches, {2.2, 2.2}, 0.05);
  EXPECT_NEAR(tenth.two_norm, 0.1, rounding);
  EXPECT_NEAR(tenth.mean, 0.1, rounding);
  EXPECT_EQ(tenth.outside, 1.0);
  EXPECT_EQ(error_against(exact, patches, {2.2, 2.2}, 0.11).outside, 0.0);
  EXPECT_NEAR(error_against(exact, patches, {2.2, 2.0}, 0.05).outside, 0.25, rounding);
  // A difference as large as the noise is none.
  const ObjectReference noisy{{2.0, 2.0}, {0.1, 0.1}};
  const ObjectError none = error_against(noisy, patches, {2.1, 1.9}, 0.0);
  EXPECT_NEAR(none.two_norm, 0.0, 1e-7);
  EXPECT_NEAR(none.reference_error, 0.1 / std::sqrt(4.0 - 0.01), rounding);
  EXPECT_EQ(none.outside, 0.0);
}

TEST(LitSphere, LetsOutAllWithoutAbsorptionAndLessWithMore) {
  const BoundaryConstants constants = boundary_constants(1.4);
  const double entering = 1.4 * 1.4 * (1.0 - constants.r_phi);
  EXPECT_NEAR(exitance_of_lit_sphere(3.0, 0.2, 1e-9, 1.4), entering, 1e-6);
  double last = entering;
  for (const double mu : {1e-3, 1e-2, 1e-1}) {
    const double exitance = exitance_of_lit_sphere(3.0, 0.2, mu, 1.4);
    EXPECT_LT(exitance, last);
    last = exitance;
  }
  // Lengths scale: nothing else does.
  EXPECT_NEAR(exitance_of_lit_sphere(3.0, 0.2, 0.1, 1.4),
              exitance_of_lit_sphere(6.0, 0.4, 0.05, 1.4), rounding);
}

TEST(ObjectCases, AreNamedOnceAndUnknownOnesRefused) {
  std::vector<std::string> names;
  for (const Population population : {Population::tuning, Population::validation}) {
    for (const ObjectCase& c : object_cases(population, {})) names.push_back(c.name);
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
  EXPECT_THAT(names, testing::IsSupersetOf({"nefertiti-marble-24", "box-with-void-skin1-24",
                                            "sphere-marble-8-sky", "bob-block-24"}));
  EXPECT_THAT(sentence_of([] { object_cases(Population::tuning, {"bunny"}); }),
              HasSubstr("begins with 'bunny'"));
}

TEST(ObjectCases, AreDrawnBySeed) {
  Progress silent;
  std::set<std::string> names, others;
  for (const ObjectCase& c : drawn_cases(100, 3)) {
    names.insert(c.name);
    EXPECT_GE(c.size, 10.0);
    EXPECT_LE(c.size, 70.0);
  }
  for (const ObjectCase& c : drawn_cases(100, 4)) others.insert(c.name);
  EXPECT_EQ(names.size(), 100U);
  EXPECT_NE(names, others);
  for (const ObjectCase& c : drawn_cases(3, 3)) {
    EXPECT_TRUE(names.contains(c.name));
    EXPECT_GT(make_object_bench(c, meshes, volume, silent).power, 0.0) << c.name;
  }
}

TEST(ObjectCases, OfAFileAreNamedByIt) {
  Progress silent;
  const std::vector<ObjectCase> cases = cases_of_files({std::string(meshes) + "/spot.ply"});
  ASSERT_EQ(cases.size(), 4U);
  EXPECT_EQ(cases[0].name, "spot-marble-8");
  const ObjectBench named = make_object_bench(
      object_cases(Population::tuning, {"spot-marble-8"}).front(), meshes, volume, silent);
  const ObjectBench of_file = make_object_bench(cases[0], "nowhere", volume, silent);
  EXPECT_EQ(named.power, of_file.power);
}

TEST(ObjectCases, HaveTheirSizeInMeanFreePaths) {
  Progress silent;
  for (const char* name : {"sphere-marble-8-sky", "bob-block-24"}) {
    const ObjectCase c = object_cases(Population::tuning, {name}).front();
    const ObjectBench bench = make_object_bench(c, meshes, volume, silent);
    const double longest = bounding_box(bench.object().mesh).sizes().maxCoeff();
    EXPECT_NEAR(longest / (3.0 * bench.kappa_mm), c.size, 1e-9 * c.size);
    EXPECT_GT(bench.power, 0.0);
    if (c.light == CaseLight::sky) {
      EXPECT_NEAR(bench.thickness, c.size / 3.0, 1e-3 * c.size) << "a sphere's 2V/S is 2R/3";
      EXPECT_NEAR(bench.power, EIGEN_PI * longest * longest, 1e-3 * bench.power);
    }
  }
}

/// Whatever the shape and the medium, light that arrives is reflected, or enters and is absorbed,
/// leaves scattered or leaves unscattered: each part counted by itself.
TEST(ObjectPower, InIsAbsorbedOrLeaves) {
  constexpr double balanced = 1e-5;
  Progress silent;
  for (const char* name : {"torus-skin1-24", "box-with-void-marble-8", "bob-block-24"}) {
    const ObjectBench bench =
        make_object_bench(object_cases(Population::tuning, {name}).front(), meshes, volume, silent);
    const Surface& surface = bench.object().surface;
    double entering = 0.0;
    for (const forward::Beam& beam : bench.lights[0].beams) {
      const double cosine =
          -beam.direction.dot(surface.normal[static_cast<std::size_t>(beam.triangle)]);
      entering += beam.power * (1.0 - fresnel_external(bench.object().boundary.eta, cosine));
    }
    for (const char* model : {"embedded", "montecarlo"}) {
      forward::ObjectOptions options;
      options.tolerance = 0.3;
      const forward::ObjectResult result =
          make_walking(model, 2000)->solve(bench.problem(), options, silent);
      const forward::ObjectBalance& balance = result.balance.front();
      double exiting = 0.0;
      for (std::size_t i = 0; i < surface.size(); ++i) {
        exiting += surface.area[i] * result.exitance[i];
      }
      EXPECT_NEAR(balance.entering, entering, balanced * entering) << name << " " << model;
      EXPECT_NEAR(balance.exiting, exiting, balanced * entering) << name << " " << model;
      EXPECT_NEAR(exiting + balance.absorbed + balance.unscattered, entering, balanced * entering)
          << name << " " << model;
      EXPECT_GT(balance.unscattered, 0.0) << name << " " << model;
      EXPECT_LT(entering, bench.power) << "a part is reflected";
    }
  }
}

class ObjectsTest : public RecordTest {
 protected:
  static Request asked(const std::vector<std::string>& scenes) {
    Request request;
    request.settings = {{"scenes", scenes}, {"meshes", {meshes}}, {"volume", {volume}}};
    return request;
  }
};

TEST_F(ObjectsTest, EveryModelAnswersOrRefusesInASentence) {
  const Json record =
      quick_record("objects", "models", asked({"sphere-marble-8-sky", "box-with-void-marble-8"}));
  const Json& rows = record.at("rows");
  EXPECT_EQ(rows.size(), 2 * (forward::object_model_names().size() - 1)) << "all but one";
  for (const Json& row : rows) {
    const std::string what = row.at("name").get<std::string>() + " " + row.at("model").dump();
    if (row.contains("refused")) {
      EXPECT_THAT(row.at("refused").get<std::string>(), HasSubstr(" ")) << what;
      continue;
    }
    for (const char* key : {"error", "reference_error", "seconds", "elements", "iterations",
                            "triangles", "size_over_mean_free_path", "balance"}) {
      EXPECT_TRUE(row.at(key).is_number()) << what << " " << key;
    }
    if (row.at("model") == "embedded") {
      EXPECT_NEAR(row.at("balance").get<double>(), 0.0, 1e-5) << what;
      EXPECT_LT(row.value("exact_error", 0.0), 1e-3) << what;
    }
    // Toy references: a gross difference all the same.
    if (row.at("model") == "montecarlo") {
      EXPECT_LT(row.at("mean_difference").get<double>(),
                6.0 * row.at("mean_difference_of_noise").get<double>())
          << what;
    }
  }
  EXPECT_EQ(summary(subject("objects"), {record}, folder()), rows);
  expect_charts({"objects-models"}, {"objects-models"});
}

TEST_F(ObjectsTest, AutoIsHeldAgainstTheCheapestThatMetTheTolerance) {
  const Json record = quick_record("objects", "auto", asked({"brick-potato-16-side"}));
  const Json& row = record.at("rows").at(0);
  const double tolerance = row.at("tolerance");
  EXPECT_EQ(row.at("met"), row.at("error").get<double>() <= tolerance);
  EXPECT_TRUE(row.at("within_tolerance").get<bool>());
  if (!row.at("cheapest").is_null()) {
    const std::string cheapest = row.at("cheapest");
    EXPECT_LE(row.at(cheapest + "_error").get<double>(), tolerance);
    EXPECT_NEAR(
        row.at("cost_ratio").get<double>() * row.at(cheapest + "_cpu_seconds").get<double>(),
        row.at("cpu_seconds").get<double>(), 1e-9 * row.at("cpu_seconds").get<double>());
  }
  expect_charts({}, {"objects-auto"});
}

TEST_F(ObjectsTest, TessellationAndScaleChangeNothing) {
  const Json record = quick_record("objects", "invariance", asked({"cube-marble-72-sky"}));
  std::map<std::string, Json> of_change;
  for (const Json& row : record.at("rows")) of_change[row.at("change")] = row;
  ASSERT_EQ(of_change.size(), 4U);
  const Json& as_it_is = of_change.at("none");
  const double allowed = as_it_is.at("error_estimate").get<double>();
  for (const char* edges : {"edges doubled", "edges halved"}) {
    EXPECT_LT(of_change.at(edges).at("difference").get<double>(), allowed) << edges;
    EXPECT_NE(of_change.at(edges).at("triangles"), as_it_is.at("triangles")) << edges;
  }
  const Json& larger = of_change.at("lengths, κ and 1/μ times 3");
  EXPECT_LT(larger.at("difference").get<double>(), 1e-5);
  EXPECT_EQ(larger.at("elements"), as_it_is.at("elements"));
  expect_charts({}, {"objects-invariance"});
}

TEST_F(ObjectsTest, ReferencesAreReadAgainAndThoseOfOtherScenesRefused) {
  Request request = asked({"sphere-marble-8-sky"});
  request.settings["models"] = {"embedded"};
  const auto error_of_embedded = [&] {
    return quick_record("objects", "models", request).at("rows").at(0).at("error");
  };
  const Json first = error_of_embedded();
  const auto file = folder() / "references" / "sphere-marble-8-sky.json";
  ASSERT_TRUE(std::filesystem::exists(file));
  const auto written = std::filesystem::last_write_time(file);
  // Recorded with four digits.
  EXPECT_NEAR(error_of_embedded().get<double>(), first.get<double>(), 1e-3);
  EXPECT_EQ(std::filesystem::last_write_time(file), written);

  std::ifstream in(file);
  Json other = Json::parse(in);
  other["kappa_mm"] = 2.0 * other["kappa_mm"].get<double>();
  std::ofstream(file) << other;
  EXPECT_THAT(sentence_of(error_of_embedded), HasSubstr("kappa_mm is"));
  std::ofstream(file) << "{\"format\":";
  EXPECT_THAT(sentence_of(error_of_embedded), HasSubstr("is damaged"));
}

}  // namespace
}  // namespace kappamu::studies

// The record of a fit's options: complete, so that equal records mean equal results, and enough to
// restore every option.
#include "pipeline/records/fit_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/read_file.h"
#include "pipeline/records/versions.h"
#include "pipeline/stages/continuation.h"
#include "tests/option_changes.h"
#include "tests/sentence.h"

namespace kappamu::pipeline {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Key;
using ::testing::Pair;

/// Calls `test` with the options as each of them in turn is changed.
template <class Test>
void with_each_changed(const Test& test) {
  std::size_t count = 0;
  for (;; ++count) {
    FitStageOptions options;
    inverse::ChangeOption change{count};
    pipeline::describe(options, change);
    if (!change.changed) break;
    test(options, change.changed->name);
  }
  EXPECT_EQ(count + 1, options_by_name({}).size()) << "all but continue_from";
}

TEST(FitOptionsRecord, ChangesWithEveryOption) {
  const std::string usual = options_json({});
  EXPECT_EQ(usual, options_json({}));
  with_each_changed([&](const FitStageOptions& options, const char* name) {
    EXPECT_NE(options_json(options), usual) << name;
  });
  FitStageOptions continued;
  continued.continue_from = "run/fit";
  EXPECT_NE(options_json(continued), usual);
}

TEST(FitOptionsRecord, RestoresEveryOption) {
  with_each_changed([](const FitStageOptions& options, const char* name) {
    FitStageOptions restored;
    set_options(restored, options_json(options));
    EXPECT_EQ(options_json(restored), options_json(options)) << name;
  });
}

TEST(FitOptionsRecord, NamesWhatAReaderLooksFor) {
  FitStageOptions options;
  options.fit.path.target_chi2 = 1.25;
  EXPECT_THAT(options_by_name(options), Contains(Pair("target_chi2", "1.25")));
  EXPECT_THAT(options_by_name(options), Contains(Pair("optimiser", "lbfgs")));
}

TEST(FitOptionsRecord, DamageIsNamed) {
  FitStageOptions options;
  EXPECT_EQ(sentence_of([&] { set_options(options, R"({"loss": "quartic"})"); }),
            "loss is not one of gaussian, huber or student");
  EXPECT_EQ(sentence_of([&] { set_options(options, R"({"target_chi2": "one"})"); }),
            "type must be number, but is string");
  for (const char* steps : {"4294967297", "2e113", "1.5", "-3000000000"}) {
    EXPECT_EQ(
        sentence_of(
            [&] { set_options(options, R"({"stage_steps": )" + std::string(steps) + "}"); }),
        "type must be a whole number in range, but is " + nlohmann::json::parse(steps).dump());
  }
  EXPECT_EQ(options.fit.path.stage_steps, FitStageOptions().fit.path.stage_steps);
}

/// `kappamu fit --continue` restored no --uncertainty, no --model, and nothing that only programs
/// set.
TEST(FinishedFit, RestoresEveryOptionOfTheFitItGoesOnFrom) {
  const fs::path folder = fs::path(KAPPAMU_TEST_FOLDER) / "finished_fit";
  fs::create_directories(folder);
  with_each_changed([&](const FitStageOptions& options, const char* name) {
    const nlohmann::json fit{{"input", "measurements"},
                             {"options", nlohmann::json::parse(options_json(options))},
                             {"validation", {{"patterns", nlohmann::json::array()}}},
                             {"channels", nlohmann::json::array()}};
    std::ofstream(folder / "fit.json") << fit.dump();
    FitStageOptions restored = usual_options();
    FinishedFit(folder).set_options(restored);
    EXPECT_EQ(options_json(restored), options_json(options)) << name;
  });
}

TEST(FitOptionsPage, IsWhatTheProgramMakes) {
  EXPECT_EQ(io::read_text(fs::path(KAPPAMU_SOURCE_DIR) / "docs/reference/fit-options.md"),
            options_page())
      << "renew it: kappamu fit --options-table > docs/reference/fit-options.md";
  EXPECT_THAT(options_page(), HasSubstr("| uncertainty_probes | `--uncertainty` | 8 |"));
}

TEST(FitOptionsPaper, ImpliesItsCoordinatesAndItsLambda) {
  FitStageOptions options;
  options.fit.solver.optimiser.method = inverse::Method::wang2008;
  options.fit.regulariser.kind = inverse::RegulariserKind::wang2008;
  options = resolve(options);
  EXPECT_EQ(options.fit.solver.coordinates, inverse::Coordinates::voxels);
  EXPECT_EQ(options.fit.path.weight, 1e-5);
  options.fit.solver.optimiser.method = inverse::Method::lbfgs;
  EXPECT_EQ(resolve(options).fit.solver.coordinates, inverse::Coordinates::informed);
}

TEST(Versions, ListTheLibrariesThatFiguresDependOn) {
  for (const char* name :
       {"kappamu", "compiler", "OpenCV", "Ceres", "OpenImageIO", "OpenVDB", "Eigen"})
    EXPECT_THAT(pipeline::library_versions(), Contains(Key(name)));
}

}  // namespace
}  // namespace kappamu::pipeline

// A model from outside the tree (examples/lambert), added by one line of its own program: it is in
// scenes, in help, among the candidates of `auto` and in the window's list.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/read_file.h"
#include "process.h"

namespace kappamu::app {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

class OwnModel : public TemporaryFolderTest {
 protected:
  static ProcessResult lambert(const std::string& arguments, const std::string& before = "") {
    return run_process(before + KAPPAMU_LAMBERT " " + arguments);
  }
  std::string path(const char* name) const { return (folder() / name).string(); }

  void write_scene(const json& model) const {
    const json scene{
        {"format", "kappamu-scene"},
        {"version", 1},
        {"objects",
         {{{"name", "ball"},
           {"shape", "sphere"},
           {"size_mm", 10},
           {"material", {{"published", "marble"}}}}}},
        {"lights",
         {{{"kind", "directional"}, {"direction", {0, -1, -1}}, {"irradiance", {1, 0.9, 0.8}}}}},
        {"camera", {{"position_mm", {0, 0, 50}}, {"target_mm", {0, 0, 0}}, {"fov_deg", 16}}},
        {"film", {{"width", 32}, {"height", 24}, {"samples", 4}}},
        {"model", model}};
    io::write_text_atomically(folder() / "scene.json", scene.dump());
  }

  json rendered(const std::string& options = "") const {
    const ProcessResult result =
        lambert("--json render " + path("scene.json") + " -o " + path("out") + options);
    EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 3) << result.standard_error;
    return json::parse(last_line(result.standard_output));
  }
};

TEST_F(OwnModel, AnswersInScenesByItsOwnParameter) {
  write_scene({{"name", "lambert"}, {"reflectance", 0.25}});
  json summary = rendered();
  EXPECT_EQ(summary["parameters"], json({{"reflectance", 0.25}}));
  EXPECT_THAT(
      summary["warnings"].dump(),
      HasSubstr("the error of the model lambert against transport was not measured; Nothing "
                "is translucent"));
  const json green = summary["objects"][0]["channels"][1];
  EXPECT_GT(green["entering"].get<double>(), 0.0);
  EXPECT_NEAR(green["out"].get<double>(), 0.25 * green["entering"].get<double>(), 1e-9);
  summary = rendered(" --parameter reflectance=0.5");
  EXPECT_EQ(summary["parameters"], json({{"reflectance", 0.5}}));
  // By itself as much as of a half-space: marble absorbs little.
  write_scene({{"name", "embedded"}});
  const json own = rendered(" --model lambert")["objects"][0]["channels"][1];
  EXPECT_GT(own["out"].get<double>(), 0.5 * own["entering"].get<double>());
}

TEST_F(OwnModel, RefusesWhatItsDescriptionDoesNotAllow) {
  const auto refused = [&](const json& model) {
    write_scene(model);
    const ProcessResult result = lambert("render " + path("scene.json") + " -o " + path("out"));
    EXPECT_EQ(result.exit_code, 1);
    return result.standard_error;
  };
  EXPECT_THAT(refused({{"name", "lambert"}, {"reflectance", 2}}),
              HasSubstr("reflectance must lie in [0, 1)"));
  EXPECT_THAT(refused({{"name", "lambert"}, {"photons", 100}}),
              HasSubstr("allowed here are 'name', 'tolerance', 'max_elements', 'follow_reentry', "
                        "'reflectance'"));
  const ProcessResult plain = kappamu("render " + path("scene.json") + " -o " + path("out"));
  EXPECT_THAT(plain.standard_error, HasSubstr("'lambert'; write one of auto, embedded,"));
}

TEST_F(OwnModel, IsInHelpAndSchemaOfItsProgramAlone) {
  const std::string help = lambert("render --help").standard_output;
  EXPECT_THAT(help, HasSubstr("lambert            Light leaves where it entered"));
  EXPECT_THAT(help, HasSubstr("reflectance (0): Share of the entering light that leaves"));
  EXPECT_THAT(lambert("view --help").standard_output, HasSubstr("lambert"));
  EXPECT_THAT(kappamu("render --help").standard_output, Not(HasSubstr("lambert")));
  const json schema = json::parse(lambert("render --model-schema").standard_output);
  EXPECT_EQ(schema["oneOf"].back()["properties"]["name"]["const"], "lambert");
  EXPECT_EQ(schema["oneOf"].back()["properties"]["reflectance"]["exclusiveMaximum"], 1.0);
}

TEST(ModelsPage, IsWhatTheProgramMakes) {
  EXPECT_EQ(io::read_text(KAPPAMU_SOURCE_DIR "/docs/reference/models.md"),
            kappamu("render --models-page").standard_output)
      << "renew it: kappamu render --models-page > docs/reference/models.md";
}

TEST_F(OwnModel, IsACandidateOfAuto) {
  write_scene({{"name", "auto"}, {"tolerance", 0.3}});
  const json candidates = rendered()["objects"][0]["candidates"];
  EXPECT_THAT(candidates, Contains(json({{"model", "lambert"},
                                         {"error", nullptr},
                                         {"seconds", nullptr},
                                         {"reason", "its error and cost were not measured"}})));
}

TEST_F(OwnModel, IsInTheWindowsList) {
  if (run_process("command -v Xvfb").exit_code != 0)
    GTEST_SKIP() << "Xvfb is not there: the window is not tested";
  write_scene({{"name", "embedded"}});
  io::write_text_atomically(folder() / "script.txt",
                            "screenshot usual.png\nmodel lambert\nscreenshot lambert.png\nquit\n");
  const ProcessResult result = lambert("--json view " + path("scene.json") + " --script " +
                                           path("script.txt") + " -o " + folder().string(),
                                       on_a_screen);
  if (result.standard_error.find("built without its window") != std::string::npos)
    GTEST_SKIP() << result.standard_error;
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  const json summary = json::parse(last_line(result.standard_output));
  // First those for homogeneous objects alone.
  EXPECT_EQ(summary["models"], json({"dipole-rotated", "lambert", "embedded", "polygrid"}));
  EXPECT_EQ(summary["model"], "lambert");
  EXPECT_NE(io::read_text(folder() / "usual.png"), io::read_text(folder() / "lambert.png"));
}

}  // namespace
}  // namespace kappamu::app

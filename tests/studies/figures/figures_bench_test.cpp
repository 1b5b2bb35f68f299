// `kappamu-studies figures`: what a figure's file may say, and that every section runs in its quick
// form. Whether the pictures look like the papers' is for the eye.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "studies/figures/figure_file.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"
#include "tests/studies/bench_tools.h"

namespace kappamu::studies {
namespace {

using ::testing::HasSubstr;

const char* const figure_text =
    R"({"figure": "[X] figure 1", "title": "A ball", "edges_per_size": 8,
  "scene": {"objects": [{"name": "ball", "shape": "sphere", "size_mm": 20,
                         "material": {"published": "marble"}}],
            "lights": [{"kind": "point", "position_mm": [0, 50, 0], "irradiance": 1, "at_mm": 40}],
            "camera": {"position_mm": [0, 0, 90], "target_mm": [0, 0, 0], "fov_deg": 20},
            "film": {"width": 12, "height": 12, "samples": 1}, "model": {"name": "dipole-rotated"}},
  "rows": [{"name": "plain"}, {"name": "dense", "set": {"/objects/0/material/density": 2}}],
  "columns": [{"name": "one"}, {"name": "other", "set": {"/objects/0/material/published": "skin1"}},
              {"name": "map", "shows": "error", "of": "other", "from": "one"},
              {"name": "clusters", "shows": "clusters", "triangle_at": [0.5, 0.4]}]})";

class FigureFile : public ::testing::Test {
 protected:
  std::string refusal(const std::string& from, const std::string& to) {
    Json root = Json::parse(figure_text);
    std::string text = root.dump();
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(folder_ / "f.json") << text;
    return sentence_of(
        [&] {
          const Figure figure = read_figure(folder_ / "f.json");
          for (const FigureRow& row : figure.rows) {
            scene_of_cell(figure, row, figure.columns[1], true);
          }
        },
        "");
  }
  OwnFolder folder_;
};

TEST_F(FigureFile, CellsAreTheSceneWithWhatRowAndColumnSet) {
  std::ofstream(folder_ / "f.json") << figure_text;
  const Figure figure = read_figure(folder_ / "f.json");
  EXPECT_EQ(figure.name, "f");
  const auto kappa = [&](std::size_t row, std::size_t column) {
    const render::Scene scene =
        scene_of_cell(figure, figure.rows[row], figure.columns[column], false);
    EXPECT_EQ(scene.objects[0].edges_per_size, 8);
    return std::get<render::HomogeneousMaterial>(scene.objects[0].material).kappa_mm[0];
  };
  EXPECT_DOUBLE_EQ(kappa(1, 0), kappa(0, 0) / 2.0);
  EXPECT_DOUBLE_EQ(kappa(1, 1), kappa(0, 1) / 2.0);
  EXPECT_NE(kappa(0, 0), kappa(0, 1));
}

TEST_F(FigureFile, RefusesInOneSentence) {
  EXPECT_EQ(refusal("", ""), "");
  EXPECT_THAT(refusal("\"of\":\"other\"", "\"of\":\"none\""), HasSubstr("no column with pictures"));
  EXPECT_THAT(refusal("\"error\"", "\"noise\""), HasSubstr("'noise' is not shown"));
  EXPECT_THAT(refusal("/objects/0/material/density", "density"), HasSubstr("no place in a scene"));
  EXPECT_THAT(refusal("/objects/0/material/density", "/objects/x/material"), HasSubstr("no place"));
  EXPECT_THAT(refusal("\"skin1\"", "\"gold\""), HasSubstr("column 'other'"));
  EXPECT_THAT(refusal("\"triangle_at\"", "\"triangle\""), HasSubstr("'triangle_at' is missing"));
  EXPECT_THAT(refusal("\"title\"", "\"tittle\""), HasSubstr("'title' is missing"));
}

class FiguresBench : public RecordTest {};

TEST_F(FiguresBench, EverySectionRunsQuickly) {
  const OwnFolder files;
  std::ofstream(files / "f.json") << figure_text;
  Request request;
  request.settings["files"] = {files.path().string()};
  const Json pictures = quick_record("figures", "pictures", request);
  ASSERT_EQ(pictures.at("rows").size(), 4U);
  EXPECT_GT(pictures.at("rows")[1].at("error").get<double>(), 0.0);
  const Json stairs = quick_record("figures", "stairs");
  ASSERT_EQ(stairs.at("rows").size(), 2U);
  EXPECT_GT(stairs.at("rows")[0].at("spread of exitance").get<double>(),
            stairs.at("rows")[1].at("spread of exitance").get<double>());
  const Json weights = quick_record("figures", "weights");
  EXPECT_EQ(weights.at("rows").size(), 4U);
  Request one;
  one.settings["sample"] = {"wax1"};
  const Json samples = quick_record("figures", "samples", one);
  EXPECT_EQ(samples.at("rows").size(), 2U);
  EXPECT_EQ(samples.at("faces").size(), 3U);
  expect_charts({"figures-stairs", "figures-weights", "figures-weights-depth", "figures-samples",
                 "figures-samples-faces"},
                {"figures-pictures", "figures-stairs", "figures-weights", "figures-samples"});
}

}  // namespace
}  // namespace kappamu::studies

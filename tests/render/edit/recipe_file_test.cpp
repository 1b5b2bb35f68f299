// Recipes on disk: what the reader takes and refuses, and docs/edit.schema.json against it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "render/edit/edit.h"
#include "render/scene/scene.h"
#include "tests/own_folder.h"
#include "tests/schema_verdicts.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// Every kind of everything.
json full_recipe() {
  return json::parse(R"({
    "format": "kappamu-edit", "version": 1, "_comment": "all kinds",
    "edits": [
      {"operation": "multiply", "kappa": 1.5, "mu": 0, "channels": ["R"], "where": {"kind": "all"}},
      {"operation": "add", "mu": -0.01, "where": {"kind": "brush", "radius_mm": 2, "depth_mm": 1, "hardness": 0.3,
       "stretch": [1, 2, 1], "strokes": [{"points_mm": [[1, 2, 3], [2, 2, 3]], "inward": [[0, 0, -1]]}]}},
      {"operation": "set", "kappa": 0.2, "where": {"kind": "depth", "from_mm": 0, "to_mm": 1, "faces": ["z+"]}},
      {"operation": "blend", "share": 0.5, "mu": 0.1,
       "where": {"kind": "box", "from_mm": [0, 0, 0], "to_mm": [1, 1, 1]}},
      {"operation": "copy", "offset_mm": [5, 0, 0],
       "where": {"kind": "texture", "image": "leaf.png", "face": "z+", "depth_mm": 1}},
      {"operation": "multiply", "mu": [1, 2, 3], "channels": ["R", "G", "B"], "off": true,
       "where": {"kind": "projection", "image": "leaf.png", "position_mm": [0, 0, 90], "target_mm": [0, 0, 0],
                 "up": [0, 1, 0], "fov_deg": 20, "from_mm": 0.5, "to_mm": 2}},
      {"operation": "set", "albedo": 0.5, "mean_free_path_mm": [0.2, 0.4],
       "where": {"kind": "depth", "frame": "object", "from_mm": 0, "to_mm": 0.5}},
      {"operation": "blend", "share": 0.25, "published": "skin1",
       "where": {"kind": "brush", "frame": "object", "radius_mm": 2, "depth_mm": 1,
                 "strokes": [{"points_mm": [[1, 2, 3]], "inward": [[0, 0, -1]]}]}},
      {"operation": "copy", "offset_mm": [1, 0, 0], "volume": "other.vdb",
       "where": {"kind": "box", "frame": "object", "from_mm": [0, 0, 0], "to_mm": [1, 1, 1]}},
      {"operation": "surface", "eta": 1.5, "roughness": 0.2},
      {"operation": "deform", "instead": true, "deform": [
         {"kind": "twist", "degrees": 30, "axis": [0, 0, 1], "length_mm": 9},
         {"kind": "dent", "mm": 1, "brush": {"centre_mm": [0, 0, 5], "radius_mm": 3, "edge": 0.5}},
         {"kind": "bend", "degrees": 5, "towards": [1, 0, 0], "centre_mm": [0, 1, 0]},
         {"kind": "noise", "mm": 0.1, "wavelength_mm": 2, "offset_mm": [1, 0, 0], "seed": 7}]},
      {"operation": "multiply", "mu": 2,
       "where": {"kind": "coordinates", "image": "leaf.png", "from_mm": 0, "to_mm": 1}},
      {"operation": "fur", "fur": {"length_mm": 3, "density": 0.5, "root_colour": [0.1, 0.2, 0.3],
       "reflectance": "even", "strokes": [
         {"brush": "comb", "points_mm": [[0, 0, 1], [0.1, 0.30000000000000004, 1]], "radius_mm": 2},
         {"brush": "length", "points_mm": [[0, 0, 1], [0, 1, 1]], "radius_mm": 1, "amount": 0.2},
         {"brush": "colour", "points_mm": [[0, 0, 1], [0, 1, 1], [1, 1, 1]], "radius_mm": 1,
          "colour": [1, 0.5, 0]}]}}],
    "voxel_mm": 0.4,
    "lights": [{"light": 2, "position_mm": [1, 2, 3], "irradiance": [1, 0.30000000000000004, 0]},
               {"light": 1, "direction": [0, 0, -1]}, {"light": 3, "turn_deg": 40, "radiance": [0, 0, 2]}]})");
}

struct BadRecipe {
  std::string name;
  std::function<void(json&)> spoil;
  std::string sentence;  ///< part of it
  bool schema_sees_it = true;
};

std::vector<BadRecipe> bad_recipes() {
  return {
      {"another format", [](json& r) { r["format"] = "kappamu-scene"; }, "format is"},
      {"another version", [](json& r) { r["version"] = 2; }, "version is not 1"},
      {"no edits", [](json& r) { r.erase("edits"); }, "edits is missing"},
      {"no operation", [](json& r) { r["edits"][0].erase("operation"); }, "edits[0] has no field"},
      {"unknown operation", [](json& r) { r["edits"][0]["operation"] = "divide"; },
       "edits[0].operation is 'divide'"},
      {"unknown field", [](json& r) { r["edits"][0]["k"] = 1; }, "edits[0].k is an unknown field"},
      {"changes nothing", [](json& r) { r["edits"][1].erase("mu"); }, "edits[1] changes nothing"},
      {"factor 0 of kappa", [](json& r) { r["edits"][0]["kappa"] = 0; }, "edits[0].kappa is 0"},
      {"negative mu", [](json& r) { r["edits"][3]["mu"] = -1; }, "edits[3].mu is -1"},
      {"share of two", [](json& r) { r["edits"][3]["share"] = 2; }, "edits[3].share is 2"},
      {"kappa of a copy", [](json& r) { r["edits"][4]["kappa"] = 2; }, "edits[4].kappa is an unk"},
      {"no place", [](json& r) { r["edits"][0].erase("where"); }, "edits[0].where is missing"},
      {"unknown place", [](json& r) { r["edits"][0]["where"]["kind"] = "lasso"; },
       "edits[0].where.kind is 'lasso'"},
      {"a number of a surface", [](json& r) { r["edits"][9]["eta"] = 5; }, "edits[9].eta is 5"},
      {"a surface that stays",
       [](json& r) {
         r["edits"][9] = {{"operation", "surface"}};
       },
       "edits[9] changes nothing"},
      {"a place of a surface",
       [](json& r) {
         r["edits"][9]["where"] = {{"kind", "all"}};
       },
       "edits[9].where is an unknown field"},
      {"an unknown deformation", [](json& r) { r["edits"][10]["deform"][0]["kind"] = "melt"; },
       "edits[10].deform[0].kind is 'melt'"},
      {"no deformation",
       [](json& r) {
         r["edits"][10]["deform"] = json::array();
         r["edits"][10].erase("instead");
       },
       "edits[10].deform changes nothing", false},
      {"coordinates backwards", [](json& r) { r["edits"][11]["where"]["from_mm"] = 3; },
       "to_mm is not beyond from_mm", false},
      {"fur without a change", [](json& r) { r["edits"][12]["fur"] = json::object(); },
       "edits[12].fur changes nothing"},
      {"fur of no model", [](json& r) { r["edits"][12]["fur"]["reflectance"] = "phong"; },
       "edits[12].fur.reflectance is 'phong'"},
      {"fur with a tile", [](json& r) { r["edits"][12]["fur"]["tile_mm"] = 2; },
       "edits[12].fur.tile_mm is an unknown field"},
      {"a comb with a colour", [](json& r) { r["edits"][12]["fur"]["strokes"][0]["colour"] = 0.5; },
       "strokes[0] has a field 'colour' of another brush"},
      {"a length without an amount",
       [](json& r) { r["edits"][12]["fur"]["strokes"][1].erase("amount"); },
       "strokes[1] has no field 'amount'"},
      {"a stroke of one point",
       [](json& r) { r["edits"][12]["fur"]["strokes"][0]["points_mm"].erase(1); },
       "points_mm has 1 entries"},
      {"colour of one", [](json& r) { r["edits"][6]["albedo"] = 1; }, "edits[6].albedo is 1"},
      {"colour and mu", [](json& r) { r["edits"][6]["mu"] = 0.1; }, "keep one of the pairs", false},
      {"numbers for channels",
       [](json& r) {
         r["edits"][5]["mu"] = {1, 2};
       },
       "edits[5].mu has 2 numbers for 3 channels", false},
      {"unknown material", [](json& r) { r["edits"][7]["published"] = "cheese"; },
       "edits[7].published", false},
      {"material and mu", [](json& r) { r["edits"][7]["mu"] = 1; }, "edits[7].published states",
       false},
      {"unknown frame", [](json& r) { r["edits"][6]["where"]["frame"] = "world"; },
       "edits[6].where.frame is 'world'"},
      {"faces of an object", [](json& r) { r["edits"][6]["where"]["faces"] = {"z+"}; },
       "faces belongs to the volume's frame", false},
      {"stretch of an object",
       [](json& r) {
         r["edits"][7]["where"]["stretch"] = {1, 1, 2};
       },
       "stretch belongs to the volume's frame", false},
      {"a view of itself",
       [](json& r) {
         r["edits"][5]["where"]["target_mm"] = {0, 0, 90};
       },
       "target_mm lies at position_mm", false},
      {"a view along up",
       [](json& r) {
         r["edits"][5]["where"]["up"] = {0, 0, 1};
       },
       "looks along its 'up'", false},
      {"lights from 0", [](json& r) { r["lights"][0]["light"] = 0; },
       "lights[0].light is 0; count the scene's lights from 1"},
      {"a light that stays", [](json& r) { r["lights"][1].erase("direction"); },
       "lights[1] changes nothing"},
      {"a dark light", [](json& r) { r["lights"][2]["radiance"][1] = -1; },
       "lights[2].radiance[1] is -1"},
      {"a light's kind", [](json& r) { r["lights"][2]["kind"] = "point"; },
       "lights[2].kind is an unknown field"},
      {"voxels of no size", [](json& r) { r["voxel_mm"] = 0; }, "voxel_mm is 0"},
      {"off by a word", [](json& r) { r["edits"][0]["off"] = "yes"; }, "edits[0].off"},
      {"no radius", [](json& r) { r["edits"][1]["where"]["radius_mm"] = 0; }, "radius_mm is 0"},
      {"no point",
       [](json& r) { r["edits"][1]["where"]["strokes"][0]["points_mm"] = json::array(); },
       "points_mm has 0 entries"},
      {"no length",
       [](json& r) {
         r["edits"][1]["where"]["strokes"][0]["inward"][0] = json{0, 0, 0};
       },
       "inward[0] has no length", false},
      {"too many directions",
       [](json& r) {
         json& inward = r["edits"][1]["where"]["strokes"][0]["inward"];
         inward = json{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
       },
       "inward has 3 directions for 2 points", false},
      {"no face", [](json& r) { r["edits"][4]["where"]["face"] = "top"; }, "where.face is 'top'"},
      {"depth backwards", [](json& r) { r["edits"][2]["where"]["from_mm"] = 3; },
       "to_mm is not beyond from_mm", false},
      {"box backwards",
       [](json& r) {
         r["edits"][3]["where"]["to_mm"] = json{1, 1, -1};
       },
       "to_mm is not beyond from_mm", false}};
}

class RecipeFile : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const json& recipe) const {
    std::ofstream(folder_ / name) << recipe.dump();
    return folder_ / name;
  }
  const OwnFolder folder_;
};

TEST_F(RecipeFile, ReadsEveryKind) {
  const Recipe recipe = read_recipe(write("r.json", full_recipe()));
  ASSERT_EQ(recipe.edits.size(), 13U);
  EXPECT_EQ(recipe.edits[0].channels, std::vector<std::string>{"R"});
  EXPECT_EQ(std::get<BrushSelection>(recipe.edits[1].where).stretch.y(), 2.0);
  EXPECT_EQ(std::get<DepthSelection>(recipe.edits[2].where).faces.size(), 1U);
  EXPECT_EQ(recipe.edits[3].share, 0.5);
  EXPECT_EQ(std::get<TextureSelection>(recipe.edits[4].where).image, folder_ / "leaf.png");
  EXPECT_TRUE(recipe.edits[5].off);
  EXPECT_EQ(recipe.edits[5].mu, (Amount{1, 2, 3}));
  EXPECT_EQ(std::get<ProjectionSelection>(recipe.edits[5].where).from_mm, 0.5);
  EXPECT_EQ(std::get<DepthSelection>(recipe.edits[6].where).frame, Frame::object);
  EXPECT_EQ(recipe.edits[7].published, "skin1");
  EXPECT_EQ(recipe.edits[8].volume, folder_ / "other.vdb");
  EXPECT_EQ(recipe.edits[9].roughness, 0.2);
  EXPECT_EQ(recipe.edits[10].deformations.size(), 4U);
  EXPECT_TRUE(recipe.edits[10].instead);
  EXPECT_EQ(std::get<CoordinatesSelection>(recipe.edits[11].where).image, folder_ / "leaf.png");
  EXPECT_EQ(recipe.voxel_mm, 0.4);
  ASSERT_EQ(recipe.lights.size(), 3U);
  EXPECT_EQ(recipe.lights[0].light, 1U);
  EXPECT_EQ(recipe.lights[0].position_mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(recipe.lights[2].turn_deg, 40.0);
}

/// Lights that a person changes: what is written is read to the last bit and makes the same lights.
TEST_F(RecipeFile, KeepsLights) {
  const std::vector<Light> before{DirectionalLight{}, PointLight{}, EnvironmentLight{}};
  std::vector<Light> after = before, again = before;
  std::get<DirectionalLight>(after[0]).direction = Eigen::Vector3d(1, 2, 3).normalized();
  std::get<PointLight>(after[1]).irradiance = Colour(1.0 / 3.0, 0.0, 2.0);
  std::get<EnvironmentLight>(after[2]).turn_deg = 0.1 + 0.2;
  Recipe recipe;
  recipe.lights = light_changes(before, after);
  ASSERT_EQ(recipe.lights.size(), 3U);
  EXPECT_FALSE(recipe.lights[1].position_mm);
  std::ofstream(folder_ / "r.json") << recipe_json(recipe, folder_);
  change_lights(read_recipe(folder_ / "r.json").lights, "r.json", again);
  EXPECT_TRUE(light_changes(after, again).empty());
  recipe.lights[0].light = 3;
  EXPECT_THAT(sentence_of([&] { change_lights(recipe.lights, "r.json", again); }),
              HasSubstr("r.json: light 4 is not there: the scene has 3"));
  recipe.lights[0].light = 2;
  EXPECT_THAT(sentence_of([&] { change_lights(recipe.lights, "r.json", again); }),
              HasSubstr("light 3 is of a kind that has no 'direction'"));
}

TEST_F(RecipeFile, KeepsFurToTheLastBit) {
  const Recipe recipe = read_recipe(write("r.json", full_recipe()));
  std::ofstream(folder_ / "again.json") << recipe_json(recipe, folder_);
  const FurChange &first = recipe.edits[12].fur,
                  again = read_recipe(folder_ / "again.json").edits.at(12).fur;
  EXPECT_EQ(*again.numbers[0], 3.0);
  EXPECT_FALSE(again.numbers[1]);
  ASSERT_EQ(again.strokes.size(), 3U);
  for (std::size_t i = 0; i < again.strokes.size(); ++i) {
    EXPECT_TRUE(again.strokes[i].same_brush(first.strokes[i]));
    EXPECT_EQ(again.strokes[i].points_mm, first.strokes[i].points_mm);
  }
  EXPECT_EQ(described(again), "length_mm, density, root_colour, even, brush of colour");
}

/// What is written is read to the last bit, a direction that is not of unit length apart.
TEST_F(RecipeFile, KeepsDeformations) {
  Recipe recipe;
  Edit edit;
  edit.operation = Operation::deform;
  Deformation pull;
  pull.amount = 1.0 / 3.0;
  pull.axis = Eigen::Vector3d(1, 2, 3).normalized();
  pull.brush = DeformBrush{{0.1, 0.2, 0.3}, 2.0 / 3.0, 0.7};
  Deformation scale;
  scale.kind = DeformKind::scale;
  scale.amount = 1.1;
  edit.deformations = {pull, scale};
  recipe.edits = {edit};
  std::ofstream(folder_ / "r.json") << recipe_json(recipe, folder_);
  EXPECT_EQ(read_recipe(folder_ / "r.json").edits.at(0).deformations, edit.deformations);
}

TEST_F(RecipeFile, RefusesByFileAndField) {
  for (const BadRecipe& bad : bad_recipes()) {
    json recipe = full_recipe();
    bad.spoil(recipe);
    const std::string sentence = sentence_of([&] { read_recipe(write("r.json", recipe)); });
    EXPECT_THAT(sentence, HasSubstr(bad.sentence)) << bad.name;
    EXPECT_THAT(sentence, HasSubstr("r.json")) << bad.name;
  }
}

TEST_F(RecipeFile, SchemaAgreesWithTheReader) {
  std::map<std::string, std::string> expected;
  const auto add = [&](const std::string& name, const json& recipe, bool valid) {
    const std::string stem = "r" + std::to_string(100 + expected.size());
    write(stem + ".json", recipe);
    expected[stem] = (valid ? "valid " : "invalid ") + name;
  };
  add("all kinds", full_recipe(), true);
  const Recipe read = read_recipe(write("whole.json", full_recipe()));
  std::filesystem::remove(folder_ / "whole.json");
  add("written", json::parse(recipe_json(read, folder_)), true);
  for (const BadRecipe& bad : bad_recipes()) {
    json recipe = full_recipe();
    bad.spoil(recipe);
    add(bad.name, recipe, !bad.schema_sees_it);
  }
  expect_schema_verdicts("edit.schema.json", folder_, expected);
}

}  // namespace
}  // namespace kappamu::render

// Scene files: what is read, what is refused, and docs/scene.schema.json against the reader. What
// lights and models make of scenes is tested in incident_light_test.cpp and with the models.
#include "render/scene/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "io/volume/volume_file.h"
#include "render/material/published_materials.h"
#include "render/scene/frames.h"
#include "render/scene/model_schema.h"
#include "render/scene/new_scene.h"
#include "render/scene/world.h"
#include "tests/own_folder.h"
#include "tests/render/made_scene.h"
#include "tests/schema_verdicts.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class SceneFile : public testing::Test {
 protected:
  SceneFile() {
    write("f.recipe.json", R"({"format": "kappamu-edit", "version": 1, "edits": [
      {"operation": "multiply", "mu": 2, "where": {"kind": "all"}}]})");
  }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  /// The sentence with which a scene is refused; empty where it is read.
  std::string refusal(const std::string& text) const {
    return sentence_of([&] { read_scene(write("scene.json", text)); }, "");
  }
  const OwnFolder folder_;
};

/// Every kind of everything.
json full_scene() {
  return json::parse(R"({
    "format": "kappamu-scene", "version": 1, "_comment": "all kinds",
    "objects": [
      {"name": "a", "mesh": "a.obj", "size_mm": 20, "position_mm": [1, 2, 3], "turn_deg": [0, 90, 0],
       "material": {"volume": "run", "placement": "mirror", "turn_deg": [0, 0, 45], "offset_mm": [1, 0, 0]},
       "surface": {"eta": 1.4, "roughness": 0, "bump": {"image": "b.png", "depth_mm": 0.1, "size_mm": [3, 4]},
                   "gloss": {"image": "g.png", "roughness": [0.5, 0.1]},
                   "reflectance": {"colour": [0.1, 0.2, 0.3], "image": "r.png", "size_mm": [3, 4]}},
       "emission_per_mm": [0.1, 0, 0.2], "polycube": "a.polycube.json"},
      {"name": "b", "shape": "slab", "proportion": 0.2, "size_mm": [20, 20, 4],
       "material": {"published": "whole milk"},
       "deform": [
         {"kind": "pull", "mm": 1, "axis": [0, 2, 0], "brush": {"centre_mm": [0, 0, 2], "radius_mm": 3, "edge": 0.5}},
         {"kind": "dent", "mm": -1, "brush": {"centre_mm": [0, 0, 2], "radius_mm": 3}},
         {"kind": "twist", "degrees": 30, "axis": [1, 0, 0], "centre_mm": [0, 0, 1], "length_mm": 5},
         {"kind": "bend", "degrees": 10, "axis": [0, 1, 0], "towards": [0, 0, 1], "length_mm": 9},
         {"kind": "inflate", "mm": 0.1}, {"kind": "scale", "factor": 0.9},
         {"kind": "noise", "mm": 0.2, "wavelength_mm": 3, "offset_mm": [1, 0, 0], "seed": 7}]},
      {"name": "c", "shape": "sphere", "size_mm": 5,
       "material": {"reduced_scattering_per_mm": [1, 2, 3], "absorption_per_mm": 0.01, "source": "lab"},
       "fur": {"length_mm": 2, "tile_mm": 5, "width": 0.8, "density": 0.5, "curl": 0.1, "lean": 1, "comb": [1, 0, 0],
               "comb_turn_deg": 20, "root_colour": 0.1, "tip_colour": [0.9, 0.8, 0.7], "variation": 0.1,
               "reflectance": "marschner", "shine": 0.5, "fins": false, "bands": 4, "rays": 128, "seed": 3,
               "length_map": "length.png", "density_map": "density.png", "colour_map": "colour.png", "comb_map": "comb.png",
               "strokes": [{"brush": "comb", "points_mm": [[0, 0, 2.5], [0, 1, 2.4]], "radius_mm": 1},
                           {"brush": "density", "points_mm": [[0, 0, 2.5], [0, 1, 2.4]], "radius_mm": 1, "amount": 0},
                           {"brush": "colour", "points_mm": [[0, 0, 2.5], [0, 1, 2.4]], "radius_mm": 1, "colour": 0.5}]}},
      {"name": "d", "shape": "sphere", "size_mm": 5, "position_mm": [30, 0, 0],
       "material": {"volume": "run", "placement": "shell", "up": [0, 0, 1], "scale": 0.5,
                    "texture_size_mm": [20, 30], "core": "mean-values", "seed": 4}},
      {"name": "e", "shape": "sphere", "size_mm": 5, "position_mm": [60, 0, 0],
       "material": {"layers": [
         {"thickness_mm": 0.2, "material": {"mix": [{"published": "marble"}, {"published": "marble", "density": 10}],
          "pattern": {"kind": "marble", "size_mm": 3, "octaves": 4, "turbulence": 0.5, "direction": [0, 1, 0], "seed": 2}}},
         {"thickness_mm": 0.4, "material": {"subsurface": {"colour": [0.9, 0.5, 0.3], "radius_mm": 1, "anisotropy": 0.5}}},
         {"material": {"around": {"attenuation": {"colour": 0.5, "distance_mm": 10}, "reduced_scattering_per_mm": 1},
          "parts": [{"shape": "sphere", "size_mm": 1, "position_mm": [0, 1, 0],
            "material": {"mix": [{"published": "marble"}, {"reduced_scattering_per_mm": 1, "absorption_per_mm": 5}],
             "pattern": {"kind": "veins", "size_mm": 1, "width": 0.2}}}]}}]}},
      {"name": "f", "shape": "cube", "size_mm": 2, "position_mm": [90, 0, 0], "edits": "f.recipe.json",
       "material": {"kappa_mm": 0.3, "mu_per_mm": [0, 0.1, 0.2], "source": "edited"}}],
    "lights": [
      {"kind": "directional", "direction": [0, -2, 0], "irradiance": 1},
      {"kind": "point", "position_mm": [0, 50, 0], "irradiance": [1, 0.5, 0], "at_mm": 50},
      {"kind": "spot", "position_mm": [0, 50, 0], "target_mm": [0, 0, 0], "irradiance": 1, "at_mm": 50,
       "cone_deg": 30, "edge_deg": 5},
      {"kind": "projector", "position_mm": [0, 0, 99], "target_mm": [0, 0, 0], "up": [0, 1, 0],
       "irradiance": 1, "at_mm": 99, "fov_deg": 20, "image": "stripes.png"},
      {"kind": "environment", "image": "sky.exr", "radiance": 0.5, "turn_deg": 10, "visible": false}],
    "camera": {"position_mm": [0, 0, 99], "target_mm": [0, 0, 0], "up": [0, 1, 0], "fov_deg": 30},
    "film": {"width": 64, "height": 48, "samples": 4, "exposure": 2},
    "model": {"name": "montecarlo", "tolerance": 0.01, "photons": 1000, "follow_reentry": true}})");
}

struct Edited {
  std::string name;
  std::function<void(json&)> edit;
  std::string field;  ///< what the sentence names
  bool schema_sees_it = true;
};

std::vector<Edited> bad_scenes() {
  const auto no_number = std::numeric_limits<double>::quiet_NaN();
  return {
      {"film of 1e9", [](json& s) { s["film"]["width"] = 1e9; },
       "film.width is 1000000000.0; write a number from 1"},
      {"half a pixel", [](json& s) { s["film"]["height"] = 0.5; }, "film.height"},
      {"samples", [](json& s) { s["film"]["samples"] = 0; }, "film.samples"},
      {"no camera", [](json& s) { s.erase("camera"); }, "camera is missing"},
      {"no light", [](json& s) { s["lights"] = json::array(); }, "lights has 0 entries"},
      {"NaN is no JSON number", [=](json& s) { s["camera"]["fov_deg"] = no_number; },
       "camera.fov_deg is null"},
      {"unknown field", [](json& s) { s["lights"][1]["colour"] = 1; },
       "lights[1].colour is an unknown field"},
      {"unknown light", [](json& s) { s["lights"][0]["kind"] = "laser"; },
       "lights[0].kind is 'laser'"},
      {"no kind", [](json& s) { s["lights"][0].erase("kind"); }, "lights[0]"},
      {"a light of no direction",
       [](json& s) {
         s["lights"][0]["direction"] = {0, 0, 0};
       },
       "lights[0].direction has no length", false},
      {"negative light",
       [](json& s) {
         s["lights"][1]["irradiance"] = {1, -1, 0};
       },
       "lights[1].irradiance[1] is -1"},
      {"two skies", [](json& s) { s["lights"].push_back(s["lights"][4]); },
       "lights[5] is a second environment", false},
      {"wide edge", [](json& s) { s["lights"][2]["edge_deg"] = 20; }, "lights[2].edge_deg", false},
      {"camera looks at itself",
       [](json& s) { s["camera"]["target_mm"] = s["camera"]["position_mm"]; },
       "camera.target_mm lies at position_mm", false},
      {"camera looks up",
       [](json& s) {
         s["camera"]["up"] = {0, 0, 1};
       },
       "camera looks along its 'up'", false},
      {"two shapes", [](json& s) { s["objects"][0]["shape"] = "cube"; },
       "objects[0] must have either"},
      {"proportion of a mesh", [](json& s) { s["objects"][0]["proportion"] = 0.1; },
       "objects[0].proportion"},
      {"no size", [](json& s) { s["objects"][0]["size_mm"] = 0; }, "objects[0].size_mm is 0"},
      {"one name twice", [](json& s) { s["objects"][1]["name"] = "a"; }, "objects[1].name", false},
      {"two materials", [](json& s) { s["objects"][0]["material"]["published"] = "milk"; },
       "objects[0].material must have exactly one"},
      {"a shell turned", [](json& s) { s["objects"][0]["material"]["placement"] = "shell"; },
       "turn_deg has no meaning for a shell"},
      {"a solid with a core", [](json& s) { s["objects"][3]["material"]["placement"] = "stretch"; },
       "belongs to"},
      {"one material mixed",
       [](json& s) {
         s["objects"][4]["material"] = {{"mix", {1}}};
       },
       "objects[4].material.pattern is missing"},
      {"a last layer that ends",
       [](json& s) { s["objects"][4]["material"]["layers"][2]["thickness_mm"] = 1; },
       "thickness_mm", false},
      {"a layer that does not end",
       [](json& s) { s["objects"][4]["material"]["layers"][0].erase("thickness_mm"); },
       "layers[0].thickness_mm is missing", false},
      {"veins turned",
       [](json& s) {
         s["objects"][4]["material"]["layers"][0]["material"]["pattern"]["kind"] = "veins";
       },
       "turbulence belongs to the kind marble", false},
      {"a colour that does not absorb",
       [](json& s) {
         s["objects"][4]["material"]["layers"][1]["material"]["subsurface"]["colour"] = 1;
       },
       "subsurface.colour is 1", false},
      {"an anisotropic Principled material",
       [](json& s) {
         s["objects"][4]["material"]["layers"][1]["material"]["subsurface"]["convention"] =
             "principled";
       },
       "anisotropy belongs to the convention openpbr", false},
      {"a part without a shape",
       [](json& s) {
         s["objects"][4]["material"]["layers"][2]["material"]["parts"][0].erase("shape");
       },
       "parts[0] must have either 'mesh'"},
      {"a polycube without a name", [](json& s) { s["objects"][0]["polycube"] = ""; },
       "objects[0].polycube is empty"},
      {"bumps of no height", [](json& s) { s["objects"][0]["surface"]["bump"].erase("depth_mm"); },
       "objects[0].surface.bump.depth_mm is missing"},
      {"bumps deeper than the object",
       [](json& s) { s["objects"][0]["surface"]["bump"]["depth_mm"] = -500; },
       "objects[0].surface.bump.depth_mm is more than a quarter of the object's size", false},
      {"gloss of one roughness",
       [](json& s) { s["objects"][0]["surface"]["gloss"]["roughness"] = {0.5}; },
       "objects[0].surface.gloss.roughness"},
      {"a reflectance above 1",
       [](json& s) { s["objects"][0]["surface"]["reflectance"]["colour"] = 1.5; },
       "objects[0].surface.reflectance.colour is 1.5"},
      {"the size of no image",
       [](json& s) { s["objects"][0]["surface"]["reflectance"].erase("image"); },
       "objects[0].surface.reflectance.size_mm is an image's"},
      {"a flat image", [](json& s) { s["objects"][0]["surface"]["bump"]["size_mm"][1] = 0; },
       "objects[0].surface.bump.size_mm[1] is 0"},
      {"dark light of its own", [](json& s) { s["objects"][0]["emission_per_mm"] = -1; },
       "objects[0].emission_per_mm is -1"},
      {"fur without a length", [](json& s) { s["objects"][2]["fur"].erase("length_mm"); },
       "objects[2].fur.length_mm is missing"},
      {"a tile of nothing", [](json& s) { s["objects"][2]["fur"]["tile_mm"] = 0; },
       "objects[2].fur.tile_mm is 0"},
      {"hair of no model", [](json& s) { s["objects"][2]["fur"]["reflectance"] = "phong"; },
       "objects[2].fur.reflectance is 'phong'"},
      {"a stroke over fur of no brush",
       [](json& s) { s["objects"][2]["fur"]["strokes"][0]["brush"] = "scissors"; },
       "objects[2].fur.strokes[0].brush is 'scissors'"},
      {"seven bands", [](json& s) { s["objects"][2]["fur"]["bands"] = 7; },
       "objects[2].fur.bands is 7"},
      {"a deformation of no kind", [](json& s) { s["objects"][1]["deform"][0].erase("kind"); },
       "objects[1].deform[0] has no field 'kind'"},
      {"an unknown deformation", [](json& s) { s["objects"][1]["deform"][4]["kind"] = "melt"; },
       "objects[1].deform[4].kind is 'melt'"},
      {"a pull of nothing in particular",
       [](json& s) { s["objects"][1]["deform"][0].erase("brush"); },
       "objects[1].deform[0].brush is missing"},
      {"a twist in mm", [](json& s) { s["objects"][1]["deform"][2]["mm"] = 3; },
       "objects[1].deform[2].mm is an unknown field"},
      {"a scale of nothing", [](json& s) { s["objects"][1]["deform"][5]["factor"] = 0; },
       "objects[1].deform[5].factor is 0"},
      {"a bend along its axis",
       [](json& s) {
         s["objects"][1]["deform"][3]["towards"] = {0, -2, 0};
       },
       "objects[1].deform[3] bends along its axis", false},
      {"a soft edge wider than the brush",
       [](json& s) { s["objects"][1]["deform"][0]["brush"]["edge"] = 2; },
       "objects[1].deform[0].brush.edge is 2"},
      {"no such material", [](json& s) { s["objects"][1]["material"]["published"] = "gold"; },
       "whole milk", false},
      {"negative absorption",
       [](json& s) { s["objects"][2]["material"]["absorption_per_mm"] = -1; },
       "absorption_per_mm is -1"},
      {"index below one", [](json& s) { s["objects"][0]["surface"]["eta"] = 0.5; },
       "objects[0].surface.eta"},
      {"half a photon", [](json& s) { s["model"]["photons"] = 2.5; },
       "model.photons is wrong: photons must be a whole number"},
      {"no photon", [](json& s) { s["model"]["photons"] = 0; },
       "model.photons is wrong: photons must lie in [2, 2147483649)"},
      {"a parameter of another model", [](json& s) { s["model"]["name"] = "embedded"; },
       "model.photons is an unknown field; allowed here are 'name', 'tolerance', 'max_elements', "
       "'follow_reentry'"},
      {"no such model", [](json& s) { s["model"]["name"] = "magic"; }, "model.name is 'magic'"},
      {"another format", [](json& s) { s["format"] = "kappamu-session"; }, "format"},
      {"another version", [](json& s) { s["version"] = 2; }, "version is not 1"}};
}

TEST_F(SceneFile, ReadsEveryKind) {
  const Scene scene = read_scene(write("scene.json", full_scene().dump()));
  ASSERT_EQ(scene.objects.size(), 6U);
  EXPECT_EQ(std::get<HomogeneousMaterial>(scene.objects[5].material).mu_per_mm[2], 0.2);
  EXPECT_THAT(files_of(scene), testing::Contains(folder_ / "f.recipe.json"));
  const Shell& shell = std::get<VolumeMaterial>(scene.objects[3].material).shell;
  EXPECT_EQ(shell.up, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(shell.texture_size_mm, Eigen::Vector2d(20.0, 30.0));
  EXPECT_EQ(shell.core, Shell::Core::mean_values);
  const auto& layers = std::get<std::shared_ptr<const ComposedMaterial>>(scene.objects[4].material);
  EXPECT_EQ(std::get<ComposedMaterial::Layers>(layers->by).thickness_mm,
            (std::vector<double>{0.2, 0.4}));
  EXPECT_THAT(files_of(scene), testing::Contains(folder_ / "run"));
  EXPECT_EQ(std::get<std::filesystem::path>(scene.objects[0].shape), folder_ / "a.obj");
  EXPECT_EQ(std::get<VolumeMaterial>(scene.objects[0].material).volume, folder_ / "run");
  EXPECT_EQ(scene.objects[0].polycube, folder_ / "a.polycube.json");
  EXPECT_THAT(files_of(scene), testing::Contains(folder_ / "a.polycube.json"));
  EXPECT_EQ(scene.objects[1].proportion, 0.2);
  const auto& lab = std::get<HomogeneousMaterial>(scene.objects[2].material);
  EXPECT_DOUBLE_EQ(lab.kappa_mm[1], 1.0 / (3.0 * 2.01));
  ASSERT_EQ(scene.objects[1].deform.size(), 7U);
  EXPECT_EQ(scene.objects[1].deform[0].axis, Eigen::Vector3d::UnitY());
  EXPECT_EQ(scene.objects[1].deform[0].brush->edge, 0.5);
  EXPECT_EQ(scene.objects[1].deform[2].kind, DeformKind::twist);
  EXPECT_EQ(scene.objects[1].deform[2].length_mm, 5.0);
  EXPECT_EQ(scene.objects[1].deform[6].seed, 7U);
  ASSERT_TRUE(scene.objects[2].fur);
  EXPECT_EQ(scene.objects[2].fur->tile(), 5.0);
  EXPECT_EQ(scene.objects[2].fur->comb, Eigen::Vector3d::UnitX());
  EXPECT_FALSE(scene.objects[2].fur->fins);
  EXPECT_EQ(scene.objects[2].fur->rays, 128);
  ASSERT_TRUE(scene.objects[2].fur->comb_map);
  ASSERT_EQ(scene.objects[2].fur->strokes.size(), 3U);
  EXPECT_EQ(scene.objects[2].fur->strokes[1].of, FurStroke::Of::density);
  EXPECT_EQ(scene.objects[2].fur->comb_map->filename(), "comb.png");
  ASSERT_EQ(scene.lights.size(), 5U);
  EXPECT_EQ(std::get<DirectionalLight>(scene.lights[0]).direction, -Eigen::Vector3d::UnitY());
  EXPECT_EQ(std::get<PointLight>(scene.lights[1]).irradiance[1], 0.5);
  EXPECT_FALSE(std::get<EnvironmentLight>(scene.lights[4]).visible);
  EXPECT_EQ(scene.film.exposure, 2.0);
  EXPECT_EQ(scene.model.parameters, (OptionValues{{"photons", 1000.0}}));
}

/// Recipes of two objects change lights: different fields together, one field to one value alone.
TEST_F(SceneFile, TakesLightsOfAllRecipesAndRefusesThoseThatContradict) {
  const auto write_recipe = [&](const char* name, const json& lights) {
    write(name, json{{"format", "kappamu-edit"},
                     {"version", 1},
                     {"edits", json::array()},
                     {"lights", lights}}
                    .dump());
  };
  json scene = full_scene();
  scene["objects"][2]["edits"] = "c.recipe.json";
  write_recipe("c.recipe.json", {{{"light", 5}, {"turn_deg", 40}}});
  write_recipe("f.recipe.json", {{{"light", 5}, {"turn_deg", 40}, {"radiance", {1, 2, 3}}},
                                 {{"light", 1}, {"irradiance", {3, 0, 0}}}});
  const Scene read = read_scene(write("scene.json", scene.dump()));
  const auto& sky = std::get<EnvironmentLight>(read.lights[4]);
  EXPECT_EQ(sky.turn_deg, 40.0);
  EXPECT_EQ(sky.radiance[2], 3.0);
  EXPECT_EQ(std::get<DirectionalLight>(read.lights[0]).irradiance[0], 3.0);
  for (const bool exchanged : {false, true}) {
    write_recipe(exchanged ? "f.recipe.json" : "c.recipe.json", {{{"light", 5}, {"turn_deg", 41}}});
    write_recipe(exchanged ? "c.recipe.json" : "f.recipe.json", {{{"light", 5}, {"turn_deg", 40}}});
    const std::string sentence = refusal(scene.dump());
    EXPECT_THAT(sentence, HasSubstr("f.recipe.json: light 5: 'turn_deg' is another one in "));
    EXPECT_THAT(sentence, HasSubstr("c.recipe.json; write one value"));
  }
}

TEST_F(SceneFile, RefusesByFileAndField) {
  for (const Edited& bad : bad_scenes()) {
    json scene = full_scene();
    bad.edit(scene);
    const std::string sentence = refusal(scene.dump());
    EXPECT_THAT(sentence, HasSubstr(bad.field)) << bad.name;
    EXPECT_THAT(sentence, HasSubstr("scene.json")) << bad.name;
    EXPECT_EQ(sentence.find('\n'), std::string::npos) << bad.name;
  }
  EXPECT_THAT(refusal("{\"format\": "), HasSubstr("not valid JSON"));
  EXPECT_THAT(refusal("{\"format\": \"kappamu-scene\", \"format\": \"kappamu-scene\"}"),
              HasSubstr("occurs twice"));
  EXPECT_THROW(read_scene(folder_ / "absent.json"), InputError);
}

TEST_F(SceneFile, SchemaAgreesWithTheReader) {
  std::map<std::string, std::string> expected;
  const auto add = [&](const std::string& name, const json& scene, bool valid) {
    write("s" + std::to_string(100 + expected.size()) + ".json", scene.dump());
    expected["s" + std::to_string(100 + expected.size())] = (valid ? "valid " : "invalid ") + name;
  };
  add("all kinds", full_scene(), true);
  add("new", json::parse(new_scene("marble", folder_)), true);
  for (const Edited& bad : bad_scenes()) {
    json scene = full_scene();
    bad.edit(scene);
    add(bad.name, scene, !bad.schema_sees_it);
  }
  std::filesystem::remove(folder_ / "f.recipe.json");  // no scene
  expect_schema_verdicts("scene.schema.json", folder_, expected);
}

TEST_F(SceneFile, ScenesOfTheGalleryAreRead) {
  std::size_t count = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(KAPPAMU_SOURCE_DIR) + "/scenes")) {
    if (entry.path().extension() != ".json") continue;
    EXPECT_NO_THROW(read_scene(entry.path())) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 5U);
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(KAPPAMU_SOURCE_DIR) + "/scenes/frames")) {
    const std::filesystem::path scenes = entry.path().parent_path().parent_path();
    const Frames frames(scenes / entry.path().filename(), entry.path());
    for (int i = 0; i < frames.count(); ++i) EXPECT_NO_THROW(frames.scene(i)) << entry.path();
  }
}

TEST_F(SceneFile, NewSceneOfARunNamesItsVolume) {
  io::VolumeSet set;
  set.channels = {"R", "G", "B"};
  const GridShape shape{8, 6, 4, 0.5};
  for (int c = 0; c < 3; ++c) {
    set.media.push_back({Volume<double>(shape, 0.1 + 0.1 * c), Volume<double>(shape, 0.01)});
  }
  set.eta = 1.45;
  io::write_vdb(folder_ / "run" / "fit" / "volume.vdb", set);
  write("scene.json", new_scene((folder_ / "run").string(), folder_));
  const Scene scene = read_scene(folder_ / "scene.json");
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const WorldObject& block = world.objects()[0];
  EXPECT_NEAR((bounding_box(block.mesh).sizes() - Eigen::Vector3d(4.0, 3.0, 2.0)).norm(), 0, 1e-9);
  EXPECT_EQ(block.boundary.eta, 1.45);
  EXPECT_NEAR(block.media.channels[1]->at({0.1, 0.2, 0.3}).kappa, 0.2, 1e-6);
  EXPECT_THROW(new_scene((folder_ / "nothing").string(), folder_), InputError);
}

TEST_F(SceneFile, NewSceneOfAMeshWearsMarble) {
  std::filesystem::create_directories(folder_ / "meshes");
  write("meshes/my cube.obj",
        "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nv 0 0 9\nv 9 0 9\nv 9 9 9\nv 0 9 9\n"
        "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  const std::string mesh = (folder_ / "meshes" / "my cube.obj").string();
  write("scene.json", new_scene(mesh, folder_));
  std::vector<std::string> warnings;
  const World world(read_scene(folder_ / "scene.json"), warnings);
  EXPECT_EQ(world.objects()[0].name, "my cube");
  EXPECT_NEAR(bounding_box(world.objects()[0].mesh).sizes().maxCoeff(), 20.0, 1e-9);
  EXPECT_THAT(sentence_of([&] { read_scene(mesh); }), HasSubstr("is no scene"));
  EXPECT_THAT(sentence_of([&] { read_scene(folder_); }), HasSubstr("is no scene"));
}

std::string refusal_of(const Scene& scene) {
  std::vector<std::string> warnings;
  return sentence_of([&] { const World world(scene, warnings); }, "");
}

TEST(Scene, RefusesLightsAndCamerasInsideAndObjectsThatOverlap) {
  const Scene good = sphere_scene();
  EXPECT_EQ(refusal_of(good), "");
  Scene scene = good;
  scene.camera.position_mm = {1.0, 2.0, 3.0};
  EXPECT_EQ(refusal_of(scene),
            "the camera is inside object 'ball'; change its position_mm, or give "
            "the mesh a void around it");
  scene = good;
  scene.lights.emplace_back(DirectionalLight{});
  scene.lights.emplace_back(SpotLight{{{0.0, 0.0, 9.0}, Colour::Ones(), 1.0}, {0.0, 0.0, 30.0}});
  EXPECT_EQ(refusal_of(scene),
            "light 2 is inside object 'ball'; change its position_mm, or give "
            "the mesh a void around it");
  scene = good;
  scene.objects.push_back(good.objects[0]);
  scene.objects[1].name = "other";
  scene.objects[1].position_mm = {15.0, 0.0, 0.0};
  EXPECT_THAT(refusal_of(scene), HasSubstr("'ball' and 'other' overlap"));
  scene.objects[1].position_mm = {21.0, 0.0, 0.0};
  EXPECT_EQ(refusal_of(scene), "");
  scene = good;
  scene.objects[0].shape = std::string("dodecahedron");
  EXPECT_THAT(refusal_of(scene), HasSubstr("object 'ball': there is no shape 'dodecahedron'"));
}

TEST_F(SceneFile, RefusesVolumesWithoutTheChannelsAndObjectsBelowAVoxel) {
  io::VolumeSet set;
  set.channels = {"R", "G"};
  const GridShape shape{4, 4, 4, 0.5};
  set.media.assign(2, {Volume<double>(shape, 0.1), Volume<double>(shape, 0.01)});
  io::write_vdb(folder_ / "two.vdb", set);
  set.channels = {"grey"};
  set.media.resize(1);
  io::write_vdb(folder_ / "grey.vdb", set);
  Scene scene = sphere_scene();
  scene.objects[0].material = VolumeMaterial{folder_ / "two.vdb"};
  EXPECT_THAT(refusal_of(scene), HasSubstr("two.vdb: has no channel B"));
  VolumeMaterial grey{folder_ / "grey.vdb"};
  scene.objects[0].material = grey;
  EXPECT_EQ(refusal_of(scene), "");
  grey.placement = VolumeMaterial::Placement::repeat;
  scene.objects[0].material = grey;
  scene.objects[0].size_mm = 0.1;
  EXPECT_THAT(refusal_of(scene), HasSubstr("object 'ball' is smaller than a voxel"));
  scene.objects[0].material = VolumeMaterial{folder_ / "absent.vdb"};
  EXPECT_THAT(refusal_of(scene), HasSubstr("absent.vdb"));
}

TEST(PublishedMaterials, HaveSourcesAndPhysicalCoefficients) {
  for (const std::string& name : published_material_names()) {
    const HomogeneousMaterial material = published_material(name);
    EXPECT_FALSE(material.source.empty()) << name;
    EXPECT_GT(material.kappa_mm.minCoeff(), 0.0) << name;
    EXPECT_GE(material.mu_per_mm.minCoeff(), 0.0) << name;
    EXPECT_LT((3.0 * material.kappa_mm * material.mu_per_mm).maxCoeff(), 1.0) << name;
  }
}

/// Adds the names of all properties below a node of a JSON schema.
void add_properties(const json& node, std::set<std::string>& names) {
  if (node.is_object()) {
    for (const auto& [key, value] : node.items()) {
      if (key == "properties") {
        for (const auto& property : value.items()) names.insert(property.key());
      }
      add_properties(value, names);
    }
  } else if (node.is_array()) {
    for (const json& item : node) add_properties(item, names);
  }
}

TEST(SceneSchema, HasTheModelsOfTheRegistry) {
  std::ifstream file(KAPPAMU_SOURCE_DIR "/docs/scene.schema.json");
  EXPECT_EQ(json::parse(file).at("properties").at("model"), json::parse(model_schema()))
      << "renew it: kappamu render --model-schema";
}

TEST(SceneSchema, EveryFieldIsOnThePage) {
  const auto text = [](const char* name) {
    std::ifstream file(std::filesystem::path(KAPPAMU_SOURCE_DIR) / "docs" / name);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  std::set<std::string> names;
  add_properties(json::parse(text("scene.schema.json")), names);
  const std::string page = text("scene.md");
  EXPECT_GT(names.size(), 40U);
  for (const std::string& name : names) {
    const bool named = page.find("`" + name + "`") != std::string::npos ||
                       page.find("\"" + name + "\"") != std::string::npos;
    EXPECT_TRUE(named) << name;
  }
}

}  // namespace
}  // namespace kappamu::render

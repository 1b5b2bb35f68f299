// Absorption from the materials of glTF and MTL files.
#include "render/material/attenuation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>

#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

using ::testing::HasSubstr;

class AttenuationFile : public ::testing::Test {
 protected:
  FileMaterialChoice written(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    FileMaterialChoice choice;
    choice.file = folder_ / name;
    return choice;
  }
  OwnFolder folder_;
};

const std::string volume_gltf = R"({"asset":{"version":"2.0"},"materials":[{"name":"jade",
  "extensions":{"KHR_materials_transmission":{"transmissionFactor":1},
  "KHR_materials_ior":{"ior":1.61},
  "KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":0.02,
  "attenuationColor":[0.5,0.9,0.25]}}},{"name":"brass"}]})";

/// Beer's law over two distances is the colour twice.
TEST_F(AttenuationFile, GltfColourIsBeersLaw) {
  FileMaterialChoice choice = written("a.gltf", volume_gltf);
  choice.name = "jade";
  const FileMaterial read = read_file_material(choice);
  EXPECT_EQ(read.eta, 1.61);
  const Colour mu = absorption_of(read.attenuation);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(std::exp(-mu[c] * 40.0), std::pow(read.attenuation.colour[c], 2), 1e-12);
  choice.mm_per_unit = 1.0;
  EXPECT_NEAR(absorption_of(read_file_material(choice).attenuation)[0], 1000.0 * mu[0], 1e-9);
}

TEST_F(AttenuationFile, BinaryGltfIsTheSame) {
  std::string binary = "glTF";
  const auto word = [&](std::uint32_t value) {
    for (int k = 0; k < 4; ++k) binary += static_cast<char>(value >> 8 * k & 255U);
  };
  word(2);
  word(static_cast<std::uint32_t>(20 + volume_gltf.size()));
  word(static_cast<std::uint32_t>(volume_gltf.size()));
  word(0x4E4F534A);
  FileMaterialChoice text = written("a.gltf", volume_gltf),
                     glb = written("a.glb", binary + volume_gltf);
  text.name = glb.name = "jade";
  EXPECT_TRUE((absorption_of(read_file_material(glb).attenuation) ==
               absorption_of(read_file_material(text).attenuation))
                  .all());
}

TEST_F(AttenuationFile, ClearMediaAbsorbNothing) {
  const FileMaterial read = read_file_material(
      written("a.gltf", R"({"materials":[{"extensions":{"KHR_materials_transmission":{},
      "KHR_materials_volume":{"attenuationColor":[0.5,0.5,0.5]}}}]})"));
  EXPECT_EQ(absorption_of(read.attenuation).matrix().norm(), 0.0);
  EXPECT_EQ(read.eta, 1.5);
}

TEST_F(AttenuationFile, MtlFilterNeedsItsDistance) {
  FileMaterialChoice choice =
      written("a.mtl", "# glass\nnewmtl bottle\nKd 0 0 0\nTf 0.2 0.8 0.4\nNi 1.4\n");
  EXPECT_THAT(sentence_of([&] { read_file_material(choice); }), HasSubstr("distance_mm"));
  choice.distance_mm = 5.0;
  const FileMaterial read = read_file_material(choice);
  EXPECT_EQ(read.eta, 1.4);
  EXPECT_NEAR(absorption_of(read.attenuation)[0], -std::log(0.2) / 5.0, 1e-12);
}

TEST_F(AttenuationFile, RefusesWhatStatesNoAbsorption) {
  FileMaterialChoice choice = written("a.gltf", volume_gltf);
  EXPECT_THAT(sentence_of([&] { read_file_material(choice); }), HasSubstr("'jade', 'brass'"));
  choice.name = "brass";
  EXPECT_THAT(sentence_of([&] { read_file_material(choice); }), HasSubstr("KHR_materials_volume"));
  choice.name = "gold";
  EXPECT_THAT(sentence_of([&] { read_file_material(choice); }),
              HasSubstr("has no material 'gold'"));
  choice = written("b.gltf", "{\"materials\": 3");
  EXPECT_THAT(sentence_of([&] { read_file_material(choice); }), HasSubstr("not a JSON object"));
  choice = written("c.gltf", R"({"materials":[{"extensions":{"KHR_materials_volume":{}}}]})");
  EXPECT_THAT(sentence_of([&] { read_file_material(choice); }), HasSubstr("transmits no light"));
  choice = written("d.gltf", R"({"materials":[{"extensions":{"KHR_materials_transmission":{},
      "KHR_materials_volume":{"attenuationColor":[0,1,1],"attenuationDistance":1}}}]})");
  EXPECT_THAT(sentence_of([&] { read_file_material(choice); }), HasSubstr("attenuationColor"));
  choice = written("e.mtl", "newmtl a\nKd 1 1 1\n");
  EXPECT_THAT(sentence_of([&] { read_file_material(choice); }), HasSubstr("filter Tf"));
  choice = written("f.txt", "");
  EXPECT_THAT(sentence_of([&] { read_file_material(choice); }), HasSubstr(".gltf, .glb or .mtl"));
}

}  // namespace
}  // namespace kappamu::render

// Fitted materials as those of shaders: what is written gives the volume's coefficients back.
#include "render/scene/material_export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "render/material/subsurface.h"
#include "tests/own_folder.h"

namespace kappamu::render {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

io::VolumeSet volume_of(double inclusion) {
  const GridShape shape{3, 4, 5, 0.5};
  io::VolumeSet set;
  set.channels = {"R", "G", "B"};
  set.eta = 1.42;
  for (const double c : {1.0, 1.5, 4.0}) {
    set.media.push_back({Volume<double>(shape, 0.3 / c), Volume<double>(shape, 0.01 * c)});
    set.media.back().mu(1, 1, 1) *= inclusion;
  }
  return set;
}

Colour input(const std::string& text, const std::string& name) {
  std::smatch found;
  std::regex_search(text, found, std::regex("name=\"" + name + "\"[^>]*value=\"([^\"]*)\""));
  std::string numbers = found[1];
  std::replace(numbers.begin(), numbers.end(), ',', ' ');
  std::istringstream in(numbers);
  Colour colour = Colour::Zero();
  in >> colour[0];
  if (!(in >> colour[1] >> colour[2])) colour.setConstant(colour[0]);
  return colour;
}

void expect_volume(const HomogeneousMaterial& material, const io::VolumeSet& set) {
  for (std::size_t c = 0; c < 3; ++c) {
    const auto k = static_cast<Eigen::Index>(c);
    EXPECT_NEAR(material.kappa_mm[k] / set.media[c].kappa[0], 1.0, 1e-4);
    EXPECT_NEAR(material.mu_per_mm[k] / set.media[c].mu[0], 1.0, 2e-3);
  }
}

TEST(MaterialExport, GivesTheCoefficientsBack) {
  const OwnFolder folder;
  const io::VolumeSet set = volume_of(1.0);
  EXPECT_THAT(export_material(folder, set).warnings, IsEmpty());
  std::stringstream text;
  text << std::ifstream(folder / "material.mtlx").rdbuf();
  Subsurface openpbr;
  openpbr.colour = input(text.str(), "subsurface_color");
  openpbr.radius_mm =
      input(text.str(), "subsurface_radius") * input(text.str(), "subsurface_radius_scale");
  expect_volume(material_of(openpbr), set);
  EXPECT_EQ(input(text.str(), "specular_ior")[0], 1.42);

  const auto json = nlohmann::json::parse(std::ifstream(folder / "principled.json"));
  Subsurface principled;
  principled.convention = Subsurface::Convention::principled;
  for (std::size_t c = 0; c < 3; ++c) {
    principled.colour[static_cast<Eigen::Index>(c)] = json["base_color"][c];
    principled.radius_mm[static_cast<Eigen::Index>(c)] = json["subsurface_radius_mm"][c];
  }
  expect_volume(material_of(principled), set);
}

TEST(MaterialExport, WarnsOfWhatAMeanLosesAndOfNothingElse) {
  const OwnFolder folder;
  EXPECT_THAT(export_material(folder, volume_of(3.0)).warnings,
              ElementsAre(HasSubstr("that varies by 25 %")));
}

}  // namespace
}  // namespace kappamu::render

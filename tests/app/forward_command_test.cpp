// kappamu forward from outside: every face may be lit, every method answers, masks cover. Numbers
// are the business of tests/forward.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/grid.h"
#include "io/npy.h"
#include "tests/app/process.h"

namespace kappamu::app {
namespace {

using testing::HasSubstr;

class ForwardCommand : public TemporaryFolderTest {
 protected:
  std::string at(const std::string& name) const { return (folder() / name).string(); }

  /// `name`.npy of that shape; `value(i)` gives element i.
  template <class Value>
  std::string array(const std::string& name, const std::vector<std::size_t>& shape,
                    const Value& value) const {
    std::size_t count = 1;
    for (const std::size_t extent : shape) count *= extent;
    std::vector<float> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<float>(value(i));
    io::write_npy(at(name + ".npy"), shape, std::span<const float>(values));
    return at(name + ".npy");
  }

  /// 6 × 5 × 4 voxels (x, y, z) of 0.5 mm, one even pattern on `face`.
  std::string block(const std::string& face, const std::string& more) const {
    const FaceShape s = face_shape({6, 5, 4, 0.5}, face_from_string(face));
    array("kappa", {4, 5, 6},
          [](std::size_t i) { return 0.2 + 0.01 * static_cast<double>(i % 7); });
    array("mu", {4, 5, 6}, [](std::size_t) { return 0.01; });
    array("light", {1, static_cast<std::size_t>(s.nv), static_cast<std::size_t>(s.nu)},
          [](std::size_t) { return 1.0; });
    return "forward --kappa " + at("kappa.npy") + " --mu " + at("mu.npy") +
           " --voxel 0.5 --irradiance " + at("light.npy") + " --lit-face " + face + " -o " +
           at("out") + " " + more;
  }

  nlohmann::json summary() const {
    std::ifstream file(folder() / "out" / "summary.json");
    return nlohmann::json::parse(file);
  }
  std::vector<float> map(const std::string& name) const {
    return io::read_npy(folder() / "out" / name).values;
  }
};

TEST_F(ForwardCommand, EveryFaceMayBeLit) {
  for (const Face face : all_faces) {
    const std::string name = to_string(face);
    const ProcessResult result = kappamu(block(name, "--device reference --tolerance 1e-10"));
    ASSERT_EQ(result.exit_code, 0) << name << result.standard_error;
    const nlohmann::json summary = this->summary();
    EXPECT_EQ(summary["lit_face"], name);
    EXPECT_EQ(summary["method"], "multigrid");
    EXPECT_GE(summary["setup_seconds"], 0.0);
    const auto& pattern = summary["patterns"][0];
    const double entering = pattern["entering"];
    double out = pattern["unscattered"].get<double>() + pattern["absorbed"].get<double>();
    for (const auto& [face_name, power] : pattern["exiting"].items()) {
      out += power.get<double>();
      EXPECT_GT(power.get<double>(), 0.0) << face_name;
    }
    EXPECT_NEAR(out / entering, 1.0, 1e-9) << name;  // ten times the tolerance
    const FaceShape s = face_shape({6, 5, 4, 0.5}, face);
    EXPECT_EQ(map("exitance_" + name + ".npy").size(), s.cells());
  }
}

TEST_F(ForwardCommand, EveryGridMethodGivesTheSameLight) {
  ASSERT_EQ(kappamu(block("z-", "--device reference")).exit_code, 0);
  const double expected = summary()["patterns"][0]["exiting"]["z+"];
  for (const char* method : {"multigrid", "reference"}) {
    const ProcessResult result = kappamu(block("z-", std::string("--method ") + method));
    ASSERT_EQ(result.exit_code, 0) << method << result.standard_error;
    EXPECT_EQ(summary()["method"], method);
    EXPECT_NEAR(summary()["patterns"][0]["exiting"]["z+"].get<double>() / expected, 1.0, 1e-4);
  }
}

TEST_F(ForwardCommand, MonteCarloWritesStandardErrors) {
  const ProcessResult result =
      kappamu(block("z-", "--method montecarlo --photons 20000 --anisotropy 0.5"));
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  const auto exitance = map("exitance_z+.npy"), error = map("standard_error_z+.npy");
  ASSERT_EQ(exitance.size(), error.size());
  for (std::size_t i = 0; i < error.size(); ++i) {
    EXPECT_GT(error[i], 0.0F);
    EXPECT_LT(error[i], exitance[i]);
  }
  EXPECT_EQ(summary()["photons"], 20000);
  EXPECT_EQ(summary()["anisotropy"], 0.5);
}

TEST_F(ForwardCommand, AutoTakesDiffusionWhereItHoldsAndWalksWhereItDoesNot) {
  // 2V/S of 2 mean free paths and edges: far from 1 %, within 50 %.
  ASSERT_EQ(kappamu(block("z-", "--method auto --model-tolerance 0.5")).exit_code, 0);
  EXPECT_THAT(summary()["message"].get<std::string>(),
              testing::StartsWith("multigrid, the cheapest"));
  const auto diffusion = map("exitance_z+.npy");
  ASSERT_EQ(kappamu(block("z-", "--device auto --method multigrid")).exit_code, 0);
  EXPECT_EQ(map("exitance_z+.npy"), diffusion);
  ASSERT_EQ(
      kappamu(block("z-", "--method auto --model-tolerance 0.05 --photons 3000000")).exit_code, 0);
  EXPECT_THAT(summary()["message"].get<std::string>(),
              testing::StartsWith("montecarlo, the cheapest"));
  EXPECT_LT(summary()["photons"].get<double>(), 3e6);
  const ProcessResult few =
      kappamu(block("z-", "--method auto --model-tolerance 0.01 --photons 2000"));
  EXPECT_THAT(few.standard_error, HasSubstr("no model is expected to answer within"));
  EXPECT_THAT(kappamu(block("z-", "--method auto --convention wang2008")).standard_error,
              HasSubstr("--convention physical"));
}

TEST_F(ForwardCommand, UnknownMethodIsUsageErrorAndHelpListsThem) {
  EXPECT_EQ(kappamu(block("z-", "--method abacus")).exit_code, 2);
  const std::string help = kappamu("forward --help").standard_output;
  for (const char* method : {"multigrid", "reference", "analytic", "montecarlo", "auto"}) {
    EXPECT_THAT(help, HasSubstr(std::string("\n  ") + method));
  }
}

TEST_F(ForwardCommand, IterationsThatRunOutAreMarked) {
  const ProcessResult result =
      kappamu(block("z-", "--method multigrid --max-iterations 1 --tolerance 1e-12"));
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.standard_error, HasSubstr("not converged"));
  EXPECT_EQ(summary()["converged"], false);
}

TEST_F(ForwardCommand, TakesObliqueLightAndPointsAndWritesTheFluence) {
  const std::string more = "--device reference --tolerance 1e-10 ";
  ASSERT_EQ(kappamu(block("z-", more + "--direction -0.4,0.3,1 --point 1.5,1.2,0.9 "
                                       "--point 1,1,1,4 --fluence npy"))
                .exit_code,
            0);
  const nlohmann::json found = summary();
  EXPECT_EQ(found["patterns"].size(), 3U);
  EXPECT_EQ(found["points"][1]["power"], 4.0);
  EXPECT_LT(found["direction"][0], 0.0);
  for (const auto& pattern : found["patterns"]) {
    double out = pattern["unscattered"].get<double>() + pattern["absorbed"].get<double>();
    for (const auto& [face, power] : pattern["exiting"].items()) out += power.get<double>();
    EXPECT_NEAR(out / pattern["entering"].get<double>(), 1.0, 1e-8);
  }
  const io::NpyArray fluence = io::read_npy(folder() / "out" / "fluence.npy");
  EXPECT_EQ(fluence.shape, (std::vector<std::size_t>{3, 4, 5, 6}));
  // Points alone, for ParaView.
  std::string alone = block("z-", more + "--point 1.5,1.2,0.9 --fluence vti");
  const std::string light = " --irradiance " + at("light.npy");
  alone.erase(alone.find(light), light.size());
  ASSERT_EQ(kappamu(alone).exit_code, 0);
  std::ifstream vti(folder() / "out" / "fluence.vti");
  const std::string text{std::istreambuf_iterator<char>(vti), {}};
  EXPECT_THAT(text, HasSubstr("Name=\"phi_0\""));
  EXPECT_EQ(summary()["patterns"].size(), 1U);
}

TEST_F(ForwardCommand, FluenceMayBeAVdbWithAGridPerPattern) {
  ASSERT_EQ(kappamu(block("z-", "--device reference --point 1.5,1.2,0.9 --fluence vdb")).exit_code,
            0);
  std::ifstream file(folder() / "out" / "fluence.vdb", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(bytes.substr(0, 4), " BDV");
  for (const char* name : {"phi_0", "phi_1"}) EXPECT_THAT(bytes, HasSubstr(name));
}

TEST_F(ForwardCommand, LightThatIsNoneIsRefused) {
  const auto refused = [&](const std::string& more) {
    const ProcessResult result = kappamu(block("z-", "--device reference " + more));
    EXPECT_EQ(result.exit_code, 1) << more;
    return result.standard_error;
  };
  EXPECT_THAT(refused("--point 1,2"), HasSubstr("is not x,y,z in mm"));
  EXPECT_THAT(refused("--point 1,2,1,3,4"), HasSubstr("is not x,y,z in mm"));
  EXPECT_THAT(refused("--point 9,1,1"), HasSubstr("does not lie inside the block"));
  EXPECT_THAT(refused("--direction 0,0,-1"), HasSubstr("does not lead into the lit face"));
  EXPECT_THAT(refused("--direction 0,1,1 --method analytic --sides mirror"),
              HasSubstr("takes neither oblique light nor points"));
}

}  // namespace
}  // namespace kappamu::app

// Costs of models on this machine: kept by device, refused when damaged, absent when not measured.
#include "render/machine_costs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>

#include "forward/registry.h"
#include "render/embree_caster.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

class MachineCosts : public testing::Test {
 protected:
  void SetUp() override {
    if (const char* old = std::getenv("XDG_CACHE_HOME")) old_ = old;
    setenv("XDG_CACHE_HOME", folder_.path().c_str(), 1);
  }
  void TearDown() override {
    if (old_) {
      setenv("XDG_CACHE_HOME", old_->c_str(), 1);
    } else {
      unsetenv("XDG_CACHE_HOME");
    }
  }
  void write(const std::string& text) const {
    std::filesystem::create_directories(folder_ / "kappamu");
    std::ofstream(folder_ / "kappamu" / "model-costs.json") << text;
  }

  const OwnFolder folder_;
  std::optional<std::string> old_;
};

TEST_F(MachineCosts, AreReadForTheirDeviceAlone) {
  EXPECT_EQ(machine_costs_file(), folder_ / "kappamu" / "model-costs.json");
  EXPECT_TRUE(read_machine_costs("auto").empty());
  write(R"({"format": "kappamu-model-costs", "version": 1, "device": "auto",
            "costs": {"embedded": 0.5}})");
  EXPECT_THAT(read_machine_costs("auto"), testing::ElementsAre(testing::Pair("embedded", 0.5)));
  EXPECT_TRUE(read_machine_costs("reference").empty());
}

TEST_F(MachineCosts, RefuseDamagedFilesInASentence) {
  for (
      const char* text :
      {"{", "[]", R"({"format": "kappamu-model-costs", "version": 2})",
       R"({"format": "kappamu-model-costs", "version": 1, "device": "auto", "costs": {"embedded": -1}})",
       R"({"format": "kappamu-model-costs", "version": 1, "device": "auto", "costs": 3})"}) {
    write(text);
    EXPECT_THAT(sentence_of([] { read_machine_costs("auto"); }),
                testing::AllOf(testing::HasSubstr("kappamu doctor"),
                               testing::Not(testing::HasSubstr("json.exception"))))
        << text;
  }
}

// With this machine's own cache: where it is empty every kernel is compiled, half a minute.
TEST(MachineCostsOfTheProbe, AreSecondsOverTheTables) {
  const std::unique_ptr<RayCaster> rays = make_embree_caster(forward::probe_mesh());
  Progress silent;
  const auto times = forward::probe_times(*rays, "auto", 1, silent);
  const forward::MachineCosts costs = forward::machine_costs(times);
  for (const forward::ModelDescription& model : forward::object_models()) {
    if (model.measured == nullptr) continue;
    const std::string& name = model.name;
    ASSERT_TRUE(times.contains(name)) << name << " answers for the probe";
    EXPECT_GT(times.at(name).processor, 0.0) << name;
    EXPECT_NEAR(costs.at(name) * model.measured->probe_seconds, times.at(name).wall,
                1e-9 * times.at(name).wall);
  }
}

}  // namespace
}  // namespace kappamu::render

// `kappamu-studies devices`: toy sizes on the devices there are, and the arithmetic of rows on
// made-up ones. How fast a device is, no test tells.
#include "studies/devices/devices_bench.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "tests/studies/bench_tools.h"

namespace kappamu::studies {
namespace {

using testing::HasSubstr;

class DevicesBench : public RecordTest {};

TEST_F(DevicesBench, EveryTaskRunsOnEveryDeviceWithEqualAnswers) {
  Request request;
  request.settings["mesh"] = {KAPPAMU_SOURCE_DIR "/scenes/meshes/spot.ply"};
  const Json record = quick_record("devices", "devices", request);
  const std::size_t opencl = record.at("devices").size() - 1;
  ASSERT_GE(opencl, 1U);
  std::map<std::string, std::size_t> places;
  for (const Json& row : record.at("rows")) {
    ++places[row.at("task").get<std::string>()];
    EXPECT_FALSE(row.contains("refused")) << row;
    EXPECT_GT(row.at("seconds").get<double>(), 0.0) << row;
    const std::string task = row.at("task");
    if (row.at("kind") != "host" &&
        (task == "embedded" || task == "polygrid" || task == "hierarchy")) {
      EXPECT_GT(row.at("launches").get<int>(), 10) << row;
    }
    EXPECT_GT(row.at("times_processor").get<double>(), 0.0) << row;
  }
  ASSERT_EQ(places.size(), device_tasks().size());
  // Where there is a path without OpenCL: solve, cube, fit, embedded and polygrid.
  for (const auto& [task, count] : places) {
    const bool opencl_alone = task == "hierarchy" || task == "Monte Carlo";
    EXPECT_EQ(count, opencl + (opencl_alone ? 0 : 1)) << task;
  }
  EXPECT_THAT(expect_charts({}, {"devices"}), HasSubstr("| goal of a GPU |"));
}

Place made_up(device::Kind kind) {
  device::DeviceInfo info;
  info.platform = "made up";
  info.name = device::to_string(kind);
  info.kind = kind;
  return {info};
}

DeviceTask task_of(std::function<std::optional<DeviceAnswer>(const Place&)> measure) {
  return {"made up",
          "pieces",
          "≤ 1 s",
          "nothing",
          [](const DeviceAnswer& answer) { return answer.seconds <= 1.0; },
          std::move(measure)};
}

DeviceAnswer answer_of(double seconds, std::vector<double> values) {
  DeviceAnswer answer;
  answer.seconds = seconds;
  answer.count = 100.0;
  answer.values = std::move(values);
  answer.allowed = 1e-3;
  return answer;
}

const std::vector<Place> gpu_cpu_host{
    made_up(device::Kind::gpu), made_up(device::Kind::cpu), {std::nullopt}};

TEST(DeviceRows, RatioIsThatToTheFastestProcessor) {
  const auto rows = rows_of_task(task_of([](const Place& place) {
                                   return answer_of(place.gpu()    ? 0.5
                                                    : place.device ? 4.0
                                                                   : 20.0,
                                                    {1.0, place.gpu() ? 1.0005 : 1.0});
                                 }),
                                 gpu_cpu_host);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].at("times_processor"), 8.0);
  EXPECT_EQ(rows[1].at("times_processor"), 1.0);
  EXPECT_EQ(rows[2].at("times_processor"), 0.2);
  EXPECT_EQ(rows[0].at("goal_met"), true);
  EXPECT_TRUE(rows[1].at("goal_met").is_null()) << "goals are a GPU's";
  EXPECT_NEAR(rows[0].at("difference"), 0.0005 / std::sqrt(2.0), 1e-9);
  EXPECT_TRUE(rows[2].at("difference").is_null()) << "the host's is what others are held against";
}

TEST(DeviceRows, UnequalAnswersHaveNoRatio) {
  const auto rows =
      rows_of_task(task_of([](const Place& place) {
                     return answer_of(place.gpu() ? 0.5 : 4.0, {1.0, place.gpu() ? 1.01 : 1.0});
                   }),
                   gpu_cpu_host);
  EXPECT_TRUE(rows[0].at("times_processor").is_null());
  EXPECT_EQ(rows[0].at("goal_met"), false);
  EXPECT_THAT(rows[0].at("refused").get<std::string>(), HasSubstr("differs from the processor's"));
  EXPECT_EQ(rows[1].at("times_processor"), 1.0);
}

TEST(DeviceRows, NotANumberIsNoEqualAnswer) {
  const auto rows = rows_of_task(task_of([](const Place& place) {
                                   return answer_of(1.0, {1.0, place.gpu() ? std::nan("") : 1.0});
                                 }),
                                 gpu_cpu_host);
  EXPECT_TRUE(rows[0].at("times_processor").is_null());
  EXPECT_TRUE(rows[0].contains("refused"));
}

TEST(DeviceRows, ADeviceThatCannotTakeATaskHasItsSentence) {
  const auto rows = rows_of_task(task_of([](const Place& place) -> std::optional<DeviceAnswer> {
                                   if (place.gpu())
                                     throw InputError("device 'made up' is out of memory");
                                   if (!place.device) return std::nullopt;
                                   return answer_of(1.0, {1.0});
                                 }),
                                 gpu_cpu_host);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_THAT(rows[0].at("refused").get<std::string>(), HasSubstr("out of memory"));
  EXPECT_FALSE(rows[0].contains("seconds"));
  EXPECT_EQ(rows[1].at("times_processor"), 1.0);
}

}  // namespace
}  // namespace kappamu::studies

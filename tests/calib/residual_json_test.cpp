// calibration.json, damaged.
#include "calib/residual_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <tuple>

#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::calib {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// Numbers that no such field holds, each in a record that is otherwise good.
TEST(CalibrationRecord, DamagedNumbersAreNamed) {
  const OwnFolder folder;
  const std::filesystem::path file = folder / "calibration.json";
  CalibrationResult calibration;
  calibration.chart.emplace().neutrals.push_back({18, 0.9, {0.9}});
  const json good = json::parse(residuals_to_json(calibration));
  std::ofstream(file) << good.dump();
  EXPECT_NO_THROW(residuals_from_json(file, calibration));
  const json gray{{"name", "gray"}, {"legible_share", 1.0}, {"points", 1},
                  {"width", 60000}, {"height", 60000},      {"quality", {50}}};
  for (const auto& [field, value, expected] :
       {std::tuple<const char*, json, const char*>{"/camera/uncertainty/columns", 2e113,
                                                   "whole number in range, but is 2e+113"},
        {"/chart/neutrals/0/patch", 1LL << 40, "whole number in range, but is 1099511627776"},
        {"/gray_code/planes", json::array({gray}),
         "quality must have width times height values"}}) {
    json damaged = good;
    damaged[json::json_pointer(field)] = value;
    std::ofstream(file) << damaged.dump();
    const std::string sentence = sentence_of([&] { residuals_from_json(file, calibration); });
    EXPECT_THAT(sentence, HasSubstr("calibration.json: ")) << field;
    EXPECT_THAT(sentence, HasSubstr(expected)) << field;
  }
}

}  // namespace
}  // namespace kappamu::calib

// The one description of a fit's options: what is made of it in this library. Records and
// --continue are in tests/pipeline/fit_options_test.cpp.
#include "inverse/fit/describe_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <type_traits>

#include "inverse/fit/fit_fingerprint.h"
#include "tests/inverse/fit/fit_cases.h"
#include "tests/option_changes.h"
#include "tests/sentence.h"

namespace kappamu::inverse {
namespace {

using ::testing::HasSubstr;

std::string complaint(const FitOptions& options) {
  return sentence_of([&] { validate(options); }, "");
}

/// Sets the number of one name.
struct SetNumber {
  std::string name;
  double number = 0.0;

  template <class Value, class... MoreNames>
  void operator()(const Option& option, Value& value, const MoreNames&...) const {
    if (option.name != name) return;
    if constexpr (std::is_arithmetic_v<Value>) value = static_cast<Value>(number);
    if constexpr (std::is_same_v<Value, std::optional<double>>) value = number;
  }
};

TEST(FitOptionsDescription, DefaultsAreWithinTheirBounds) {
  EXPECT_EQ(complaint({}), "");
}

TEST(FitOptionsDescription, NamesAndPlacesAreUnique) {
  std::set<std::string> names;
  std::set<std::string> flags;
  const FitOptions defaults;
  describe(defaults, [&](const Option& option, const auto&, const auto&...) {
    EXPECT_TRUE(names.insert(option.name).second) << option.name;
    EXPECT_TRUE(*option.flag == 0 || flags.insert(option.flag).second) << option.flag;
    EXPECT_STRNE(option.text, "") << option.name;
  });
}

TEST(FitOptionsDescription, NumbersOutOfBoundsAreRefusedByName) {
  int checked = 0;
  const auto refused = [&](const Option& option, double number) {
    FitOptions options;
    describe(options, SetNumber{option.name, number});
    EXPECT_THAT(complaint(options), HasSubstr(std::string(option.name) + " must ")) << number;
    ++checked;
  };
  const FitOptions defaults;
  describe(defaults, [&](const Option& option, const auto& value, const auto&...) {
    const Bounds& b = option.bounds;
    if (!std::isfinite(b.least)) return;
    refused(option, b.closed ? b.least - 1.0 : b.least);
    if (std::isfinite(b.most)) refused(option, b.most);
    using Value = std::decay_t<decltype(value)>;
    if (std::is_same_v<Value, double>) {
      refused(option, std::numeric_limits<double>::quiet_NaN());
    }
  });
  EXPECT_GT(checked, 54);
}

TEST(FitOptionsDescription, FingerprintChangesWithWhatShapesTheVolumesAlone) {
  cases::Block block;
  block.grid = {4, 4, 4, 0.5};
  const SurfaceMeasurements m =
      cases::measure(block, cases::smooth_medium(block.grid.refined(2)), 2);
  const std::uint64_t usual = fingerprint(m, 0, {}, {});
  std::size_t count = 0;
  for (;; ++count) {
    FitOptions options;
    ChangeOption change{count};
    describe(options, change);
    if (!change.changed) break;
    EXPECT_EQ(fingerprint(m, 0, options, {}) != usual, change.changed->shapes_volumes)
        << change.changed->name;
  }
  EXPECT_GT(count, 40U);
}

TEST(FitOptionsDescription, OptionsThatContradictEachOtherAreRefused) {
  FitOptions options;
  options.path.start_kappa = 0.2;
  EXPECT_THAT(complaint(options), HasSubstr("given together"));
  options = {};
  options.path.last_weight = 2.0 * options.path.first_weight;
  EXPECT_THAT(complaint(options), HasSubstr("at most first_weight"));
}

}  // namespace
}  // namespace kappamu::inverse

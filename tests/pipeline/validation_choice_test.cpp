// --hold-out: what it understands, and what it refuses in one sentence.
#include "pipeline/stages/validation_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sentence.h"

namespace kappamu::pipeline {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Source = ValidationChoice::Source;
using enum ValidationMeasurements;

SurfaceMeasurements measured(int patterns) {
  SurfaceMeasurements m;
  m.grid = {16, 1, 1, 1.0};
  m.patterns = patterns;
  m.irradiance.assign(static_cast<std::size_t>(16 * patterns), 0.0F);
  for (int p = 0; p < patterns; ++p) m.irradiance[static_cast<std::size_t>(16 * p + p)] = 1.0F;
  return m;
}

TEST(ValidationChoice, AutoPrefersValidationPatterns) {
  const ValidationChoice beside = choose_validation("auto", measured(16), present);
  EXPECT_EQ(beside.source, Source::validation);
  EXPECT_THAT(beside.patterns, IsEmpty());
  const ValidationChoice own = choose_validation("auto", measured(16), absent);
  EXPECT_EQ(own.source, Source::fitted_input);
  EXPECT_THAT(own.patterns, ElementsAre(7));
}

TEST(ValidationChoice, TooFewPatternsAreAllFittedAloud) {
  for (const int patterns : {1, 2, 3}) {
    const ValidationChoice validation = choose_validation("auto", measured(patterns), absent);
    EXPECT_EQ(validation.source, Source::none);
    EXPECT_THAT(validation.patterns, IsEmpty());
    ASSERT_TRUE(validation.warning.has_value());
    EXPECT_THAT(*validation.warning, HasSubstr("none is kept out of the fit for validation"));
  }
  EXPECT_FALSE(choose_validation("none", measured(1), absent).warning.has_value());
}

TEST(ValidationChoice, CountsAndListsAreTaken) {
  EXPECT_THAT(choose_validation("2", measured(16), absent).patterns, ElementsAre(7, 9));
  EXPECT_THAT(choose_validation("9,3,9", measured(16), absent).patterns, ElementsAre(3, 9));
  EXPECT_THAT(choose_validation("5,", measured(16), absent).patterns, ElementsAre(5));
  EXPECT_EQ(choose_validation("0", measured(16), absent).source, Source::none);
}

TEST(ValidationChoice, WhatCannotBeIsRefusedByName) {
  const auto sentence = [](const std::string& choice, ValidationMeasurements validated) {
    return sentence_of([&] { choose_validation(choice, measured(4), validated); });
  };
  for (const char* choice : {"some", "-1", "1,x", "", "1;2"}) {
    EXPECT_THAT(sentence(choice, absent), HasSubstr("(hold_out)")) << choice;
  }
  EXPECT_THAT(sentence("4", absent), HasSubstr("keep out fewer"));
  EXPECT_THAT(sentence("4,", absent), HasSubstr("numbered 0 to 3"));
  EXPECT_THAT(sentence("0,1,2,3", absent), HasSubstr("no pattern is left"));
  EXPECT_THAT(sentence("1", present), HasSubstr("validation patterns"));
}

}  // namespace
}  // namespace kappamu::pipeline

#include "pipeline/records/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace kappamu::pipeline {
namespace {

using inverse::FitStatus;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

AppearanceError appearance(double error, double noise) {
  return {error, 1.0, noise, 100};
}

/// Nothing to complain about.
FitEvidence good() {
  FitEvidence evidence;
  evidence.channels = {{"R", FitStatus::converged, 0.97}, {"G", FitStatus::converged, 1.02}};
  evidence.used = 0.98;
  evidence.validation = {appearance(2e-4, 1e-4), appearance(3e-4, 1e-4)};
  evidence.validation_names = {"pattern 5", "pattern 10"};
  evidence.camera_rms_px = 0.1;
  evidence.projector_rms_px = 0.2;
  return evidence;
}

Grade grade_of(const Verdict& verdict, const std::string& criterion) {
  for (const Criterion& c : verdict.criteria) {
    if (c.name == criterion) return c.grade;
  }
  ADD_FAILURE() << "no criterion " << criterion;
  return Grade::unknown;
}

TEST(Verdict, GoodFitIsTrusted) {
  const Verdict verdict = make_verdict(good());
  EXPECT_EQ(verdict.grade, Grade::green) << verdict.sentence;
  EXPECT_EQ(verdict.sentence, "This fit can be trusted.");
  EXPECT_EQ(verdict.exit_code(), 0);
}

/// A descent that settled far above the noise is no success: it printed "converged", exit code 0.
TEST(Verdict, SettledFarAboveTheNoiseIsRedWithItsReasonFirst) {
  FitEvidence evidence = good();
  evidence.channels[0] = {"R", FitStatus::above_noise, 850.0};
  const Verdict verdict = make_verdict(evidence);
  EXPECT_EQ(verdict.grade, Grade::red);
  EXPECT_FALSE(verdict.explained);
  EXPECT_EQ(verdict.exit_code(), 3);
  EXPECT_THAT(verdict.sentence, StartsWith("Do not trust this fit: χ² per value is R 850, G 1.02"));
  EXPECT_THAT(verdict.sentence, HasSubstr("the data of R are not explained"));
  EXPECT_EQ(overall_status({FitStatus::above_noise, FitStatus::converged}), "above_noise");
}

TEST(Verdict, SystematicErrorThatWasFoundIsAReservation) {
  FitEvidence evidence = good();
  evidence.channels[0] = {"R", FitStatus::converged, 18.0, 0.0076};
  const Verdict verdict = make_verdict(evidence);
  EXPECT_EQ(verdict.grade, Grade::amber);
  EXPECT_TRUE(verdict.explained);
  EXPECT_EQ(verdict.exit_code(), 0);
  EXPECT_THAT(verdict.sentence, HasSubstr("beside a systematic error of the data (R 0.76 %)"));
}

/// χ² per value saw nothing of it: "explained", exit code 0, at half of the light measured.
TEST(Verdict, LightPredictedFurtherOffThanItsStatedErrorIsNotExplained) {
  FitEvidence evidence = good();
  evidence.channels[0].shared = {0.9, {true, 0.0, 1.0, 0.5}, -0.004, 0.005};
  const Verdict within = make_verdict(evidence);
  EXPECT_TRUE(within.explained);
  EXPECT_EQ(within.grade, Grade::green);
  EXPECT_THAT(within.criteria.front().reason, HasSubstr("R is predicted 0.4 % too dark"));
  evidence.channels[0].shared.mean = -0.065;
  const Verdict verdict = make_verdict(evidence);
  EXPECT_FALSE(verdict.explained);
  EXPECT_EQ(verdict.exit_code(), 3);
  EXPECT_EQ(verdict.grade, Grade::red);
  EXPECT_THAT(verdict.sentence, HasSubstr("13 times the stated error"));
  evidence.channels[0].systematic = 0.01;
  EXPECT_FALSE(make_verdict(evidence).explained);
}

TEST(Verdict, AnOctaveFurtherOffThanChanceIsNotExplained) {
  FitEvidence evidence = good();
  evidence.channels[0].shared = {3.0, {false, 40.0, 27.0, 27.0 * 6.25}, 0.0, 0.005};
  const Verdict verdict = make_verdict(evidence);
  EXPECT_FALSE(verdict.explained);
  EXPECT_EQ(verdict.grade, Grade::amber);
  EXPECT_THAT(verdict.sentence,
              HasSubstr("waves of 20 to 40 voxels of single patterns are 2.5 times"));
}

TEST(Verdict, AboveTheNoiseWithinBoundsIsStillExplained) {
  FitEvidence evidence = good();
  evidence.channels[0] = {"R", FitStatus::above_noise, 1.3};
  EXPECT_EQ(make_verdict(evidence).exit_code(), 0);
  evidence.channels[0].chi2_per_value = 1.6;
  const Verdict verdict = make_verdict(evidence);
  EXPECT_EQ(verdict.grade, Grade::amber);
  EXPECT_EQ(verdict.exit_code(), 3);
}

TEST(Verdict, NotANumberIsNotExplained) {
  FitEvidence evidence = good();
  evidence.channels[0].chi2_per_value = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(make_verdict(evidence).grade, Grade::red);
  EXPECT_EQ(make_verdict(evidence).exit_code(), 3);
}

TEST(Verdict, OutOfStepsIsAmberAndNamesTheChannel) {
  FitEvidence evidence = good();
  evidence.channels[1].status = FitStatus::ran_out;
  const Verdict verdict = make_verdict(evidence);
  EXPECT_EQ(verdict.grade, Grade::amber);
  EXPECT_EQ(verdict.exit_code(), 3);
  EXPECT_THAT(verdict.sentence, HasSubstr("G ran out of steps"));
  EXPECT_EQ(overall_status({FitStatus::ran_out, FitStatus::above_noise}), "ran_out");
}

TEST(Verdict, WrongPredictionOfUnseenPatternsIsRed) {
  FitEvidence evidence = good();
  evidence.validation = {appearance(0.1, 1e-4)};
  const Verdict verdict = make_verdict(evidence);
  EXPECT_EQ(verdict.grade, Grade::red);
  EXPECT_EQ(verdict.exit_code(), 3);
  EXPECT_THAT(verdict.sentence, StartsWith("Do not trust this fit: E = 0.1 over 1 pattern"));
}

TEST(Verdict, DimPatternThatIsWrongDoesNotHideBehindBrightOnes) {
  FitEvidence evidence = good();
  evidence.validation[1] = {1e-4, 1e-3, 1e-8, 100};
  const Verdict verdict = make_verdict(evidence);
  EXPECT_EQ(verdict.grade, Grade::amber);
  EXPECT_THAT(verdict.sentence, HasSubstr("in pattern 10"));
}

TEST(Verdict, ErrorWithinTheNoiseIsGreen) {
  FitEvidence evidence = good();
  evidence.validation = {appearance(0.1, 0.09)};
  EXPECT_EQ(make_verdict(evidence).grade, Grade::green);
}

TEST(Verdict, WhatIsMissingIsNotGraded) {
  FitEvidence evidence = good();
  evidence.validation.clear();
  evidence.camera_rms_px.reset();
  const Verdict verdict = make_verdict(evidence);
  EXPECT_EQ(grade_of(verdict, "Validation"), Grade::unknown);
  EXPECT_EQ(grade_of(verdict, "Calibration"), Grade::unknown);
  EXPECT_EQ(verdict.grade, Grade::green);
}

TEST(Verdict, EachReservationIsNamed) {
  FitEvidence evidence = good();
  evidence.camera_rms_px = 0.6;
  evidence.used = 0.7;
  evidence.warnings = 2;
  const Verdict verdict = make_verdict(evidence);
  EXPECT_EQ(verdict.grade, Grade::amber);
  EXPECT_EQ(verdict.exit_code(), 0);
  EXPECT_EQ(grade_of(verdict, "Calibration"), Grade::amber);
  EXPECT_THAT(verdict.sentence, StartsWith("Usable with reservations: "));
  for (const char* reason : {"0.6 px (camera)", "70 % of the surface values", "2 warnings"})
    EXPECT_THAT(verdict.sentence, HasSubstr(reason));
  EXPECT_THAT(verdict.sentence, Not(HasSubstr("χ²"))) << "what is right is no reservation";
  evidence.front_lit = true;
  EXPECT_EQ(grade_of(make_verdict(evidence), "Coverage"), Grade::green);
}

TEST(Verdict, IsReadAsWritten) {
  FitEvidence evidence = good();
  evidence.validation.clear();
  evidence.warnings = 1;
  const Verdict written = make_verdict(evidence);
  const Verdict read = verdict_from_json(nlohmann::json::parse(verdict_json(written).dump()));
  EXPECT_EQ(verdict_json(read), verdict_json(written));
  EXPECT_EQ(read.exit_code(), written.exit_code());
}

}  // namespace
}  // namespace kappamu::pipeline

// A session folder written from docs/formats.md by a Python script that knows nothing of kappamu
// runs, and gives the block that the script made its pictures of.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "io/npy.h"
#include "tests/app/process.h"

namespace kappamu::app {
namespace {

constexpr const char* no_numpy = "/usr/bin/python3 has no numpy (Debian package python3-numpy)";

double mean(const std::vector<float>& values) {
  double sum = 0.0;
  for (const float value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// What becomes of a session written with `arguments`.
class HandwrittenSession : public TemporaryFolderTest {
 protected:
  bool has_numpy() const {
    return run_process("/usr/bin/python3 -c 'import numpy'").exit_code == 0;
  }

  void run(const std::string& arguments) {
    const std::string session = (folder() / "session").string();
    const ProcessResult written =
        run_process("/usr/bin/python3 " KAPPAMU_SOURCE_DIR "/tests/app/handwritten_session.py " +
                    session + arguments);
    ASSERT_EQ(written.exit_code, 0) << written.standard_error;
    std::istringstream(written.standard_output) >> kappa_mm_ >> mu_per_mm_;
    result_ = kappamu("run " + session + " -o " + (folder() / "run").string() +
                      " --device reference --json");
    summary_ = nlohmann::json::parse(last_line(result_.standard_output));
    const std::filesystem::path fit = folder() / "run" / "fit";
    std::ifstream(fit / "fit.json") >> fit_;
    kappa_ = mean(io::read_npy(fit / "kappa_Y.npy").values);
    mu_ = mean(io::read_npy(fit / "mu_Y.npy").values);
    std::printf("kappa %.4f mm (made of %.4f), mu %.5f 1/mm (made of %.5f), holdout E %.1e\n%s\n",
                kappa_, kappa_mm_, mu_, mu_per_mm_, summary_["validation_E"].get<double>(),
                model()["reason"].get<std::string>().c_str());
  }
  nlohmann::json model() const { return fit_["channels"][0]["model"]; }

  double kappa_mm_ = 0.0, mu_per_mm_ = 0.0;  ///< that the script made its pictures of
  double kappa_ = 0.0, mu_ = 0.0;            ///< found
  ProcessResult result_;
  nlohmann::json summary_, fit_;
};

TEST_F(HandwrittenSession, RunsAndGivesItsBlock) {
  if (!has_numpy()) GTEST_SKIP() << no_numpy;
  run("");
  EXPECT_LT(summary_["camera_rms_px"].get<double>(), 0.3);
  EXPECT_LT(summary_["projector_rms_px"].get<double>(), 0.5);
  EXPECT_LT(summary_["validation_E"].get<double>(), 1e-3);
  EXPECT_NEAR(kappa_, kappa_mm_, 0.1 * kappa_mm_);
  // A hundredth of the light is absorbed: one per cent of its scale is a good part of mu.
  EXPECT_NEAR(mu_, mu_per_mm_, 0.3 * mu_per_mm_);
}

TEST_F(HandwrittenSession, InterpolatedPhotographsMakeNoLayers) {
  if (!has_numpy()) GTEST_SKIP() << no_numpy;
  run(" bars");
  EXPECT_EQ(model()["name"], "homogeneous") << model()["reason"];
  EXPECT_GT(model()["systematic_error"].get<double>(), 0.0005);
  EXPECT_LT(model()["systematic_error"].get<double>(), 0.01);
  EXPECT_EQ(result_.exit_code, 0) << summary_["verdict"];
  EXPECT_EQ(summary_["verdict"]["grade"], "amber");
  const double deviation =
      io::read_npy(folder() / "run" / "fit" / "std_kappa_Y.npy").values.front();
  EXPECT_LT(std::abs(kappa_ - kappa_mm_), 2.0 * deviation);
  EXPECT_NEAR(kappa_, kappa_mm_, 0.02 * kappa_mm_);
  EXPECT_NEAR(mu_, mu_per_mm_, 0.3 * mu_per_mm_);
}

}  // namespace
}  // namespace kappamu::app

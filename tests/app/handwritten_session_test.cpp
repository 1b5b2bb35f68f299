// A session folder written from docs/formats.md by a Python script that knows nothing of kappamu
// runs, and gives the block that the script made its pictures of.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "io/npy.h"
#include "tests/app/process.h"

namespace kappamu::app {
namespace {

using HandwrittenSession = TemporaryFolderTest;

double mean(const std::vector<float>& values) {
  double sum = 0.0;
  for (const float value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

TEST_F(HandwrittenSession, RunsAndGivesItsBlock) {
  if (run_process("/usr/bin/python3 -c 'import numpy'").exit_code != 0) {
    GTEST_SKIP() << "/usr/bin/python3 has no numpy (Debian package python3-numpy)";
  }
  const std::string session = (folder() / "session").string();
  const ProcessResult written = run_process(
      "/usr/bin/python3 " KAPPAMU_SOURCE_DIR "/tests/app/handwritten_session.py " + session);
  ASSERT_EQ(written.exit_code, 0) << written.standard_error;
  double kappa_mm = 0.0;
  double mu_per_mm = 0.0;
  std::istringstream(written.standard_output) >> kappa_mm >> mu_per_mm;

  const std::filesystem::path run = folder() / "run";
  const ProcessResult result =
      kappamu("run " + session + " -o " + run.string() + " --device reference --json");
  // Its photographs are interpolated and off by more than their noise: not explained, and marked
  // so.
  ASSERT_EQ(result.exit_code, 3) << result.standard_error;
  const auto summary = nlohmann::json::parse(last_line(result.standard_output));
  EXPECT_EQ(summary["status"], "above_noise");
  EXPECT_FALSE(summary["verdict"]["explained"]);
  EXPECT_LT(summary["camera_rms_px"].get<double>(), 0.3);
  EXPECT_LT(summary["projector_rms_px"].get<double>(), 0.5);
  EXPECT_LT(summary["validation_E"].get<double>(), 1e-3);
  const double kappa = mean(io::read_npy(run / "fit" / "kappa_Y.npy").values);
  const double mu = mean(io::read_npy(run / "fit" / "mu_Y.npy").values);
  std::printf("kappa %.4f mm (made of %.4f), mu %.5f 1/mm (made of %.5f), holdout E %.1e\n", kappa,
              kappa_mm, mu, mu_per_mm, summary["validation_E"].get<double>());
  EXPECT_NEAR(kappa, kappa_mm, 0.1 * kappa_mm);
  // A hundredth of the light is absorbed: one per cent of its scale is a good part of mu.
  EXPECT_NEAR(mu, mu_per_mm, 0.3 * mu_per_mm);
}

}  // namespace
}  // namespace kappamu::app

// `kappamu run` end to end on a tiny simulated session: what it leaves, that it resumes after
// SIGKILL to the same bits, and that a finished run is left alone. How good the volumes are is
// tested in tests/inverse and scored by scripts/demo.sh.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "core/processor_time.h"
#include "io/read_file.h"
#include "tests/app/process.h"
#include "tests/app/tiny_session.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

// Loose enough for a test's patience; the same in every run that is compared.
const std::string quick_fit = " --device reference";

class RunTest : public TemporaryFolderTest {
 protected:
  std::string arguments(const std::string& run) const {
    return "run " + tiny_session().string() + " -o " + (folder() / run).string() + quick_fit;
  }
  /// Every file of a run that holds results, by relative name.
  std::map<std::string, std::string> results(const std::string& run) const {
    std::map<std::string, std::string> files;
    for (const char* part : {"fit", "measurements", "measurements_validate"})
      for (const auto& entry : fs::recursive_directory_iterator(folder() / run / part))
        if (entry.path().extension() == ".npy")
          files[fs::relative(entry.path(), folder() / run)] = io::read_text(entry.path());
    return files;
  }
  /// A JSON file of a run but for times, memory and the run's own place.
  json account(const std::string& run, const char* file) const {
    json document = json::parse(io::read_text(folder() / run / file));
    erase(document, {"seconds", "memory_peak_bytes", "input", "checksum"});
    // Files that hold those have other hashes.
    if (document.contains("stages"))
      for (json& stage : document["stages"])
        for (json& entry : stage["files"])
          if (const fs::path path = entry["path"].get<std::string>();
              path.extension() == ".json" || path.extension() == ".html")
            erase(entry, {"bytes", "hash"});
    return document;
  }
  /// The list of warnings of a run's report.
  std::string told(const std::string& run) const {
    const std::string page = io::read_text(folder() / run / "report.html");
    const std::size_t begin = page.find("<ul class=\"warnings\"");
    return begin == std::string::npos ? "" : page.substr(begin, page.find("</ul>", begin) - begin);
  }

 private:
  static void erase(json& document, const std::vector<std::string>& names) {
    if (document.is_object())
      for (const std::string& name : names) document.erase(name);
    if (document.is_structured())
      for (json& part : document) erase(part, names);
  }
};

TEST_F(RunTest, LeavesEverythingAndASecondRunDoesNothing) {
  const fs::path& run = tiny_run();
  const ProcessResult first = tiny_run_result();
  const json summary = json::parse(last_line(first.standard_output));
  for (const char* field :
       {"sample", "grid", "camera_rms_px", "projector_rms_px", "status", "verdict", "validation_E",
        "kappa_mu_volume", "report", "seconds", "seconds_total", "device", "warnings"})
    EXPECT_TRUE(summary.contains(field)) << field;
  EXPECT_LT(summary["camera_rms_px"].get<double>(), 0.5);
  EXPECT_LT(summary["projector_rms_px"].get<double>(), 0.5);
  EXPECT_GT(summary["validation_E"].get<double>(), 0.0);
  EXPECT_LT(summary["validation_E"].get<double>(), 0.05);
  EXPECT_TRUE(fs::exists(summary["kappa_mu_volume"].get<std::string>()));
  EXPECT_TRUE(fs::exists(summary["report"].get<std::string>()));
  for (const char* stage : {"calibrate", "merge", "fit", "export", "report"})
    EXPECT_TRUE(summary["seconds"].contains(stage)) << stage;
  for (const char* part :
       {"run.json", "calibration/calibration.json", "calibration/camera.yml",
        "measurements/measurements.json", "measurements_validate/measurements.json",
        "fit/kappa_R.npy", "fit/mu_B.npy", "fit/prediction.npy", "fit/volume.vdb",
        "export/volume.vti", "report.html"})
    EXPECT_TRUE(fs::exists(run / part)) << part;
  const json fit = json::parse(io::read_text(run / "fit" / "fit.json"));
  EXPECT_EQ(fit["warnings"].dump().find("square_mm"), std::string::npos)
      << "the board's squares are right: " << fit["warnings"];

  const auto before = fs::last_write_time(run / "report.html");
  const Stopwatch watch;
  const ProcessResult second = kappamu(tiny_run_arguments() + " -o " + run.string());
  EXPECT_LT(watch.seconds(), 3.0) << "a finished run must only be looked at";
  EXPECT_EQ(second.exit_code, first.exit_code);
  EXPECT_EQ(fs::last_write_time(run / "report.html"), before);
  EXPECT_EQ(last_line(second.standard_output), last_line(first.standard_output));
}

TEST_F(RunTest, KilledAtAnyMomentItEndsInTheSameBitsAndTellsTheSame) {
  copied_run(folder() / "whole");
  const int code = kappamu(arguments("whole")).exit_code;
  ASSERT_TRUE(code == 0 || code == 3);
  double whole_ms = 0.0;
  const json stages = json::parse(io::read_text(folder() / "whole" / "run.json"))["stages"];
  for (const json& stage : stages) whole_ms += 1e3 * stage["seconds"].get<double>();

  // Killed over and over, each time a little later: in calibration, merge, fit and after.
  int kills = 0;
  for (const double share : {0.05, 0.1, 0.15, 0.2, 0.25})
    kills += kappamu_killed_after(arguments("killed"), static_cast<int>(share * whole_ms));
  EXPECT_GE(kills, 3) << "the kills must hit";
  EXPECT_EQ(kappamu(arguments("killed")).exit_code, code);

  const auto expected = results("whole");
  const auto found = results("killed");
  ASSERT_GE(expected.size(), 12U);
  ASSERT_EQ(found.size(), expected.size());
  for (const auto& [name, bytes] : expected) {
    ASSERT_TRUE(found.contains(name)) << name;
    EXPECT_TRUE(found.at(name) == bytes) << name << " differs";
  }
  EXPECT_EQ(account("killed", "fit/fit.json"), account("whole", "fit/fit.json"));
  EXPECT_EQ(account("killed", "run.json"), account("whole", "run.json"));
  EXPECT_EQ(told("killed"), told("whole"));
}

TEST_F(RunTest, MeasurementsOfAnyoneAreFittedAndReported) {
  fs::create_directories(folder() / "a");
  fs::copy(tiny_run() / "measurements", folder() / "a" / "measurements");
  const ProcessResult result = kappamu("run " + (folder() / "a" / "measurements").string() +
                                       " -o " + (folder() / "b").string() + quick_fit + " --json");
  ASSERT_TRUE(result.exit_code == 0 || result.exit_code == 3) << result.standard_error;
  const json summary = json::parse(last_line(result.standard_output));
  EXPECT_TRUE(summary["camera_rms_px"].is_null());
  EXPECT_TRUE(fs::exists(folder() / "b" / "fit" / "kappa_R.npy"));
  const std::string page = io::read_text(folder() / "b" / "report.html");
  EXPECT_THAT(page, HasSubstr("This run has no calibration"));
  // Nobody measured patterns to validate the fit by, so it keeps one of its own out.
  const json fit = json::parse(io::read_text(folder() / "b" / "fit" / "fit.json"));
  EXPECT_EQ(fit["validation"]["source"], "input");
  EXPECT_EQ(fit["validation"]["patterns"].size(), 1U);
  EXPECT_EQ(fit["options"]["hold_out"], "auto");
  for (const json& channel : fit["channels"]) {
    EXPECT_GT(channel["validation_E"].get<double>(), 0.0);
    EXPECT_LT(channel["validation_E"].get<double>(), 0.05);
    EXPECT_GT(channel["validation_chi2_per_value"].get<double>(), 0.0);
  }
  EXPECT_THAT(page, HasSubstr("Validation patterns"));
  EXPECT_GT(summary["validation_E"].get<double>(), 0.0);
  EXPECT_EQ(json::parse(io::read_text(folder() / "b" / "run.json"))["validation_E"].size(), 3U);

  // The finished fit goes on with other options, and refuses what cannot be changed.
  const std::string onward = "fit --continue " + (folder() / "b").string() + quick_fit;
  const ProcessResult next = kappamu(onward + " --channel G --loss huber --lambda 100");
  ASSERT_TRUE(next.exit_code == 0 || next.exit_code == 3) << next.standard_error;
  const json continued = json::parse(io::read_text(folder() / "b" / "fit_continued" / "fit.json"));
  EXPECT_EQ(continued["options"]["loss"], "huber");
  EXPECT_EQ(continued["options"]["weight"], 100.0);
  EXPECT_EQ(continued["validation"]["patterns"], fit["validation"]["patterns"]);
  EXPECT_EQ(continued["channels"][0]["history"][0]["level"], 0) << "on the full grid at once";
  expect_one_sentence(kappamu(onward + " --convention wang2008"), "fit anew");
  expect_one_sentence(kappamu(onward + " --hold-out 0,1"), "cannot be held out now");
  expect_one_sentence(kappamu("fit --continue " + (folder() / "a").string()), "no fit.json");
  fs::rename(folder() / "a", folder() / "moved");
  expect_one_sentence(kappamu(onward), "no longer there; name its present place as INPUT");
}

TEST_F(RunTest, AnotherSessionIsRefused) {
  const std::string run = " -o " + copied_run(folder() / "run").string();
  // The same session under another name in session.json.
  const fs::path other = fs::path(KAPPAMU_TEST_FOLDER) / ("other-" + folder().filename().string());
  linked_session(other);
  json document = json::parse(io::read_text(other / "session.json"));
  document["sample"]["name"] = "another";
  fs::remove(other / "session.json");
  std::ofstream(other / "session.json") << document.dump();
  expect_one_sentence(kappamu("calibrate " + other.string() + run), "another input");
  fs::remove_all(other);
}

}  // namespace
}  // namespace kappamu::app

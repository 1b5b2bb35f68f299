// The command as a shell sees it: manual pages, usage errors, and one sentence for failures that
// need no session. Bad sessions are in bad_session_test.cpp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/command_list.h"
#include "app/program.h"
#include "core/error.h"
#include "io/npy.h"
#include "io/volume/volume_file.h"
#include "tests/app/process.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

class EverySubcommand : public testing::TestWithParam<std::string> {};

TEST_P(EverySubcommand, HelpIsAManualPage) {
  const ProcessResult result = kappamu(GetParam() + " --help");
  EXPECT_EQ(result.exit_code, 0) << result.standard_error;
  EXPECT_THAT(result.standard_output, HasSubstr(GetParam()));
  // More than a list of options: says what it does, and fits a terminal.
  EXPECT_GT(result.standard_output.size(), 400U) << result.standard_output;
  EXPECT_EQ(result.standard_error, "");
}

TEST_P(EverySubcommand, UnknownOptionIsUsageError) {
  const ProcessResult result = kappamu(GetParam() + " --no-such-option");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.standard_error, "");
}

INSTANTIATE_TEST_SUITE_P(Cli, EverySubcommand,
                         testing::Values("simulate", "plan", "import", "run", "calibrate", "merge",
                                         "chart", "fit", "map", "export", "report", "forward",
                                         "score", "doctor"),
                         [](const auto& parameter) { return parameter.param; });

/// What the parse of one command throws; nothing is run.
std::string parse_error(const std::string& command, const std::string& argument) {
  CLI::App app;
  Globals globals;
  add_globals(app, globals);
  add_commands(app, globals);
  refuse_non_finite(app);
  // Before the command's own callback, which holds what its options write to.
  for (CLI::App* each : app.get_subcommands({})) {
    each->parse_complete_callback([] { throw CLI::Success(); });
  }
  std::vector<std::string> arguments{argument, command};  // backwards, as CLI11 wants them
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    return error.get_name();
  } catch (const InputError&) {  // of options that name files
    return "InputError";
  }
  return "";
}

// Whatever an option takes as a number, it is finite: whether it does shows in that it refuses a
// word.
TEST(Cli, NumbersOfEveryOptionAreFinite) {
  CLI::App app;
  Globals globals;
  add_commands(app, globals);
  int tried = 0;
  for (const CLI::App* command : app.get_subcommands({})) {
    for (const CLI::Option* option : command->get_options()) {
      if (option->get_lnames().empty() || option->get_items_expected_max() == 0) continue;
      const std::string flag = "--" + option->get_lnames().front() + "=";
      const std::string parts = option->get_items_expected_min() == 3 ? ",1,1" : "";
      const std::string refused = parse_error(command->get_name(), flag + "word" + parts);
      if (refused != "ConversionError" && refused != "ValidationError") continue;
      const std::string half = parse_error(command->get_name(), flag + "0.5" + parts);
      if (half == "ConversionError" || half == "ValidationError") continue;
      ++tried;
      for (const char* wrong : {"nan", "inf", "-inf", "1e999"}) {
        EXPECT_EQ(parse_error(command->get_name(), flag + wrong + parts), "ValidationError")
            << command->get_name() << " " << flag << wrong;
      }
    }
  }
  EXPECT_GT(tried, 20);
  const std::string file = "'" KAPPAMU_SOURCE_DIR "/README.md'";
  const ProcessResult result =
      kappamu("forward --kappa " + file + " --mu " + file + " --out none --tolerance nan");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.standard_error, HasSubstr("'nan' is not a finite number"));
}

TEST(Cli, MissingOptionsAreNamedAtOnce) {
  const ProcessResult result = kappamu("plan --size 20 16 6 --camera-width 1600");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.standard_error,
              HasSubstr("required and missing: --projector-px-per-mm, --camera-height, "
                        "--projector-width, --projector-height, --out"));
}

TEST(Cli, NoSubcommandIsUsageError) {
  EXPECT_EQ(kappamu("").exit_code, 2);
  EXPECT_EQ(kappamu("no-such-command").exit_code, 2);
  EXPECT_EQ(kappamu("--help").exit_code, 0);
  EXPECT_THAT(kappamu("--version").standard_output, HasSubstr("0.1.0"));
}

TEST(Cli, HelpIsOneScreenWithALinePerCommand) {
  const std::string help = kappamu("--help").standard_output;
  constexpr int rows = 40, columns = 100;
  std::istringstream lines(help);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    // Characters, not bytes: UTF-8 continues with 10xxxxxx.
    const auto width = std::count_if(line.begin(), line.end(), [](char c) {
      return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
    });
    EXPECT_LE(width, columns) << line;
  }
  EXPECT_LE(count, rows) << help;
  for (const char* group : {"Capture:", "Fit:", "Use:", "Check:"})
    EXPECT_THAT(help, HasSubstr(group));
  for (const char* command :
       {"plan", "import", "simulate", "calibrate", "merge", "chart", "run", "fit", "map", "export",
        "forward", "report", "score", "bench", "doctor"})
    EXPECT_THAT(help, HasSubstr("\n  " + std::string(command) + " "));
}

class CliFailures : public TemporaryFolderTest {
 protected:
  std::string at(const std::string& name) const { return (folder() / name).string(); }

  /// κ, μ of 4 × 4 × 4 voxels and one pattern of light, with one κ replaced.
  std::string forward_arguments(float odd_kappa) const {
    std::vector<float> kappa(64, 0.3F);
    kappa[21] = odd_kappa;
    io::write_npy(at("kappa.npy"), {4, 4, 4}, std::span<const float>(kappa));
    io::write_npy(at("mu.npy"), {4, 4, 4}, std::span<const float>(std::vector<float>(64, 0.01F)));
    io::write_npy(at("light.npy"), {1, 4, 4}, std::span<const float>(std::vector<float>(16, 1.0F)));
    return "forward --kappa " + at("kappa.npy") + " --mu " + at("mu.npy") +
           " --voxel 0.5 --eta 1.3 --irradiance " + at("light.npy") + " --lit-face z- -o " +
           at("out");
  }
};

TEST_F(CliFailures, ForwardOfAGoodVolumeSucceeds) {
  const ProcessResult result = kappamu(forward_arguments(0.3F) + " --device reference");
  EXPECT_EQ(result.exit_code, 0) << result.standard_error;
  EXPECT_TRUE(fs::exists(folder() / "out" / "summary.json"));
}

TEST_F(CliFailures, VolumeWithNaN) {
  expect_one_sentence(kappamu(forward_arguments(std::nanf("")) + " --device reference"),
                      "kappa.npy");
}

TEST_F(CliFailures, VolumeWithZeroKappa) {
  expect_one_sentence(kappamu(forward_arguments(0.0F) + " --device reference"), "kappa.npy");
}

// 1e-45 is the least float: with it nothing that follows light came to an end.
TEST_F(CliFailures, VolumeWithKappaNextToZero) {
  for (const char* method : {"multigrid", "montecarlo", "analytic"}) {
    expect_one_sentence(kappamu(forward_arguments(1e-45F) + " --method " + method),
                        "every kappa must be positive, from 1e-9 to 1e9 mm");
  }
}

TEST_F(CliFailures, VolumeWithNegativeKappa) {
  expect_one_sentence(kappamu(forward_arguments(-0.3F) + " --device reference"), "kappa.npy");
}

class ExportFailures : public CliFailures, public testing::WithParamInterface<float> {};

TEST_P(ExportFailures, BadKappaIsRefused) {
  const GridShape shape{4, 4, 4, 0.5};
  io::VolumeSet set;
  set.channels = {"R"};
  set.media = {{Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)}};
  io::write_volume_folder(at("volume"), set);
  std::vector<float> kappa(64, 0.3F);
  kappa[21] = GetParam();
  io::write_npy(at("volume/kappa_R.npy"), {4, 4, 4}, std::span<const float>(kappa));
  expect_one_sentence(kappamu("export " + at("volume") + " -o " + at("out")), "kappa");
  EXPECT_FALSE(fs::exists(folder() / "out" / "volume.vti"));
}

INSTANTIATE_TEST_SUITE_P(Cli, ExportFailures, testing::Values(std::nanf(""), 0.0F, -0.3F));

TEST_F(CliFailures, BenchThatIsNotBuilt) {
  fs::copy(KAPPAMU_PROGRAM, at("kappamu"));
  expect_one_sentence(run_process(at("kappamu") + " bench solve -o " + at("out")),
                      "scripts/build.sh release kappamu-studies builds");
}

TEST_F(CliFailures, BenchTakesTheOptionsBeforeItsName) {
  const ProcessResult result =
      kappamu("--seed 3 --json bench objects --quick -o " + at("out") + " --device reference");
  EXPECT_EQ(result.exit_code, 0) << result.standard_error;
  std::ifstream record(folder() / "out" / "objects-models.json");
  EXPECT_EQ(nlohmann::json::parse(record).at("seed"), 3);
}

TEST_F(CliFailures, NoOpenClDevice) {
  fs::create_directories(folder() / "no-drivers");
  expect_one_sentence(kappamu(forward_arguments(0.3F), "OCL_ICD_VENDORS=" + at("no-drivers") + "/"),
                      "OpenCL");
}

TEST_F(CliFailures, CacheFolderOfTheDriverThatCannotBeWritten) {
  for (const char* cache : {"", "/proc/nothing", "/etc/passwd"}) {
    expect_one_sentence(
        kappamu(forward_arguments(0.3F), "POCL_CACHE_DIR=" + std::string(cache)),
        "POCL_CACHE_DIR is '" + std::string(cache) + "', where OpenCL cannot write");
  }
}

// A home that cannot be written, as of service accounts: PoCL by itself then shows no device.
TEST_F(CliFailures, KernelsAreBuiltInATemporaryFolderWhereHomeCannotBeWritten) {
  const std::string command =
      "env -u POCL_CACHE_DIR -u XDG_CACHE_HOME HOME=/proc/none TMPDIR=" + folder().string() +
      " " KAPPAMU_PROGRAM " " + forward_arguments(0.3F);
  const std::string other_folder =
      "kappamu: '/proc/none/.cache/pocl/kcache' cannot be written: compiled OpenCL kernels are "
      "kept in '" +
      folder().string() + "/kappamu-kernels-";
  const ProcessResult first = run_process(command);
  if (first.standard_error.find("no OpenCL device") != std::string::npos) GTEST_SKIP();
  EXPECT_EQ(first.exit_code, 0) << first.standard_error;
  EXPECT_THAT(first.standard_error, StartsWith(other_folder));
  EXPECT_THAT(first.standard_error, HasSubstr(std::string("\n") + build_notice));
  // The last line warns that the block is thin.
  EXPECT_EQ(std::count(first.standard_error.begin(), first.standard_error.end(), '\n'), 3)
      << first.standard_error;
  const ProcessResult second = run_process(command);
  EXPECT_THAT(second.standard_error, StartsWith(other_folder));
  EXPECT_EQ(std::count(second.standard_error.begin(), second.standard_error.end(), '\n'), 2)
      << second.standard_error;
}

TEST_F(CliFailures, CacheFolderOfTheDriverDoesNotMatterWithoutOpenCl) {
  EXPECT_EQ(kappamu(forward_arguments(0.3F) + " --device reference", "POCL_CACHE_DIR=/proc/nothing")
                .exit_code,
            0);
}

TEST_F(CliFailures, NamesCannotSteerTheTerminal) {
  for (const char* wrong : {"verify x --\x1b[2Joption", "export x -o y --format '\x1b[2J'"}) {
    const ProcessResult usage = kappamu(wrong);
    EXPECT_EQ(usage.exit_code, 2);
    EXPECT_THAT(usage.standard_error, HasSubstr("\\x1b[2J"));
    EXPECT_THAT(usage.standard_error, testing::Not(HasSubstr("\x1b")));
  }
  const std::string value(500, '9');
  for (const std::string& wrong :
       {"fit x -o y --weight " + value + "z", "fit x -o y --weight=" + value + "z",
        "view x --model " + value}) {
    const ProcessResult usage = kappamu(wrong);
    EXPECT_EQ(usage.exit_code, 2);
    EXPECT_THAT(usage.standard_error, HasSubstr(value.substr(0, 80) + "..."));
    EXPECT_THAT(usage.standard_error, testing::Not(HasSubstr(value.substr(0, 81))));
  }
  expect_one_sentence(kappamu("verify 'a\x1b[2J\u202e"
                              "b'"),
                      "a\\x1b[2J\\u202eb: no such folder");
}

TEST_F(CliFailures, TextFilesOfAbsurdSizeAreRefused) {
  std::ofstream(folder() / "session.json") << "{\"a\": \"";
  fs::resize_file(folder() / "session.json", 500'000'000);  // sparse
  expect_one_sentence(kappamu("calibrate " + folder().string() + " -o " + at("out")),
                      "its 500000000 bytes are more than the 8388608");
}

TEST_F(CliFailures, UnknownDevice) {
  expect_one_sentence(kappamu(forward_arguments(0.3F) + " --device abacus"), "abacus");
}

TEST_F(CliFailures, FullDisk) {
  // A limit on file sizes stands in for a full disk: the write fails in the same place. Ignoring
  // SIGXFSZ makes it an error of write(), as ENOSPC is. Faces of 32 × 32 floats are twice the
  // limit.
  io::write_npy(at("kappa.npy"), {4, 32, 32},
                std::span<const float>(std::vector<float>(4096, 0.1F)));
  io::write_npy(at("mu.npy"), {4, 32, 32}, std::span<const float>(std::vector<float>(4096, 0.01F)));
  io::write_npy(at("light.npy"), {1, 32, 32},
                std::span<const float>(std::vector<float>(1024, 1.0F)));
  const ProcessResult result = run_process(
      "trap '' XFSZ; ulimit -f 4; exec " KAPPAMU_PROGRAM " forward --kappa " + at("kappa.npy") +
      " --mu " + at("mu.npy") + " --voxel 0.5 --eta 1.3 --irradiance " + at("light.npy") +
      " --lit-face z- --device reference -o " + at("out"));
  expect_one_sentence(result, "cannot write");
  // Nothing half-written stays under a final name.
  EXPECT_FALSE(fs::exists(folder() / "out" / "exitance_z+.npy"));
}

// /dev/full takes no byte, as a full disk behind a redirection.
TEST_F(CliFailures, ResultsThatCannotBePrintedAreNoSuccess) {
  for (const char* command : {"doctor --json", "--help", "plan --help"}) {
    expect_one_sentence(run_process(std::string(KAPPAMU_PROGRAM " ") + command + " > /dev/full"),
                        "cannot write to standard output");
  }
}

// The fewest views that calibrate: as many are shot as asked for, and they do.
TEST_F(CliFailures, SimulateShootsTheViewsAskedFor) {
  const std::string simulate =
      "simulate --sample tiny --patches 1 --no-validation --holdout 0 --device reference -o ";
  expect_one_sentence(kappamu(simulate + at("none") + " --boards 2"),
                      "boards is 2: choose a value from 3 to 60");
  expect_one_sentence(kappamu(simulate + at("none") + " --planes 41"), "planes is 41");
  const ProcessResult few = kappamu(simulate + at("few") + " --boards 3 --planes 4");
  ASSERT_EQ(few.exit_code, 0) << few.standard_error;
  std::ifstream file(folder() / "few/session/session.json");
  const auto calibration = nlohmann::json::parse(file).at("calibration");
  EXPECT_EQ(calibration.at("camera_boards").size(), 3U);
  EXPECT_EQ(calibration.at("projector_planes").size(), 4U);
  const ProcessResult calibrated = kappamu("calibrate " + at("few/session") + " -o " + at("run"));
  EXPECT_EQ(calibrated.exit_code, 0) << calibrated.standard_error;
}

TEST_F(CliFailures, BarsAndPatchesAreOneChoice) {
  const ProcessResult both =
      kappamu("simulate --sample tiny --bars 2 --patches 2 -o " + at("both"));
  EXPECT_EQ(both.exit_code, 2) << both.standard_error;
  EXPECT_THAT(both.standard_error, testing::HasSubstr("--bars excludes --patches"));
  expect_one_sentence(kappamu("simulate --sample tiny --bars 65 -o " + at("many")),
                      "bars is 65: choose a value from 1 to 64");
}

TEST_F(CliFailures, MissingInputsAreNamed) {
  expect_one_sentence(kappamu("run " + at("nowhere") + " -o " + at("run")), "nowhere");
  expect_one_sentence(kappamu("calibrate " + at("nowhere") + " -o " + at("run")), "nowhere");
  expect_one_sentence(kappamu("merge " + at("nowhere") + " -o " + at("run")), "nowhere");
  expect_one_sentence(kappamu("report " + at("nowhere")), "nowhere");
  expect_one_sentence(kappamu("export " + at("nowhere") + " -o " + at("out")), "nowhere");
}

}  // namespace
}  // namespace kappamu::app

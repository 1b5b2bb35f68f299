// What is promised of the user's files (docs/limits.md): nothing of theirs is replaced or removed,
// nothing is written outside the output folder. From outside, by the command.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "io/measurements_file.h"
#include "io/npy.h"
#include "io/read_file.h"
#include "io/volume/volume_file.h"
#include "tests/app/process.h"
#include "tests/app/tiny_session.h"
#include "tests/report/made_up_run.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

class UserFiles : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    TemporaryFolderTest::SetUp();
    // Hard links need one file system: beside the shared session, not in the system's /tmp.
    beside_ = fs::path(KAPPAMU_TEST_FOLDER) / ("files-" + folder().filename().string());
    fs::create_directories(beside_);
  }
  void TearDown() override {
    fs::remove_all(beside_);
    TemporaryFolderTest::TearDown();
  }
  std::string at(const std::string& name) const { return (beside_ / name).string(); }
  fs::path session() const { return linked_session(beside_ / "session"); }

  void write(const std::string& name, const std::string& text = "mine") const {
    io::write_text_atomically(beside_ / name, text);
  }
  std::string read(const std::string& name) const { return io::read_text(beside_ / name); }

  /// Every file below `folder` with size and time.
  static std::map<std::string, std::pair<std::uintmax_t, fs::file_time_type>> listing(
      const fs::path& folder) {
    std::map<std::string, std::pair<std::uintmax_t, fs::file_time_type>> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file()) continue;
      files[entry.path().string()] = {entry.file_size(), entry.last_write_time()};
    }
    return files;
  }
  /// A volume of four voxels as `name`.
  std::string volume(const std::string& name) const {
    io::VolumeSet set;
    set.channels = {"R"};
    const GridShape shape{2, 2, 1, 0.5};
    set.media.push_back({Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)});
    io::write_vdb(beside_ / name, set);
    return at(name);
  }
  /// Measurements that any fit reads, in `name`.
  std::string measurements(const std::string& name) const {
    SurfaceMeasurements m;
    m.grid = {2, 2, 2, 0.5};
    m.eta = 1.3;
    m.channels = {"R"};
    m.patterns = 1;
    m.irradiance.assign(4, 1.0F);
    m.value.assign(4, 0.1F);
    m.variance.assign(4, 1e-6F);
    io::write_measurements(beside_ / name, m);
    return at(name);
  }

  fs::path beside_;
};

TEST_F(UserFiles, OutputFolderIsApartFromTheSession) {
  const std::string input = session().string();
  fs::create_directory_symlink(input, beside_ / "link");
  fs::create_directory_symlink(beside_, beside_ / "up");
  const auto before = listing(beside_);
  for (const std::string& out : {at("link"), at("missing/../link"), at("up/session/frames/.."),
                                 at("session/"), at("up/up/session")}) {
    expect_one_sentence(kappamu("run " + input + " -o " + out), "the output folder is ");
  }
  expect_one_sentence(kappamu("run " + at("link") + " -o " + at("session/new/run")), "lies in ");
  for (const char* command : {"calibrate ", "merge ", "run "}) {
    expect_one_sentence(kappamu(command + input + " -o " + input), "the output folder is ");
    expect_one_sentence(kappamu(command + input + " -o " + beside_.string()), "contains ");
    expect_one_sentence(kappamu(command + input + " -o " + at("link/run")), "lies in ");
  }
  EXPECT_EQ(listing(beside_), before);
  EXPECT_FALSE(fs::exists(beside_ / "missing"));
  EXPECT_FALSE(fs::exists(beside_ / "session" / "run"));
}

TEST_F(UserFiles, OutputFoldersOfOtherCommandsAreApartFromTheirInputs) {
  const std::string vdb = volume("v/volume.vdb");
  const std::string m = measurements("m");
  io::write_image(beside_ / "t" / "spots.png", Image<std::uint8_t>(4, 4, 3, 90));
  write("r/recipe.json", R"({"format": "kappamu-edit", "version": 1, "edits": [
    {"operation": "multiply", "mu": 2, "where": {"kind": "texture", "image": "../t/spots.png",
     "face": "z+", "depth_mm": 1}}]})");
  const auto before = listing(beside_);
  expect_one_sentence(kappamu("export " + vdb + " -o " + at("v")), "contains ");
  expect_one_sentence(kappamu("fit " + m + " -o " + m), "is ");
  expect_one_sentence(kappamu("fit " + m + " -o " + m + "/fit"), "lies in ");
  expect_one_sentence(kappamu("run " + m + " -o " + m + "/run"), "lies in ");
  expect_one_sentence(kappamu("forward --kappa " + vdb + " --mu " + vdb + " --irradiance " + m +
                              "/irradiance.npy -o " + m),
                      "contains ");
  expect_one_sentence(run_process(KAPPAMU_PROGRAM "-studies slabs --data " + m + " -o " + m),
                      "is ");
  expect_one_sentence(kappamu("chart " + at("t/spots.png") + " -o " + at("t")), "contains ");
  const std::string edit = "edit " + vdb + " --recipe " + at("r/recipe.json") + " -o ";
  for (const char* out : {"v", "r", "t"}) {
    expect_one_sentence(kappamu(edit + at(out)), "contains ");
  }
  expect_one_sentence(kappamu("simulate --sample tiny --pattern " + m + "/p.png -o " + m),
                      "contains ");
  EXPECT_EQ(listing(beside_), before);
}

TEST_F(UserFiles, ForeignFilesInARunFolderStay) {
  const std::string input = session().string();
  const std::string run = at("run");
  const std::string arguments = input + " -o " + run;
  for (const char* file : {"run/hdr/precious.txt", "run/hdr/fit_00.exr",
                           "run/measurements/value.npy", "run/merge.partial/hdr/precious.txt"}) {
    write(file);
    expect_one_sentence(kappamu("merge " + arguments), "is in the way");
    expect_one_sentence(kappamu("merge --force " + arguments), "is in the way");
    EXPECT_EQ(read(file), "mine");
    fs::remove_all(run);
  }
  for (const char* file : {"run/report.html", "run/export/mine.txt", "run/fit/fit.json"}) {
    write(file);
    // Before the first stage, not after hours of work.
    expect_one_sentence(kappamu("run " + arguments), std::string(file).substr(4));
    EXPECT_FALSE(fs::exists(beside_ / "run" / "calibration"));
    fs::remove_all(run);
  }
  write("run/notes.txt");
  write("run/photographs/calibration/board.png");
  EXPECT_EQ(kappamu("merge " + arguments).exit_code, 0);
  EXPECT_EQ(read("run/notes.txt"), "mine");
  EXPECT_EQ(read("run/photographs/calibration/board.png"), "mine");
  const std::string picture = "run/hdr/precious.txt";
  write(picture);
  expect_one_sentence(kappamu("merge --force " + arguments), "is in the way");
  EXPECT_EQ(read(picture), "mine");
  write("run/run.json", "{\"mine\": 1}");
  expect_one_sentence(kappamu("merge --force " + arguments), "run.json");
  EXPECT_EQ(read("run/run.json"), "{\"mine\": 1}");
}

TEST_F(UserFiles, FormerResultsStayWhenNewOnesFail) {
  const fs::path input = session();
  const std::string arguments = input.string() + " -o " + copied_run(beside_ / "run").string();
  auto before = listing(beside_ / "run");
  const json document = json::parse(io::read_text(input / "session.json"));
  const auto frame = document["calibration"]["dark"][0]["file"].get<std::string>();
  fs::remove(input / frame);
  expect_one_sentence(kappamu("calibrate --force " + arguments), frame);
  expect_one_sentence(kappamu("merge --force " + arguments), frame);
  auto after = listing(beside_ / "run");
  for (auto* files : {&before, &after}) files->erase(at("run/run.json"));
  std::erase_if(after, [](const auto& file) {
    return file.first.find("merge.partial") != std::string::npos;
  });
  EXPECT_EQ(after, before);
}

TEST_F(UserFiles, ForeignFilesOfOtherCommandsStay) {
  const std::string vdb = volume("volume.vdb");
  const std::string m = measurements("m");
  const std::string out = " -o " + at("out");
  const auto refused = [&](const std::string& command, const std::string& file,
                           const std::string& named = "") {
    write("out/" + file);
    expect_one_sentence(kappamu(command + out), named.empty() ? file : named);
    EXPECT_EQ(read("out/" + file), "mine");
    fs::remove_all(at("out"));
  };
  refused("export " + vdb, "volume.vti");
  refused("export " + vdb, "npy/mine.txt");
  refused("fit " + m, "kappa_R.npy");
  refused("fit " + m, "fit.json");
  refused("fit " + m, "fit.partial/mine.txt", "fit.partial: is in the way");
  refused("forward --kappa " + vdb + " --mu " + vdb + " --irradiance " + m + "/irradiance.npy",
          "summary.json");
  refused("bench objects", "objects.json");
  write("recipe.json", R"({"format": "kappamu-edit", "version": 1, "edits": [
    {"operation": "multiply", "mu": 2, "where": {"kind": "all"}}]})");
  const std::string edit = "edit " + vdb + " --recipe " + at("recipe.json");
  refused(edit, "volume.vdb");
  refused(edit, "recipe.json");
  write("photograph.png");
  refused("chart " + at("photograph.png"), "chart.csv");
  refused("simulate --sample tiny", "truth/mine.txt", "truth exists already");
  refused(
      "plan --size 20 16 6 --projector-px-per-mm 20 --camera-width 1600 --camera-height 1200 "
      "--projector-width 1024 --projector-height 768",
      "session.json");
  // What is not in the way is left alone, and what was written here is replaced until it is edited.
  write("out/notes.txt");
  const std::string vti = "export " + vdb + " --format vti" + out;
  ASSERT_EQ(kappamu(vti).exit_code, 0);
  ASSERT_EQ(kappamu(vti).exit_code, 0);
  ASSERT_EQ(kappamu("export " + vdb + " --format npy" + out).exit_code, 0);
  EXPECT_EQ(read("out/notes.txt"), "mine");
  EXPECT_TRUE(fs::exists(at("out/volume.vti"))) << "of another format, and still wanted";
  write("out/volume.vti");
  expect_one_sentence(kappamu(vti), "volume.vti: was changed");
  EXPECT_EQ(read("out/volume.vti"), "mine");
  // A report over a foreign report.
  make_run(beside_, {});
  write("run/report.html");
  expect_one_sentence(kappamu("report " + at("run")), "report.html: is in the way");
  EXPECT_EQ(read("run/report.html"), "mine");
  fs::remove(at("run/report.html"));
  EXPECT_EQ(kappamu("report " + at("run")).exit_code, 0);
  EXPECT_EQ(kappamu("report " + at("run")).exit_code, 0) << "its own is made again";
}

TEST_F(UserFiles, NamesDoNotLeaveTheOutputFolder) {
  const std::string m = measurements("m");
  write("outside/pwn.npy");
  const std::string text = read("m/measurements.json");
  for (const char* name : {"a/../../../outside/pwn", "a/../../outside/pwn", "..", "a b", ""}) {
    json document = json::parse(text);
    document["channels"][0] = name;
    write("m/measurements.json", document.dump());
    expect_one_sentence(kappamu("fit " + m + " -o " + at("out")), "channels[0] is");
    expect_one_sentence(kappamu("run " + m + " -o " + at("run")), "channels[0] is");
    fs::remove_all(at("run"));
  }
  EXPECT_EQ(read("outside/pwn.npy"), "mine");
  EXPECT_EQ(std::distance(fs::directory_iterator(beside_ / "outside"), {}), 1);
  EXPECT_FALSE(fs::exists(at("out")));

  // Volumes as a folder, and a finished fit to go on from.
  io::VolumeSet set;
  set.channels = {"R"};
  set.media.push_back({Volume<double>({2, 1, 1, 0.5}, 0.3), Volume<double>({2, 1, 1, 0.5}, 0.01)});
  io::write_volume_folder(beside_ / "volume", set);
  json volume = json::parse(read("volume/volume.json"));
  volume["channels"][0] = "../../outside/pwn";
  write("volume/volume.json", volume.dump());
  expect_one_sentence(kappamu("export " + at("volume") + " -o " + at("out")), "../../outside/pwn");
  make_run(beside_, {});
  json fit = json::parse(read("run/fit/fit.json"));
  fit["channels"][0]["name"] = "../../outside/pwn";
  write("run/fit/fit.json", fit.dump());
  expect_one_sentence(kappamu("report " + at("run")), "../../outside/pwn");
}

TEST_F(UserFiles, FramesBehindLinksOutOfTheSessionAreRead_OnlyWhenAsked) {
  const fs::path input = session();
  const json document = json::parse(io::read_text(input / "session.json"));
  const auto frame = document["patterns"][0]["frames"][0]["file"].get<std::string>();
  fs::create_directories(beside_ / "elsewhere");
  fs::rename(input / frame, beside_ / "elsewhere" / "frame.png");
  fs::create_symlink(beside_ / "elsewhere" / "frame.png", input / frame);
  const std::string arguments = input.string() + " -o " + at("run");
  expect_one_sentence(kappamu("merge " + arguments), frame);
  expect_one_sentence(kappamu("run " + arguments), "--follow-links");
  EXPECT_FALSE(fs::exists(at("run")));
  EXPECT_EQ(kappamu("merge --follow-links " + arguments).exit_code, 0);
  // A link that stays inside is a file like others.
  fs::rename(beside_ / "elsewhere" / "frame.png", input / "frames" / "renamed.png");
  fs::remove(input / frame);
  fs::create_symlink("renamed.png", input / frame);
  EXPECT_EQ(kappamu("merge --force " + arguments).exit_code, 0);
  // Links round in a circle: beside the files of a run they are others', as a frame none.
  fs::create_directory_symlink(".", beside_ / "run" / "loop");
  fs::create_symlink("self", beside_ / "run" / "self");
  const ProcessResult verified = kappamu("verify " + at("run"));
  EXPECT_EQ(verified.exit_code, 0);
  EXPECT_THAT(verified.standard_output, HasSubstr("self"));
  fs::remove(input / frame);
  fs::create_symlink(fs::path(frame).filename(), input / frame);
  expect_one_sentence(kappamu("merge --force " + arguments), "no such frame");
}

TEST_F(UserFiles, RenderKeepsTheRuleOfOtherCommands) {
  write("scene.json", R"({"format": "kappamu-scene", "version": 1,
    "objects": [{"name": "ball", "shape": "sphere", "size_mm": 20,
                 "material": {"published": "whole milk"}}],
    "lights": [{"kind": "directional", "direction": [0, 0, -1], "irradiance": 1}],
    "camera": {"position_mm": [0, 0, 100], "target_mm": [0, 0, 0], "fov_deg": 20},
    "film": {"width": 16, "height": 16, "samples": 1}, "model": {"name": "embedded", "tolerance": 0.3}})");
  const std::string render = "render " + at("scene.json") + " --device reference -o ";
  write("out/picture.png");
  expect_one_sentence(kappamu(render + at("out")), "picture.png: is in the way");
  EXPECT_EQ(read("out/picture.png"), "mine");
  expect_one_sentence(kappamu(render + beside_.string()), "contains ");
  fs::remove(at("out/picture.png"));
  write("out/notes.txt");
  const ProcessResult first = kappamu(render + at("out"));
  EXPECT_THAT(first.exit_code, testing::AnyOf(0, 3)) << first.standard_error;
  EXPECT_THAT(kappamu(render + at("out")).exit_code, testing::AnyOf(0, 3))
      << "its own is made again";
  EXPECT_EQ(read("out/notes.txt"), "mine");
  EXPECT_EQ(kappamu("verify " + at("out")).exit_code, 0);
  expect_one_sentence(kappamu("render --new-scene marble -o " + at("scene.json")),
                      "exists already");
}

TEST_F(UserFiles, AWriteRefusedBySizeLeavesNoPartialFolder) {
  const std::string arguments = session().string() + " -o " + at("run");
  for (const char* command : {"calibrate ", "merge "}) {
    expect_one_sentence(
        run_process("ulimit -f 24; " KAPPAMU_PROGRAM " " + std::string(command) + arguments),
        "cannot write ");
    for (const auto& entry : fs::directory_iterator(at("run"))) {
      EXPECT_THAT(entry.path().filename().string(), testing::Not(testing::HasSubstr("partial")));
    }
  }
}

TEST_F(UserFiles, PlanMayBeMadeAgainUntilItIsUsed) {
  const std::string plan =
      "plan --size 20 16 6 --projector-px-per-mm 20 --camera-width 1600 --camera-height 1200 "
      "--projector-width 1024 --projector-height 768 -o " +
      at("plan");
  ASSERT_EQ(kappamu(plan).exit_code, 0);
  EXPECT_TRUE(fs::is_directory(at("plan/frames")));
  ASSERT_EQ(kappamu(plan + " --boards 12").exit_code, 0);
  write("plan/frames/fit_00_0.png");
  expect_one_sentence(kappamu(plan), "frames/fit_00_0.png: is in the way");
  fs::remove(at("plan/frames/fit_00_0.png"));
  const std::string edited = read("plan/session.json") + "\n";
  write("plan/session.json", edited);
  expect_one_sentence(kappamu(plan), "session.json: was changed");
  EXPECT_EQ(read("plan/session.json"), edited);
}

TEST_F(UserFiles, TwoFitsIntoOneFolderAreKeptApart) {
  const fs::path run = make_run(folder(), {});
  const std::string fit = "fit " + run.string() + " --device reference -o " + at("out");
  // The first works until it is killed; meanwhile the second is refused.
  const ProcessResult both =
      run_process(KAPPAMU_PROGRAM " " + fit +
                  " >/dev/null 2>&1 & first=$!; "
                  "while [ ! -d " +
                  at("out/fit.partial") + " ]; do sleep 0.05; done; " KAPPAMU_PROGRAM " " + fit +
                  "; code=$?; kill -9 $first; exit $code");
  expect_one_sentence(both, "another kappamu is working");
}

}  // namespace
}  // namespace kappamu::app

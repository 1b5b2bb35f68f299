// `kappamu export` from outside. What is inside the files is checked in tests/io.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/npy.h"
#include "io/read_file.h"
#include "io/volume/volume_file.h"
#include "tests/app/process.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ExportCommand : public TemporaryFolderTest {
 protected:
  static io::VolumeSet volume() {
    const GridShape shape{5, 3, 4, 0.25};
    io::VolumeSet set;
    set.channels = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
      set.media.push_back({Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)});
    }
    set.eta = 1.3;
    return set;
  }
  std::string path(const char* name) const { return (folder() / name).string(); }
};

TEST_F(ExportCommand, AllFormatsAreWrittenAndListed) {
  io::write_vdb(folder() / "run" / "fit" / "volume.vdb", volume());
  const ProcessResult result = kappamu("--json export " + path("run") + " -o " + path("out"));
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  const auto json = nlohmann::json::parse(last_line(result.standard_output));
  EXPECT_EQ(json["volume"], path("run/fit/volume.vdb"));
  EXPECT_TRUE(json["warnings"].empty());
  std::size_t listed = 0;
  for (const auto& file : json["files"]) {
    EXPECT_TRUE(fs::exists(file.get<std::string>())) << file;
    ++listed;
  }
  std::size_t present = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder() / "out")) {
    const bool record = entry.path().filename() == "kappamu-files.json";
    present += entry.is_regular_file() && !record ? 1 : 0;
  }
  EXPECT_EQ(listed, present);
  for (const char* name : {"out/volume.vti", "out/volume.vdb", "out/mitsuba/scene.xml",
                           "out/medium.pbrt", "out/npy/volume.json", "out/exr/slice_003.exr"}) {
    EXPECT_TRUE(fs::exists(folder() / name)) << name;
  }
}

TEST_F(ExportCommand, FormatsAreChosen) {
  io::write_vdb(folder() / "a.vdb", volume());
  const ProcessResult result =
      kappamu("export " + path("a.vdb") + " -o " + path("out") + " --format vti,npy");
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  EXPECT_TRUE(fs::exists(folder() / "out" / "volume.vti"));
  EXPECT_TRUE(fs::exists(folder() / "out" / "npy" / "kappa_G.npy"));
  EXPECT_FALSE(fs::exists(folder() / "out" / "mitsuba"));
  EXPECT_EQ(kappamu("export " + path("a.vdb") + " -o " + path("out") + " --format stl").exit_code,
            2);
}

/// A folder of arrays from anyone, with one bad number in it.
TEST_F(ExportCommand, NaNAndNonPositiveKappaAreRefused) {
  for (const float bad : {std::nanf(""), 0.0F, -0.5F}) {
    io::write_volume_folder(folder() / "a", volume());
    std::vector<float> kappa = io::read_npy(folder() / "a" / "kappa_G.npy").values;
    kappa[(2 * 3 + 1) * 5 + 4] = bad;
    io::write_npy(folder() / "a" / "kappa_G.npy", {4, 3, 5}, std::span<const float>(kappa));
    const ProcessResult result = kappamu("export " + path("a") + " -o " + path("out"));
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.standard_error, HasSubstr("channel G: kappa is "));
    EXPECT_THAT(result.standard_error, HasSubstr("at voxel x=4 y=1 z=2; every kappa must be"));
    EXPECT_EQ(std::count(result.standard_error.begin(), result.standard_error.end(), '\n'), 1);
    EXPECT_FALSE(fs::exists(folder() / "out"));
  }
}

TEST_F(ExportCommand, MissingAndTruncatedVolumesAreRefused) {
  ProcessResult result = kappamu("export " + path("none.vdb") + " -o " + path("out"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.standard_error,
            "kappamu: cannot read " + path("none.vdb") + ": there is no such file or folder\n");
  result = kappamu("export " + folder().string() + " -o " + path("out"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.standard_error, HasSubstr("has no volume.vdb, fit/volume.vdb or volume.json"));
  io::write_vdb(folder() / "a.vdb", volume());
  fs::resize_file(folder() / "a.vdb", fs::file_size(folder() / "a.vdb") / 2);
  result = kappamu("export " + path("a.vdb") + " -o " + path("out"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.standard_error, HasSubstr("not a complete OpenVDB file"));
}

TEST_F(ExportCommand, HelpIsAManualPage) {
  const ProcessResult result = kappamu("export --help");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* part : {"mitsuba/", "sigma_t = 1/(3 kappa)", "x fastest", "Example: "}) {
    EXPECT_THAT(result.standard_output, HasSubstr(part));
  }
}

}  // namespace
}  // namespace kappamu::app

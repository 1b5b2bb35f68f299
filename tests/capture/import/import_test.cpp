// A folder of photographs becomes a session: what fits is taken, what does not is refused by name.
#include "capture/import/import.h"
#include "capture/import/photograph_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <zlib.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <regex>
#include <string>

#include "capture/rig/shoot.h"
#include "capture/session/frames.h"
#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "io/image/orientation.h"
#include "io/read_file.h"
#include "tests/capture/session_files.h"
#include "tests/capture/simulated_camera.h"
#include "tests/sentence.h"

namespace kappamu::capture {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr int width = 64;
constexpr int height = 48;

struct Exif {
  const char* exposure;  // rational, "1/30"
  const char* aperture = "56/10";
  int iso = 100;
  int orientation = 1;
};

/// Numbers as a little-endian file holds them.
void put(std::string& to, unsigned long value, int bytes) {
  for (int i = 0; i < bytes; ++i) to += static_cast<char>(value >> 8 * i & 0xFFU);
}

/// An EXIF block: one directory with the camera's model, and the EXIF directory behind it.
std::string exif_block(const Exif& exif) {
  const std::string model("Test camera", 12);
  const auto entry = [](std::string& to, unsigned tag, unsigned type, unsigned count,
                        unsigned value) {
    put(to, tag, 2);
    put(to, type, 2);
    put(to, count, 4);
    put(to, value, 4);
  };
  const auto fraction = [](const char* text) {
    std::string bytes;
    unsigned a = 0;
    unsigned b = 1;
    std::sscanf(text, "%u/%u", &a, &b);
    put(bytes, a, 4);
    put(bytes, b, 4);
    return bytes;
  };
  constexpr unsigned second = 8 + 2 + 3 * 12 + 4;
  constexpr unsigned values = second + 2 + 3 * 12 + 4;
  std::string block("II*\0\x08\0\0\0", 8);
  put(block, 3, 2);
  entry(block, 0x110, 2, 12, values + 16);  // Model
  entry(block, 0x112, 3, 1, static_cast<unsigned>(exif.orientation));
  entry(block, 0x8769, 4, 1, second);  // EXIF directory
  put(block, 0, 4);
  put(block, 3, 2);
  entry(block, 0x829A, 5, 1, values);      // ExposureTime
  entry(block, 0x829D, 5, 1, values + 8);  // FNumber
  entry(block, 0x8827, 3, 1, static_cast<unsigned>(exif.iso));
  put(block, 0, 4);
  return block + fraction(exif.exposure) + fraction(exif.aperture) + model;
}

/// As the PNG chunk eXIf behind the header, in place of one that is there.
void write_exif(const fs::path& file, const Exif& exif) {
  const auto big_endian = [](std::size_t value) {
    std::string bytes;
    for (int i = 3; i >= 0; --i) bytes += static_cast<char>(value >> 8 * i & 0xFFU);
    return bytes;
  };
  constexpr std::size_t header_end = 8 + 25;
  const std::string block = exif_block(exif);
  std::string png = io::read_text(file);
  if (png.compare(header_end + 4, 4, "eXIf") == 0) png.erase(header_end, block.size() + 12);
  const std::string checked = "eXIf" + block;
  const auto checksum = ::crc32(0, reinterpret_cast<const unsigned char*>(checked.data()),
                                static_cast<unsigned>(checked.size()));
  png.insert(header_end, big_endian(block.size()) + checked + big_endian(checksum));
  io::write_text_atomically(file, png);
}

class Import : public testing::Test {
 protected:
  // A plan of two patterns, and photographs of all its shots: 12-bit linear PNG with EXIF.
  Import() {
    photographs = folder.path() / "photographs";
    plan = folder.path() / "plan";
    out = folder.path() / "session";
    fs::create_directories(photographs / "day_1");
    fs::create_directories(plan / "patterns");
    session.folder = plan;
    session.sample.name = "block";
    session.sample.grid = {10, 8, 4};
    session.sample.voxel_mm = 1.0;
    session.camera = {1000, 800, 12, Encoding::linear, {}, {}, {}};
    session.projector = {64, 48};
    session.calibration_station = "front";
    session.pattern_station = "back";
    for (const char* id : {"fit_00", "fit_01"}) {
      const std::string image = std::string("patterns/") + id + ".png";
      io::write_image(plan / image, Image<std::uint8_t>(64, 48, 1, 255));
      session.patterns.push_back({id, image, PatternRole::fit, {{"frames/planned.png", 1.0}}});
    }
    Calibration& shots = session.calibration;
    shots.board = {9, 6, 4.0};
    shots.camera_boards = {{"b.png", 1.0}};
    shots.projected_board = {5, 4, 8.0, {8.0, 8.0}};
    shots.projector_planes = {{{"p.png", 1.0}, Frame{"q.png", 1.0}, {}}};
    shots.sample_views = {{"front", Face::z_minus, {"s.png", 1.0}, {}},
                          {"back", Face::z_plus, {"t.png", 1.0}, {}}};
    shots.dark = {{"d.png", 1.0}};
    shots.white_target = WhiteTarget{0.99, {{"w.png", 1.0}}};
    shots.colour_chart = ColourChart{{{"c.png", 1.0}}, {}};
    write_session(session);

    const Image<float> light = smooth_scene(width, height, 3, 0.05, 2.0);
    const Image<float> none(width, height, 3, 0.0F);
    for (const char* stem : {"fit_00", "fit_01", "white"}) {
      take(std::string(stem) + "_0.png", light, {"1/30"});
      take(std::string(stem) + "_1.png", light, {"1/5"});
      take(std::string(stem) + "_2.png", light, {"1/2"});
    }
    for (const char* name : {"board_00.png", "board_01.png", "plane_00_board.png",
                             "plane_00_projected.png", "sample_front.png", "sample_back.png"}) {
      take(name, light, {"1/5"});
    }
    take("dark_0.png", none, {"1/30"});
  }

  void take(const std::string& name, const Image<float>& light, const Exif& exif) {
    const fs::path file = photographs / "day_1" / name;
    double seconds = 1.0;
    double divisor = 1.0;
    std::sscanf(exif.exposure, "%lf/%lf", &seconds, &divisor);
    const auto frames = shoot_stack(camera, light, {seconds / divisor}, ++seed);
    io::write_code_image(file, frames[0].pixels, 12);
    write_exif(file, exif);
  }
  Session import() {
    Progress silent;
    return import_session({photographs, plan, out, table}, silent);
  }
  struct Listener : Progress {
    void warn(const std::string& sentence) override { text += sentence + "\n"; }
    std::string text;
  };
  /// What the import warns of.
  std::string warnings(std::optional<Orientation> orientation = {}) {
    Listener listener;
    fs::remove(out / "session.json");
    import_session({photographs, plan, out, table, Links::within, orientation}, listener);
    return listener.text;
  }
  /// A table of all photographs without exposure times, but for `file`'s.
  void write_table(const std::string& file, const std::string& exposure) {
    std::string text = "file,shot,exposure_s\n";
    for (const auto& entry : fs::directory_iterator(photographs / "day_1")) {
      const std::string name = entry.path().filename().string();
      const bool stack = name.find("fit") == 0 || name.find("white") == 0 ||
                         name.find("board") == 0 || name.find("dark") == 0;
      const std::string stem = entry.path().stem().string();
      text += "day_1/" + name + "," + (stack ? stem.substr(0, stem.rfind('_')) : stem) + "," +
              (name == file ? exposure : "") + "\n";
    }
    table = folder.path() / "shots.csv";
    write_text(*table, text);
  }
  std::string refusal() {
    return sentence_of([&] { import(); });
  }
  std::string path(const std::string& name) const {
    return (photographs / "day_1" / name).string();
  }

  const SimulatedCamera camera{12, 40.0, 20000.0, 5.0, straight_curve};
  unsigned seed = 0;
  OwnFolder folder;
  fs::path photographs, plan, out;
  std::optional<fs::path> table;
  Session session;
};

TEST_F(Import, HeaderlessRawIsTakenAsThePlanDescribesIt) {
  session.channels = {"Y"};
  session.camera.width = width;
  session.camera.height = height;
  session.camera.raw_layout = io::RawLayout{16, false, 0, {}};
  write_session(session);
  table = folder.path() / "table.csv";
  std::string rows = "file,shot,exposure_s\n";
  std::vector<fs::path> pngs;
  for (const auto& entry : fs::directory_iterator(photographs / "day_1")) {
    pngs.push_back(entry.path());
  }
  for (const fs::path& png : pngs) {
    const Image<std::uint16_t> codes = io::read_code_image(png);
    std::string bytes;
    for (std::size_t i = 1; i < codes.size(); i += 3) {
      const unsigned code = codes.values()[i];
      bytes += {static_cast<char>(code & 255U), static_cast<char>(code >> 8)};
    }
    const std::string stem = png.stem().string();
    rows += "day_1/" + stem + ".raw," + std::regex_replace(stem, std::regex("_[0-9]+$"), "") + "," +
            std::to_string(*io::read_photo_settings(png).exposure_s) + "\n";
    write_text(path(stem + ".raw"), bytes);
    fs::remove(png);
  }
  write_text(*table, rows);
  import();
  const Session read = read_session(out);
  EXPECT_EQ(read.camera.bit_depth, 12);
  ASSERT_EQ(read.patterns[0].frames.size(), 3U);
  EXPECT_EQ(read.patterns[0].frames[0].file, "photographs/day_1/fit_00_0.raw");
  EXPECT_EQ(load_frame(read, read.patterns[0].frames[0]).channels(), 1);
}

TEST_F(Import, TakesExposuresSizeAndShotsFromThePhotographs) {
  const Session made = import();
  const Session read = read_session(out);
  EXPECT_EQ(read.camera.width, width);
  EXPECT_EQ(read.camera.height, height);
  EXPECT_EQ(read.camera.bit_depth, 12);
  ASSERT_EQ(read.patterns.size(), 2U);
  ASSERT_EQ(read.patterns[1].frames.size(), 3U);
  EXPECT_NEAR(read.patterns[1].frames[0].exposure_s, 1.0 / 30.0, 1e-9);
  EXPECT_NEAR(read.patterns[1].frames[2].exposure_s, 0.5, 1e-9);
  EXPECT_EQ(read.patterns[1].frames[2].file, "photographs/day_1/fit_01_2.png");
  EXPECT_TRUE(fs::exists(out / read.patterns[1].frames[2].file));
  EXPECT_TRUE(fs::exists(out / read.patterns[1].image));
  EXPECT_EQ(read.calibration.camera_boards.size(), 2U);
  EXPECT_EQ(read.calibration.projector_planes.size(), 1U);
  EXPECT_EQ(read.calibration.white_target->frames.size(), 3U);
  EXPECT_FALSE(read.calibration.colour_chart) << "planned, not photographed, optional";
}

// The numbers in the names, not their order as text, are the order of the code.
TEST_F(Import, SeveralPhotographsOfOneExposureAreAllTaken) {
  const Image<float> light = smooth_scene(width, height, 3, 0.05, 2.0);
  take("fit_00_3.png", light, {"1/5"});
  take("fit_00_4.png", light, {"1/5"});
  take("white_3.png", light, {"1/2"});
  take("dark_1.png", Image<float>(width, height, 3, 0.0F), {"1/30"});
  const Session made = import();
  std::vector<double> times;
  for (const Frame& frame : made.patterns[0].frames) times.push_back(frame.exposure_s);
  EXPECT_THAT(times, testing::ElementsAre(1.0 / 30.0, 0.2, 0.2, 0.2, 0.5));
  EXPECT_EQ(made.calibration.white_target->frames.size(), 4U);
  EXPECT_EQ(made.calibration.dark.size(), 2U);
  EXPECT_EQ(read_session(out).patterns[0].frames.size(), 5U);
}

TEST_F(Import, GrayCodesAreSortedByTheirNumbers) {
  const Image<float> light = smooth_scene(width, height, 3, 0.05, 2.0);
  const int frames = gray_code_frames(session.projector);
  fs::remove(path("plane_00_projected.png"));
  for (int k = 0; k < frames; ++k) {
    take("plane_0_gray_" + std::to_string(k) + ".png", light, {"1/5"});
  }
  fs::rename(path("plane_00_board.png"), path("plane_0_board.png"));
  import();
  const Session read = read_session(out);
  ASSERT_EQ(read.calibration.projector_planes.size(), 1U);
  EXPECT_FALSE(read.calibration.projector_planes[0].projected);
  EXPECT_FALSE(read.calibration.projected_board);
  const auto& code = read.calibration.projector_planes[0].gray_code;
  ASSERT_EQ(code.size(), static_cast<std::size_t>(frames));
  for (int k = 0; k < frames; ++k) {
    EXPECT_EQ(code[static_cast<std::size_t>(k)].file,
              "photographs/day_1/plane_0_gray_" + std::to_string(k) + ".png");
  }

  fs::remove(path("plane_0_gray_7.png"));
  fs::remove(out / "session.json");
  EXPECT_THAT(refusal(), HasSubstr("no photograph of frame plane_0_gray_7 of the Gray code (the "
                                   "projector's has 26, from 0); name it plane_0_gray_7 (any"));
}

TEST_F(Import, ProjectorLevelsAndRoomLightAreSortedByTheirNumbers) {
  const Image<float> light = smooth_scene(width, height, 3, 0.05, 2.0);
  for (const char* shot : {"level_128", "level_032", "off", "ambient_1", "ambient_00"}) {
    take(std::string(shot) + "_0.png", light, {"1/30"});
    take(std::string(shot) + "_1.png", light, {"1/5"});
  }
  import();
  const Calibration read = read_session(out).calibration;
  ASSERT_EQ(read.white_target->levels.size(), 2U);
  EXPECT_EQ(read.white_target->levels[0].value, 32);
  EXPECT_EQ(read.white_target->levels[1].frames[1].file, "photographs/day_1/level_128_1.png");
  EXPECT_EQ(read.white_target->off_frames.size(), 2U);
  ASSERT_EQ(read.ambient.size(), 2U);
  EXPECT_EQ(read.ambient[0][0].file, "photographs/day_1/ambient_00_0.png");
}

// Converters store 12-bit codes moved to the top of 16 bits, or scaled onto them; a plan says 12.
TEST_F(Import, DepthIsThatOfThePhotographs) {
  for (const auto& entry : fs::directory_iterator(photographs / "day_1")) {
    const std::string png = entry.path().string();
    Image<std::uint16_t> codes = io::read_code_image(png);
    const io::PhotoSettings exif = io::read_photo_settings(png);
    for (std::uint16_t& code : codes.values()) code = static_cast<std::uint16_t>(code << 4U);
    io::write_code_image(png, codes, 16);
    const auto per_mille = static_cast<int>(std::lround(1000.0 * *exif.exposure_s));
    write_exif(png, {(std::to_string(per_mille) + "/1000").c_str()});
  }
  EXPECT_THAT(warnings(), AllOf(HasSubstr("_2.png: its largest code is "),
                                HasSubstr(", while camera.bit_depth of " +
                                          (plan / "session.json").string() + " is 12; 16 bits")));
  EXPECT_EQ(read_session(out).camera.bit_depth, 16);
}

// Codes that end at 4095 saturate there, whatever the plan says: taken for light, they would be
// reported as wrong exposure times.
TEST_F(Import, DepthBelowThePlanIsFoundBySaturation) {
  session.camera.bit_depth = 16;
  write_session(session);
  const Image<float> bright = smooth_scene(width, height, 3, 0.05, 8.0);
  take("white_0.png", bright, {"1/30"});
  take("white_1.png", bright, {"1/5"});
  take("white_2.png", bright, {"1/2"});
  EXPECT_THAT(warnings(),
              HasSubstr("white_2.png: its largest code is 4095, while camera.bit_depth of"));
  EXPECT_EQ(read_session(out).camera.bit_depth, 12);
}

TEST_F(Import, AMissingExposureIsTold) {
  take("fit_02_0.png", smooth_scene(width, height, 3, 0.05, 2.0), {"1/30"});
  take("fit_02_1.png", smooth_scene(width, height, 3, 0.05, 2.0), {"1/5"});
  const std::string image = "patterns/fit_02.png";
  io::write_image(plan / image, Image<std::uint8_t>(64, 48, 1, 255));
  session.patterns.push_back({"fit_02", image, PatternRole::fit, {{"frames/planned.png", 1.0}}});
  write_session(session);
  EXPECT_THAT(
      warnings(),
      HasSubstr("pattern fit_02 has no photograph of 0.5 s, which most patterns have: add"));
  take("fit_02_2.png", smooth_scene(width, height, 3, 0.05, 2.0), {"1/2"});
  EXPECT_EQ(warnings().find("has no photograph"), std::string::npos);
}

TEST_F(Import, RefusesABlackPhotographOfALitStack) {
  take("fit_01_2.png", Image<float>(width, height, 3, 0.0F), {"1/2"});
  EXPECT_THAT(refusal(), AllOf(HasSubstr("fit_01_2.png: it is black where"),
                               HasSubstr("(pattern fit_01); photograph it again")));
}

TEST_F(Import, CopiesNothingWhereThePhotographsLieInTheSession) {
  out = photographs;
  import();
  EXPECT_EQ(read_session(out).patterns[0].frames[0].file, "day_1/fit_00_0.png");
  EXPECT_FALSE(fs::exists(out / "photographs"));
}

TEST_F(Import, RefusesAnotherAperture) {
  take("fit_01_1.png", smooth_scene(width, height, 3, 0.05, 2.0), {"1/5", "8/1"});
  EXPECT_THAT(refusal(), AllOf(StartsWith(path("fit_01_1.png") + ": aperture f/8, but "),
                               HasSubstr("and others have 5.6")));
}

TEST_F(Import, RefusesAnotherSensitivity) {
  take("board_01.png", smooth_scene(width, height, 3, 0.05, 2.0), {"1/5", "56/10", 400});
  EXPECT_THAT(refusal(), AllOf(StartsWith(path("board_01.png") + ": sensitivity ISO 400, but "),
                               HasSubstr("others have 100")));
}

TEST_F(Import, RefusesAnExposureThatDoesNotMatchItsBrightness) {
  write_exif(photographs / "day_1" / "fit_01_1.png", {"1/10"});  // in truth 1/5
  EXPECT_THAT(refusal(), AllOf(StartsWith((out / "photographs/day_1/fit_01_1.png").string()),
                               HasSubstr("fits an exposure time of 0.2"),
                               HasSubstr("not the 0.1 s stated"), HasSubstr("pattern fit_01")));
  EXPECT_FALSE(fs::exists(out / "session.json"));
}

TEST_F(Import, RefusesAPhotographOfNoShot) {
  take("holiday_0.png", smooth_scene(width, height, 3, 0.05, 2.0), {"1/5"});
  EXPECT_THAT(refusal(), AllOf(StartsWith(path("holiday_0.png") + ": 'holiday' is no shot")));
}

TEST_F(Import, RefusesAShotWithoutPhotographs) {
  fs::remove(path("dark_0.png"));
  EXPECT_THAT(refusal(), AllOf(StartsWith(photographs.string() + ": there is no photograph of the "
                                                                 "covered lens; name it dark_0")));
}

TEST_F(Import, RefusesAPhotographWithoutExposureTimeUnlessATableTellsIt) {
  // Written anew, without EXIF.
  const auto frames = shoot_stack(camera, smooth_scene(width, height, 3, 0.05, 2.0), {0.2}, 99);
  io::write_code_image(path("fit_00_1.png"), frames[0].pixels, 12);
  EXPECT_THAT(refusal(), AllOf(StartsWith(path("fit_00_1.png") + ": neither EXIF nor a table"),
                               HasSubstr("(table)")));
  write_table("fit_00_1.png", "1/5");
  EXPECT_NEAR(import().patterns[0].frames[1].exposure_s, 0.2, 1e-9);
}

TEST_F(Import, RefusesATableThatListsAFrameTwice) {
  write_table("fit_00_1.png", "1/5");
  std::ofstream(*table, std::ios::app) << "day_1/./fit_00_1.png,fit_00,0.4\n";
  EXPECT_THAT(refusal(), HasSubstr("for 'fit_00' once more"));
}

TEST_F(Import, TheTableOverridesExifWithAWarning) {
  write_exif(path("fit_00_1.png"), {"1/2"});  // in truth 1/5
  write_table("fit_00_1.png", "0.2");
  EXPECT_THAT(warnings(), HasSubstr(path("fit_00_1.png") +
                                    ": the table says 0.2 s, EXIF says 0.5 s; the table is taken"));
  EXPECT_NEAR(read_session(out).patterns[0].frames[1].exposure_s, 0.2, 1e-9);
}

TEST_F(Import, ATableNamesPlainShots) {
  // Longer than the stack is deep.
  table = folder.path() / "shots.csv";
  write_text(*table, "file,shot\nday_1/fit_00_1.png,plane_1" + std::string(2'000'000, 'x') + "\n");
  EXPECT_THAT(refusal(), AllOf(HasSubstr("line 2: the shot is 'plane_1xxx"), HasSubstr("use ")));
}

TEST_F(Import, HiddenFilesAndSystemFoldersAreNoPhotographs) {
  for (const char* name : {"._fit_00_0.png", ".thumbnails/fit_00_0.png", "@eaDir/a/fit_00_0.png",
                           "Thumbs.db", "desktop.ini"}) {
    fs::create_directories((photographs / name).parent_path());
    write_text(photographs / name, "no picture");
  }
  fs::create_directories(photographs / "day_1" / "__MACOSX");
  fs::copy_file(path("dark_0.png"), photographs / "day_1" / "__MACOSX" / "fit_00_0.png");
  EXPECT_THAT(warnings(), HasSubstr(": 6 hidden files and folders are ignored."));
  EXPECT_EQ(read_session(out).patterns[0].frames.size(), 3U);
}

TEST_F(Import, LinkedPhotographsAreReadOnceAndLinksThatLeadNowhereAreNamed) {
  // A folder behind a link is read like others, and so is a photograph.
  const fs::path store = photographs / ".store";
  fs::rename(photographs / "day_1", store);
  fs::create_directory_symlink(".store", photographs / "day_1");
  fs::rename(store / "fit_00_0.png", photographs / ".frame.png");
  fs::create_symlink("../.frame.png", store / "fit_00_0.png");
  EXPECT_EQ(import().patterns[0].frames.size(), 3U);
  fs::remove_all(out);
  fs::create_symlink("white_0.png", path("white_9.png"));
  EXPECT_THAT(refusal(), HasSubstr("is read already as"));
  fs::remove(path("white_9.png"));
  for (const auto& [target, sentence] :
       {std::pair{"..", "is read already as"}, std::pair{"../..", "behind a link out of"},
        std::pair{"nothing", "leads nowhere"}, std::pair{"link", "leads nowhere"}}) {
    fs::create_directory_symlink(target, path("link"));
    EXPECT_THAT(refusal(), HasSubstr(sentence)) << target;
    fs::remove(path("link"));
  }
}

TEST_F(Import, AFolderNamedPatternsHoldsPhotographsToo) {
  fs::create_directories(photographs / "patterns");
  for (const char* name : {"fit_00_0.png", "fit_00_1.png", "fit_00_2.png"}) {
    fs::rename(path(name), photographs / "patterns" / name);
  }
  // What the projector showed is none.
  fs::copy_file(plan / "patterns/fit_00.png", photographs / "patterns/fit_00.png");
  EXPECT_EQ(import().patterns[0].frames[2].file, "photographs/patterns/fit_00_2.png");
}

TEST_F(Import, APatternInColourOrOfAnotherSizeIsRefused) {
  io::write_image(plan / "patterns/fit_01.png", Image<std::uint8_t>(64, 48, 3, 255));
  EXPECT_THAT(refusal(), AllOf(HasSubstr("fit_01.png: the pattern is 64 x 48 with 3 channels"),
                               HasSubstr("grey 8-bit PNG")));
  io::write_image(plan / "patterns/fit_01.png", Image<std::uint8_t>(32, 48, 1, 255));
  EXPECT_THAT(refusal(), HasSubstr("fit_01.png: the pattern is 32 x 48"));
}

// A frame of another size: no session.json is there yet to blame.
TEST_F(Import, APreviewAmongThePhotographsIsNamed) {
  io::write_code_image(path("fit_01_1.png"), Image<std::uint16_t>(16, 12, 3, 500), 12);
  write_exif(path("fit_01_1.png"), {"1/5"});
  EXPECT_THAT(refusal(), AllOf(HasSubstr("fit_01_1.png: the frame is 16 x 12 pixels"),
                               testing::Not(HasSubstr("session.json"))));
}

class ImportOrientation : public Import, public testing::WithParamInterface<int> {};

// The camera's own frames and the upright ones are the same pixels.
TEST_P(ImportOrientation, IsAppliedToAllFramesWhereTheyAgree) {
  const int tag = GetParam();
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(photographs / "day_1")) {
    files.push_back(entry.path());
  }
  for (const fs::path& file : files) {
    const double seconds = *io::read_photo_settings(file).exposure_s;
    const std::string exposure = std::to_string(std::lround(seconds * 3e6)) + "/3000000";
    write_exif(file, {exposure.c_str(), "56/10", 100, tag});
  }
  EXPECT_THAT(warnings(), AllOf(HasSubstr("EXIF orientation " + std::to_string(tag)),
                                HasSubstr("set the orientation to apply")));
  const Session stored = read_session(out);
  EXPECT_THAT(warnings(Orientation::ignore), testing::Not(HasSubstr("orientation")));
  EXPECT_THAT(warnings(Orientation::apply), testing::Not(HasSubstr("orientation")));
  const Session upright = read_session(out);
  EXPECT_EQ(upright.camera.orientation, tag);
  EXPECT_EQ(upright.camera.width, io::swaps_sides(tag) ? height : width);
  for (const auto& [before, after] :
       {std::pair(stored.patterns[1].frames[1], upright.patterns[1].frames[1]),
        std::pair(stored.calibration.camera_boards[0], upright.calibration.camera_boards[0]),
        std::pair(stored.calibration.dark[0], upright.calibration.dark[0])}) {
    EXPECT_EQ(load_frame(upright, after).values(),
              io::turned(load_frame(stored, before), tag).values());
  }
}

// A bracket and boards without a session: as import.
TEST_P(ImportOrientation, IsSettledWithoutASessionToo) {
  const int tag = GetParam();
  const fs::path stack = folder.path() / "stack";
  fs::create_directories(stack);
  for (const char* name : {"fit_00_0.png", "fit_00_1.png"}) {
    fs::copy_file(path(name), stack / name);
    write_exif(stack / name, {name[7] == '0' ? "1/30" : "1/5", "56/10", 100, tag});
  }
  PhotographSource source{stack, {}};
  for (const bool boards : {false, true}) {
    const auto session_by = [&](std::optional<Orientation> wish) {
      Listener listener;
      source.orientation = wish;
      Session found = boards ? board_session(source, session.calibration.board, {}, listener)
                             : bracket_session(source, Encoding::linear, listener);
      return std::pair(std::move(found), listener.text);
    };
    EXPECT_THAT(session_by({}).second, HasSubstr("set the orientation to apply"));
    const auto [stored, silence] = session_by(Orientation::ignore);
    const auto [upright, still] = session_by(Orientation::apply);
    EXPECT_THAT(silence + still, testing::Not(HasSubstr("orientation")));
    EXPECT_FALSE(stored.camera.orientation);
    EXPECT_EQ(upright.camera.orientation, tag);
    const auto frame = [&](const Session& one) {
      return boards ? one.calibration.camera_boards[0] : one.patterns[0].frames[0];
    };
    EXPECT_EQ(load_frame(upright, frame(upright)).values(),
              io::turned(load_frame(stored, frame(stored)), tag).values());
  }
}

INSTANTIATE_TEST_SUITE_P(Tags, ImportOrientation, testing::Values(2, 3, 6, 8));

TEST_F(Import, OrientationsThatDifferAreIgnored) {
  write_exif(path("fit_01_1.png"), {"1/5", "56/10", 100, 6});
  EXPECT_THAT(warnings(), HasSubstr("orientations are ignored"));
  EXPECT_FALSE(read_session(out).camera.orientation);
  EXPECT_THAT(sentence_of([&] { warnings(Orientation::apply); }),
              HasSubstr("only where all photographs have the same"));
}

}  // namespace
}  // namespace kappamu::capture

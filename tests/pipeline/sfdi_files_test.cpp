// Pictures of sfdi.json as instruments leave them: folders of frames, stacks, names by rule,
// repeated, already demodulated, already divided.
#include <gtest/gtest.h>
#include <matio.h>

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <numbers>
#include <string>
#include <utility>

#include "io/npy.h"
#include "pipeline/sfdi/picture_names.h"
#include "pipeline/sfdi/sfdi_map.h"
#include "tests/io/image/plain_tiff.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::pipeline::sfdi {
namespace {

constexpr std::size_t extent = 64;
constexpr double step_mm = 0.3, wave_per_mm = 0.2, full = 500.0;
constexpr double phantom_mua = 0.02, phantom_musp = 1.0, tissue_mua = 0.035, tissue_musp = 1.4;

double reflectance(bool sample, double frequency) {
  const forward::LateralReflectance model({1.4, 0.9, {}});
  return model(frequency, sample ? tissue_mua : phantom_mua, sample ? tissue_musp : phantom_musp)
      .reflectance;
}

std::vector<float> picture(const std::function<double(double)>& of_x) {
  std::vector<float> values;
  for (std::size_t y = 0; y < extent; ++y) {
    for (std::size_t x = 0; x < extent; ++x) {
      values.push_back(static_cast<float>(of_x(step_mm * static_cast<double>(x))));
    }
  }
  return values;
}

std::vector<float> lit(bool sample, double degrees, double frequency = wave_per_mm) {
  const double even = full * reflectance(sample, 0.0);
  const double wave = frequency > 0.0 ? full * reflectance(sample, frequency) : 0.0;
  return picture([&](double x) {
    return even + wave * std::cos(2.0 * std::numbers::pi * (frequency * x + degrees / 360.0));
  });
}

std::vector<float> constant(double value) {
  return picture([&](double) { return value; });
}

class SfdiFiles : public testing::Test {
 protected:
  void write(const std::string& name, const std::vector<float>& values) {
    std::filesystem::create_directories((folder_ / name).parent_path());
    io::write_npy(folder_ / name, {extent, extent}, std::span<const float>(values));
  }
  Maps map(const std::string& fields, bool phantom = true) {
    const std::string scale = phantom ? R"("reference": {"coefficients": [{"wavelength_nm": 700,
                     "absorption_per_mm": 0.02, "reduced_scattering_per_mm": 1.0}]})"
                                      : R"("codes_per_reflectance": 500)";
    std::ofstream(folder_ / file_name)
        << R"({"format": "kappamu-sfdi", "version": 1, "pixel_mm": 0.3, "smoothing_mm": 0,
               "medium": {"refractive_index": 1.4, "anisotropy": 0.9}, )"
        << scale << ", " << fields << "}";
    Progress quiet;
    return measure_maps(read_description(folder_), quiet);
  }
  void expect_tissue(const Maps& maps, const std::string& which) {
    const WavelengthMap& m = maps.wavelengths.front();
    EXPECT_NEAR(m.mua(30, 30) / tissue_mua, 1.0, 2e-3) << which;
    EXPECT_NEAR(m.musp(30, 30) / tissue_musp, 1.0, 2e-3) << which;
  }
  std::string refusal(const std::string& fields) {
    return sentence_of([&] { map(fields); });
  }

  OwnFolder folder_;
};

TEST_F(SfdiFiles, FoldersStacksAndRepeatsArePictures) {
  // Twelve frames of a video, four of each phase, numbered without leading zeros; the lamp flickers
  // from frame to frame, and comes back to its mean over four.
  constexpr std::array<double, 4> flicker{0.99, 1.01, 1.02, 0.98};
  for (const bool sample : {true, false}) {
    std::vector<float> stack;
    for (std::size_t i = 0; i < 12; ++i) {
      std::vector<float> frame = lit(sample, 120.0 * static_cast<double>(i / 4));
      for (float& value : frame) value *= static_cast<float>(flicker[i % 4]);
      write((sample ? "tissue/frame" : "phantom/frame") + std::to_string(i + 5) + ".npy", frame);
    }
    for (const double degrees : {0.0, 120.0, 240.0}) {
      const std::vector<float> one = lit(sample, degrees);
      stack.insert(stack.end(), one.begin(), one.end());
    }
    io::write_npy(folder_ / (sample ? "tissue.npy" : "phantom.npy"), {3, extent, extent},
                  std::span<const float>(stack));
  }
  expect_tissue(map(R"("measurements": [{"wavelength_nm": 700, "per_mm": 0.2, "repeats": 4,
                       "sample": ["tissue"], "reference": ["phantom"]}])"),
                "folders");
  const std::string stacks = R"("measurements": [{"wavelength_nm": 700, "per_mm": 0.2,
                                "sample": ["tissue.npy"], "reference": ["phantom.npy"]}])";
  expect_tissue(map(stacks), "stacks");
  expect_tissue(map(R"("measurements": [{"wavelength_nm": 700, "per_mm": 0.2,
                       "phases_degrees": [240, 0, 120],
                       "sample": ["tissue.npy:2", "tissue.npy:0", "tissue.npy:1"],
                       "reference": ["phantom.npy:2", "phantom.npy:0", "phantom.npy:1"]}])"),
                "pages");
  EXPECT_EQ(pictures_named(folder_, "tissue").front(), "tissue/frame5.npy");
  EXPECT_EQ(pictures_named(folder_, "tissue").back(), "tissue/frame16.npy");
  EXPECT_NE(sentence_of([&] { PictureReader().read(folder_, "tissue.npy:3"); }).find("no page 3"),
            std::string::npos);
  EXPECT_NE(refusal(R"("measurements": [{"wavelength_nm": 700, "per_mm": 0.2, "repeats": 5,
                       "sample": ["tissue"], "reference": ["phantom"]}])")
                .find("has 12 pictures, no multiple of repeats, 5"),
            std::string::npos);
}

/// What this process has read from files [bytes].
std::size_t bytes_read() {
  std::ifstream counts("/proc/self/io");
  std::string name;
  std::size_t bytes = 0;
  counts >> name >> bytes;
  return bytes;
}

TEST_F(SfdiFiles, StacksAreReadOnce) {
  constexpr int pages = 40;
  std::vector<float> stack;
  std::vector<io::Page> tiff;
  for (int page = 0; page < pages; ++page) {
    const std::vector<float> one = constant(page);
    stack.insert(stack.end(), one.begin(), one.end());
    io::Page& added = tiff.emplace_back();
    added.width = added.height = extent;
    for (std::size_t i = 0; i < extent * extent; ++i) io::put_number(added.pixels, page, 2);
  }
  io::write_npy(folder_ / "stack.npy", {pages, extent, extent}, std::span<const float>(stack));
  std::ofstream(folder_ / "stack.tif") << io::tiff(tiff);
  for (const char* name : {"stack.npy", "stack.tif"}) {
    const std::vector<std::string> names = pictures_named(folder_, name);
    ASSERT_EQ(names.size(), pages);
    PictureReader reader;
    const std::size_t before = bytes_read();
    for (int page = 0; page < pages; ++page)
      EXPECT_EQ(reader.read(folder_, names[static_cast<std::size_t>(page)])(1, 1), page) << name;
    const auto read = static_cast<double>(bytes_read() - before);
    // Headers and buffers come with each page; whole files would be `pages` times the size.
    EXPECT_LT(read, 5.0 * static_cast<double>(std::filesystem::file_size(folder_ / name))) << name;
  }
}

TEST_F(SfdiFiles, AmbiguousFoldersAreRefused) {
  const auto refused = [&](const std::string& name, const std::string& part) {
    const std::string sentence = sentence_of([&] { pictures_named(folder_, name); });
    EXPECT_NE(sentence.find(part), std::string::npos) << sentence;
    EXPECT_NE(sentence.find(folder_.path().string()), std::string::npos) << sentence;
  };
  for (const char* name : {"gap/1.npy", "gap/2.npy", "gap/4.npy", "twice/a1.npy", "twice/b01.npy",
                           "none/first.npy", "two/1.npy"}) {
    write(name, constant(1.0));
  }
  std::ofstream(folder_ / "two/2.png") << "not read";
  std::ofstream(folder_ / "two/notes 3.txt") << "not a picture";
  std::filesystem::create_directory(folder_ / "empty");
  refused("gap", "frame 3 is missing between 1 and 4");
  refused("twice", "have the same number");
  refused("none", "has no number");
  refused("two", "holds pictures that end in");
  refused("empty", "holds no picture");
}

TEST_F(SfdiFiles, NamesByRuleAreASeries) {
  // As instruments number them, even light in all of the phases.
  for (const bool sample : {true, false}) {
    const std::string object = sample ? "tissue/" : "phantom/";
    for (int phase = 0; phase < 3; ++phase) {
      write(object + "L0F0P" + std::to_string(phase) + ".npy", lit(sample, 0.0, 0.0));
      write(object + "L0F1P" + std::to_string(phase) + ".npy", lit(sample, 120.0 * phase));
      write(object + "700nm_0.2_00" + std::to_string(phase + 1) + ".npy",
            lit(sample, 120.0 * phase));
    }
  }
  expect_tissue(map(R"("series": {"sample": "tissue/L{wavelength}F{frequency}P{phase}.npy",
                       "reference": "phantom/L{wavelength}F{frequency}P{phase}.npy",
                       "wavelengths_nm": [700], "per_mm": [0, 0.2],
                       "phases_degrees": [0, 120, 240]})"),
                "numbers");
  expect_tissue(map(R"("series": {"sample": "tissue/{wavelength_nm}nm_{per_mm}_{phase:3}.npy",
             "reference": "phantom/{wavelength_nm}nm_{per_mm}_{phase:3}.npy", "first_number": 1,
             "wavelengths_nm": [700], "per_mm": [0.2], "phases_degrees": [0, 120, 240]})"),
                "values");
  EXPECT_NE(refusal(R"("series": {"sample": "tissue/F{frequency}P{phase}.npy",
                       "wavelengths_nm": [700, 800], "per_mm": [0.2],
                       "phases_degrees": [0, 120, 240]})")
                .find("put {wavelength} or {wavelength_nm} into the name"),
            std::string::npos);
  EXPECT_NE(refusal(R"("series": {"sample": "tissue/{lambda}.npy", "wavelengths_nm": [700],
                       "per_mm": [0.2]})")
                .find("series.sample has '{lambda}'"),
            std::string::npos);
}

/// 8 bits with a palette of greys, rows bottom-up.
std::string grey_bmp(const std::vector<float>& values) {
  constexpr unsigned size = extent, begin = 54 + 4 * 256;
  constexpr double code = 255.0 / full;
  static_assert(size % 4 == 0, "rows of a BMP are padded to four bytes");
  std::string bytes = "BM";
  for (const auto& [number, count] :
       std::initializer_list<std::pair<unsigned, int>>{{begin + size * size, 4},
                                                       {0, 4},
                                                       {begin, 4},
                                                       {40, 4},
                                                       {size, 4},
                                                       {size, 4},
                                                       {1, 2},
                                                       {8, 2},
                                                       {0, 4},
                                                       {size * size, 4},
                                                       {2835, 4},
                                                       {2835, 4},
                                                       {256, 4},
                                                       {0, 4}}) {
    io::put_number(bytes, number, count);
  }
  for (unsigned i = 0; i < 256; ++i) io::put_number(bytes, i * 0x010101U, 4);
  for (std::size_t y = extent; y-- > 0;) {
    for (std::size_t x = 0; x < extent; ++x) {
      bytes += static_cast<char>(std::lround(code * values[y * extent + x]));
    }
  }
  return bytes;
}

TEST_F(SfdiFiles, BitmapsByTheirNumbersAsOpenSfdiInstrumentsLeaveThem) {
  // <time>_<name>_<exposure>ms/im_<wavelength>-<frequency>-<phase>.bmp, even light in all phases.
  for (const bool sample : {true, false}) {
    const std::filesystem::path folder =
        folder_ / (sample ? "1561366800_tissue_100ms" : "1561366900_phantom_100ms");
    std::filesystem::create_directories(folder);
    for (int frequency = 0; frequency < 2; ++frequency) {
      for (int phase = 0; phase < 3; ++phase) {
        std::ofstream(folder /
                      ("im_0-" + std::to_string(frequency) + "-" + std::to_string(phase) + ".bmp"))
            << grey_bmp(lit(sample, frequency == 0 ? 0.0 : 120.0 * phase, wave_per_mm * frequency));
      }
    }
  }
  const Maps maps = map(R"("series": {
      "sample": "1561366800_tissue_100ms/im_{wavelength}-{frequency}-{phase}.bmp",
      "reference": "1561366900_phantom_100ms/im_{wavelength}-{frequency}-{phase}.bmp",
      "wavelengths_nm": [700], "per_mm": [0, 0.2], "phases_degrees": [0, 120, 240]})");
  // Codes of 8 bits are rounded by 0.3 % here.
  EXPECT_NEAR(maps.wavelengths.front().mua(30, 30) / tissue_mua, 1.0, 0.03);
  EXPECT_NEAR(maps.wavelengths.front().musp(30, 30) / tissue_musp, 1.0, 0.03);
}

TEST_F(SfdiFiles, SevenPhasesInAVariableAsAppSfdisExamplesAre) {
  // PH7_<object>_0_2.mat: mesdata [row][column][1][phase] at 0, 90, ... 540 degrees.
  for (const bool sample : {true, false}) {
    for (const double frequency : {0.0, 0.2}) {
      std::vector<float> pages;
      for (int phase = 0; phase < 7; ++phase) {
        const std::vector<float> one = lit(sample, frequency > 0.0 ? 90.0 * phase : 0.0, frequency);
        for (std::size_t x = 0; x < extent; ++x) {
          for (std::size_t y = 0; y < extent; ++y) pages.push_back(one[y * extent + x]);
        }
      }
      const std::string name = std::string("PH7_") + (sample ? "hand" : "calibration") +
                               (frequency > 0.0 ? "_0_2.mat" : "_0_0.mat");
      mat_t* const mat = Mat_CreateVer((folder_ / name).c_str(), nullptr, MAT_FT_MAT5);
      std::array<std::size_t, 4> shape{extent, extent, 1, 7};
      matvar_t* const variable =
          Mat_VarCreate("mesdata", MAT_C_SINGLE, MAT_T_SINGLE, 4, shape.data(), pages.data(), 0);
      ASSERT_EQ(Mat_VarWrite(mat, variable, MAT_COMPRESSION_NONE), 0);
      Mat_VarFree(variable);
      Mat_Close(mat);
    }
  }
  expect_tissue(map(R"("measurements": [
      {"wavelength_nm": 700, "per_mm": 0, "sample": ["PH7_hand_0_0.mat"],
       "reference": ["PH7_calibration_0_0.mat"]},
      {"wavelength_nm": 700, "per_mm": 0.2, "phases_degrees": [0, 90, 180, 270, 360, 450, 540],
       "sample": ["PH7_hand_0_2.mat:mesdata"], "reference": ["PH7_calibration_0_2.mat:mesdata"]}])"),
                "seven phases");
}

TEST_F(SfdiFiles, AVideoIsRefusedWithWhatToDo) {
  std::ofstream(folder_ / "tissue.avi") << "RIFF";
  EXPECT_NE(refusal(R"("measurements": [{"wavelength_nm": 700, "per_mm": 0.2, "sample":
                       ["tissue.avi"], "reference": ["tissue.avi"]}])")
                .find("tissue.avi: is a video; let a program such as ffmpeg write its frames"),
            std::string::npos);
}

TEST_F(SfdiFiles, DemodulatedPicturesAndRatiosNeedNoPhases) {
  for (const bool sample : {true, false}) {
    const std::string object = sample ? "tissue_" : "phantom_";
    write(object + "dc.npy", constant(full * reflectance(sample, 0.0)));
    write(object + "ac.npy", constant(full * reflectance(sample, wave_per_mm)));
  }
  write("ratio_dc.npy", constant(reflectance(true, 0.0) / reflectance(false, 0.0)));
  write("ratio_ac.npy", constant(reflectance(true, wave_per_mm) / reflectance(false, wave_per_mm)));
  const auto two = [](const std::string& sample, const std::string& reference,
                      const std::string& content) {
    std::string text = R"("measurements": [)";
    for (const std::string part : {"dc", "ac"}) {
      text += R"({"wavelength_nm": 700, "per_mm": )" + std::string(part == "dc" ? "0" : "0.2") +
              R"(, "content": ")" + content + R"(", "sample": [")" + sample + part + R"(.npy"])";
      if (!reference.empty()) text += R"(, "reference": [")" + reference + part + R"(.npy"])";
      text += part == "dc" ? "}, " : "}]";
    }
    return text;
  };
  expect_tissue(map(two("tissue_", "phantom_", "demodulated")), "demodulated");
  expect_tissue(map(two("tissue_", "", "demodulated"), false), "reflectance");
  expect_tissue(map(two("ratio_", "", "ratio")), "ratio");
  EXPECT_NE(refusal(two("ratio_", "phantom_", "ratio")).find("is divided already"),
            std::string::npos);
  EXPECT_NE(refusal(R"("measurements": [{"wavelength_nm": 700, "per_mm": 0.2, "content": "ratio",
                       "sample": ["ratio_ac.npy"]}])")
                .find("demodulated pictures have no mean; add even light"),
            std::string::npos);
}

}  // namespace
}  // namespace kappamu::pipeline::sfdi

#include "io/measurements_file.h"

#include <regex>

#include "io/npy.h"
#include "tests/io/support.h"
#include "tests/reference_data.h"

namespace kappamu::io {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A small measurement with different extents everywhere: lit z- is 3 x 2, seen x+ is [z][y] 4 x 2.
SurfaceMeasurements example() {
  SurfaceMeasurements m;
  m.grid = {3, 2, 4, 0.1};
  m.eta = 1.45;
  m.seen_face = Face::x_plus;
  m.quantity = Quantity::radiance_normal;
  m.light = Light::diffuse;
  m.sides = Sides::mirror;
  m.smooth_error = {3e-4, 1e-4};
  m.channels = {"R", "G"};
  m.patterns = 3;
  for (std::size_t i = 0; i < 18; ++i) m.irradiance.push_back(static_cast<float>(i) * 0.3F);
  for (std::size_t i = 0; i < 48; ++i) {
    m.value.push_back(static_cast<float>(i) * 0.7F - 3.0F);
    m.variance.push_back(1e-6F * static_cast<float>(i + 1));
    m.mask.push_back(i % 3 == 0 ? 0 : 1);
  }
  return m;
}

class MeasurementsFile : public FolderTest {
 protected:
  void SetUp() override { write_measurements(folder_, example()); }
  /// The sentence that reading gives after one replacement in measurements.json.
  std::string after(const std::string& pattern, const std::string& replacement) {
    const std::string text = read_text(folder_ / "measurements.json");
    const std::string changed = std::regex_replace(text, std::regex(pattern), replacement);
    EXPECT_NE(text, changed) << pattern;
    write_text_atomically(folder_ / "measurements.json", changed);
    std::string sentence = sentence_of([&] { read_measurements(folder_); });
    write_text_atomically(folder_ / "measurements.json", text);
    EXPECT_THAT(sentence, HasSubstr("measurements.json"));
    return sentence;
  }
};

TEST_F(MeasurementsFile, EverythingComesBack) {
  const SurfaceMeasurements m = example();
  const SurfaceMeasurements back = read_measurements(folder_);
  EXPECT_EQ(back.grid, m.grid);
  EXPECT_EQ(back.eta, m.eta);
  EXPECT_EQ(back.lit_face, m.lit_face);
  EXPECT_EQ(back.seen_face, m.seen_face);
  EXPECT_EQ(back.quantity, m.quantity);
  EXPECT_EQ(back.light, m.light);
  EXPECT_EQ(back.sides, m.sides);
  EXPECT_EQ(back.channels, m.channels);
  EXPECT_EQ(back.patterns, m.patterns);
  EXPECT_EQ(back.irradiance, m.irradiance);
  EXPECT_EQ(back.value, m.value);
  EXPECT_EQ(back.variance, m.variance);
  EXPECT_EQ(back.mask, m.mask);
  EXPECT_EQ(back.smooth_error, m.smooth_error);
}

TEST_F(MeasurementsFile, NoSmoothErrorIsNone) {
  SurfaceMeasurements m = example();
  m.smooth_error = {};
  write_measurements(folder_, m);
  EXPECT_TRUE(read_measurements(folder_).smooth_error.none());
}

// For the reader of the file: it is not read back.
TEST_F(MeasurementsFile, SourceOfSmoothErrorIsWritten) {
  write_measurements(folder_, example(), "stated by the session");
  const std::string text = read_text(folder_ / "measurements.json");
  EXPECT_THAT(text, HasSubstr("\"source\": \"stated by the session\""));
  EXPECT_EQ(read_measurements(folder_).smooth_error, example().smooth_error);
}

TEST_F(MeasurementsFile, ArraysHaveTheDocumentedShapes) {
  using testing::ElementsAre;
  EXPECT_THAT(read_npy(folder_ / "irradiance.npy").shape, ElementsAre(3, 2, 3));
  EXPECT_THAT(read_npy(folder_ / "value.npy").shape, ElementsAre(2, 3, 4, 2));
  EXPECT_THAT(read_npy(folder_ / "variance.npy").shape, ElementsAre(2, 3, 4, 2));
  EXPECT_THAT(read_npy(folder_ / "mask.npy").shape, ElementsAre(2, 3, 4, 2));
}

TEST_F(MeasurementsFile, AMaskOfAnOlderMeasurementDoesNotSurvive) {
  SurfaceMeasurements m = example();
  m.mask.clear();
  write_measurements(folder_, m);
  EXPECT_FALSE(fs::exists(folder_ / "mask.npy"));
  EXPECT_TRUE(read_measurements(folder_).mask.empty());
}

TEST_F(MeasurementsFile, TwoFacesComeBack) {
  SurfaceMeasurements m = example();
  m.seen_faces = {Face::x_plus, Face::x_minus, Face::x_minus};
  write_measurements(folder_, m);
  const SurfaceMeasurements back = read_measurements(folder_);
  EXPECT_EQ(back.seen_face, Face::x_plus);
  EXPECT_EQ(back.seen_faces, m.seen_faces);
  EXPECT_EQ(back.seen_on(1), Face::x_minus);
  const auto sentence = [&](const std::vector<Face>& faces) {
    m.seen_faces = faces;
    return sentence_of([&] { validate(m, "here"); });
  };
  EXPECT_THAT(sentence({Face::x_plus, Face::x_minus}),
              HasSubstr("seen_faces lists 2 faces for 3 patterns"));
  EXPECT_THAT(sentence({Face::x_minus, Face::x_plus, Face::x_plus}),
              HasSubstr("seen_faces begins with x-, and seen_face is x+"));
  EXPECT_THAT(sentence({Face::x_plus, Face::x_minus, Face::z_minus}),
              HasSubstr("seen_faces lists z- beside x+"));
}

TEST_F(MeasurementsFile, WrongFieldsAreNamed) {
  EXPECT_THAT(after("\"eta\"", "\"etta\""), HasSubstr("etta is an unknown field"));
  EXPECT_THAT(after("\"eta\": [0-9.]+,", ""), HasSubstr("eta is missing"));
  EXPECT_THAT(after("\"eta\": [0-9.]+", "\"eta\": \"1.3\""),
              HasSubstr("eta is a text; write a number"));
  EXPECT_THAT(after("kappamu-measurements", "kappamu-session"),
              HasSubstr("format is 'kappamu-session'; write 'kappamu-measurements'"));
  EXPECT_THAT(after("\"version\": 1", "\"version\": 2"), HasSubstr("version is not 1"));
  EXPECT_THAT(after("\"z-\"", "\"top\""), HasSubstr("lit_face is wrong: face 'top' is not one of"));
  EXPECT_THAT(after("radiance_normal", "flux"), HasSubstr("quantity is wrong: quantity 'flux'"));
  EXPECT_THAT(after("\"R\"", "\"G\""), HasSubstr("channels names 'G' twice"));
  EXPECT_THAT(after("\"R\"", "3"), HasSubstr("channels[0] is 3; write a text"));
  EXPECT_THAT(after("3,\\s+2,\\s+4", "3, 2"), HasSubstr("grid has 2 entries; it needs exactly 3"));
  EXPECT_THAT(after("3,\\s+2,\\s+4", "3, 2.5, 4"),
              HasSubstr("grid[1] is 2.5; write a whole number"));
  EXPECT_THAT(after("\"common\"", "\"shared\""),
              HasSubstr("smooth_error.shared is an unknown field"));
  EXPECT_THAT(after("\\}\\s*$", ""), HasSubstr("not valid JSON ("));
}

TEST_F(MeasurementsFile, WrongArraysAreNamed) {
  write_npy(folder_ / "value.npy", {2, 3, 2, 4}, std::span<const float>(example().value));
  EXPECT_THAT(sentence_of([&] { read_measurements(folder_); }),
              HasSubstr("value.npy: array has shape [2][3][2][4] instead of [2][3][4][2]"));
  write_measurements(folder_, example());
  write_npy(folder_ / "irradiance.npy", {3, 3, 2}, std::span<const float>(example().irradiance));
  EXPECT_THAT(sentence_of([&] { read_measurements(folder_); }),
              HasSubstr("irradiance.npy: array has shape [3][3][2] instead of [patterns][2][3]"));
  write_measurements(folder_, example());
  std::vector<float> mask(48, 1.0F);
  mask[5] = 0.5F;
  write_npy(folder_ / "mask.npy", {2, 3, 4, 2}, std::span<const float>(mask));
  EXPECT_THAT(sentence_of([&] { read_measurements(folder_); }),
              HasSubstr("mask.npy: values must be 0 or 1"));
}

TEST_F(MeasurementsFile, ContentIsValidated) {
  std::vector<float> variance = example().variance;
  variance[1] = 0.0F;
  write_npy(folder_ / "variance.npy", {2, 3, 4, 2}, std::span<const float>(variance));
  EXPECT_THAT(sentence_of([&] { read_measurements(folder_); }),
              HasSubstr("variance must be positive and finite"));
  SurfaceMeasurements m = example();
  m.eta = 0.0;
  EXPECT_THAT(sentence_of([&] { write_measurements(folder_, m); }), HasSubstr("eta must lie"));
  m = example();
  m.smooth_error.own = -1e-4;
  EXPECT_THAT(sentence_of([&] { write_measurements(folder_, m); }),
              HasSubstr("smooth_error must lie between 0 and 1"));
}

TEST(MeasurementsReference, AnIndependentCodesFolderIsRead) {
  const fs::path folder = reference_data("transport-reference") / "block-32x32x10" / "measurements";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const SurfaceMeasurements m = read_measurements(folder);
  EXPECT_EQ(m.grid, (GridShape{32, 32, 10, 0.5}));
  EXPECT_EQ(m.patterns, 16);
  EXPECT_THAT(m.channels, testing::ElementsAre("grey"));
  EXPECT_EQ(m.value.size(), 16U * 32 * 32);
  EXPECT_TRUE(m.mask.empty());
}

// Names become parts of paths: nothing but a plain name is read.
TEST_F(MeasurementsFile, ChannelThatIsNoPlainNameIsRefused) {
  for (const char* name : {"a/../../../outside/pwn", "/etc/pwn", "..", ".hidden", "R G", "",
                           "R\\\\u0000", "R\\\\n", "é"}) {
    const std::string sentence = after("\"R\"", "\"" + std::string(name) + "\"");
    EXPECT_THAT(sentence, HasSubstr("channels[0] is '"));
    EXPECT_THAT(sentence, HasSubstr("use letters, digits, '_', '-' and '.'"));
  }
  EXPECT_THAT(after("\"R\"", "\"" + std::string(101, 'a') + "\""), HasSubstr("at most 100"));
  SurfaceMeasurements m = example();
  m.channels[0] = "a/b";
  EXPECT_THAT(sentence_of([&] { write_measurements(folder_ / "other", m); }),
              HasSubstr("is 'a/b'"));
  EXPECT_FALSE(fs::exists(folder_ / "other"));
}

}  // namespace
}  // namespace kappamu::io

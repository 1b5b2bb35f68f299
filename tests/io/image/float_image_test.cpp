// Light from EXR and Radiance pictures as other programs write them: read right, or refused with
// the reason.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/image/exr.h"
#include "io/image/image_file.h"
#include "io/image/orientation.h"
#include "tests/io/image/plain_exr.h"
#include "tests/io/support.h"

namespace kappamu::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

using Channels = std::vector<PlainExr::Channel>;
const Channels rgb{{"R", 1.0F}, {"G", 2.0F}, {"B", 3.0F}};

Channels layer(const std::string& name, float red) {
  return {{name + ".R", red}, {name + ".G", 2.0F}, {name + ".B", 3.0F}};
}

Channels operator+(Channels a, const Channels& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class FloatImage : public FolderTest {
 protected:
  Image<float> read(const std::vector<PlainExr>& parts) {
    write_text_atomically(folder_ / "a.exr", plain_exr(parts));
    return read_float_image(folder_ / "a.exr", {}, Primaries::srgb);
  }
  std::string refusal(const std::vector<PlainExr>& parts) {
    return sentence_of([&] { read(parts); });
  }
  Image<float> read_hdr(const std::string& header, const std::string& resolution) {
    // Two rows of three pixels without runs; mantissas 128, exponents 129, 130: 1 and 2.
    std::string text = "#?RADIANCE\n" + header + "\n" + resolution + "\n";
    for (int i = 0; i < 6; ++i) {
      text += {'\x80', '\x40', '\x20', static_cast<char>(i == 0 ? 130 : 129)};
    }
    write_text_atomically(folder_ / "a.hdr", text);
    return read_float_image(folder_ / "a.hdr", {}, Primaries::srgb);
  }
};

TEST_F(FloatImage, TheDisplayWindowIsThePicture) {
  struct Case {
    std::array<int, 4> data, display;
  };
  for (const auto& [data, display] : std::vector<Case>{{{0, 0, 15, 7}, {0, 0, 15, 7}},
                                                       {{3, 2, 9, 5}, {0, 0, 15, 7}},
                                                       {{-4, -3, 20, 12}, {0, 0, 15, 7}},
                                                       {{-4, 2, 5, 20}, {0, 0, 15, 7}},
                                                       {{103, 52, 109, 55}, {100, 50, 115, 57}}}) {
    const Image<float> image = read({PlainExr{rgb, data, display}});
    ASSERT_EQ(image.width(), 16);
    ASSERT_EQ(image.height(), 8);
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 16; ++x) {
        const int u = x + display[0], v = y + display[1];
        const bool held = u >= data[0] && u <= data[2] && v >= data[1] && v <= data[3];
        for (int c = 0; c < 3; ++c) {
          ASSERT_EQ(image(x, y, c), held ? 1.0F + static_cast<float>(c) : 0.0F) << x << " " << y;
        }
      }
    }
  }
  EXPECT_THAT(refusal({PlainExr{rgb, {100, 0, 115, 7}}}),
              HasSubstr("lies outside its display window"));
  write_text_atomically(folder_ / "b.exr", plain_exr({PlainExr{rgb, {3, 2, 9, 5}}}));
  EXPECT_THAT(sentence_of([&] { read_exr(folder_ / "b.exr"); }), HasSubstr("data window"));
}

TEST_F(FloatImage, ThePartOrLayerThatHoldsColoursIsTaken) {
  const Channels depth{{"Z", 9.0F}}, normals{{"N.X", 7.0F}, {"N.Y", 7.0F}, {"N.Z", 7.0F}};
  const auto part = [](const Channels& channels, const char* name = "") {
    PlainExr one{channels};
    one.name = name;
    return one;
  };
  const Channels long_names{{"beauty.red", 1.0F}, {"beauty.green", 2.0F}, {"beauty.blue", 3.0F}};
  const std::vector<std::vector<PlainExr>> files{
      {part(rgb + depth)},
      {part(rgb + layer("diffuse", 5.0F))},
      {part(layer("ViewLayer.Combined", 1.0F) + depth)},
      {part(layer("ViewLayer.Combined", 1.0F) + layer("ViewLayer.DiffCol", 5.0F))},
      {part(long_names + normals)},
      {part(depth, "depth"), part(rgb, "colour")},
      {part(layer("albedo", 5.0F), "albedo"), part(rgb, "rgba")}};
  for (const std::vector<PlainExr>& file : files) {
    const Image<float> image = read(file);
    ASSERT_EQ(image.channels(), 3);
    EXPECT_EQ(image(4, 3, 0), 1.0F);
    EXPECT_EQ(image(4, 3, 1), 2.0F);
    EXPECT_EQ(image(4, 3, 2), 3.0F);
  }
  const Image<float> grey = read({PlainExr{Channels{{"Y", 4.0F}, {"A", 1.0F}}}});
  EXPECT_EQ(grey.channels(), 1);
  EXPECT_EQ(grey(0, 0), 4.0F);
}

TEST_F(FloatImage, WhatIsNoLightIsRefusedWithTheReason) {
  EXPECT_THAT(refusal({PlainExr{Channels{{"Z", 1.0F}}}}), HasSubstr("the channels are Z"));
  EXPECT_THAT(refusal({PlainExr{Channels{{"R", 1.0F}, {"G", 1.0F}}}}),
              HasSubstr("the channels are"));
  EXPECT_THAT(refusal({PlainExr{Channels{{"N.X", 1.0F}, {"N.Y", 1.0F}, {"N.Z", 1.0F}}}}),
              HasSubstr("N.X, N.Y, N.Z"));
  EXPECT_THAT(refusal({PlainExr{layer("a", 1.0F) + layer("b", 1.0F)}}),
              AllOf(HasSubstr("several parts or layers"), HasSubstr("'a', 'b'")));
  PlainExr cube{rgb};
  cube.cube = 1;
  EXPECT_THAT(refusal({cube}), HasSubstr("cube map"));
  EXPECT_THAT(refusal({PlainExr{Channels{{"Y", 1.0F}, {"RY", 1.0F, 2}, {"BY", 1.0F, 2}}}}),
              AllOf(HasSubstr("luminance/chroma"), testing::Not(HasSubstr("damaged"))));
  EXPECT_THAT(refusal({PlainExr{Channels{{"Y", 1.0F}, {"RY", 1.0F}, {"BY", 1.0F}}}}),
              HasSubstr("luminance/chroma"));
  PlainExr deep{rgb};
  deep.deep = true;
  EXPECT_THAT(refusal({deep}), AllOf(HasSubstr("deep"), testing::Not(HasSubstr("damaged"))));
  PlainExr aces{rgb};  // AP1, as compositors write it
  aces.chromaticities = {0.713F, 0.293F, 0.165F, 0.83F, 0.128F, 0.044F, 0.32168F, 0.33767F};
  EXPECT_THAT(refusal({aces}), HasSubstr("other primaries than those of sRGB"));
  EXPECT_EQ(read_float_image(folder_ / "a.exr").channels(), 3) << "a camera's own channels";
  aces.chromaticities = {0.64F, 0.33F, 0.3F, 0.6F, 0.15F, 0.06F, 0.3127F, 0.329F};
  EXPECT_EQ(read({aces}).channels(), 3);
}

TEST_F(FloatImage, RadiancePicturesGiveRadiance) {
  const std::string format = "FORMAT=32-bit_rle_rgbe\n";
  const Image<float> plain = read_hdr(format, "-Y 2 +X 3");
  ASSERT_EQ(plain.width(), 3);
  EXPECT_NEAR(plain(0, 0, 0), 2.0F, 0.01F);
  EXPECT_NEAR(plain(1, 0, 1), 0.5F, 0.01F);
  EXPECT_NEAR(plain(2, 1, 2), 0.25F, 0.01F);
  const Image<float> exposed =
      read_hdr("EXPOSURE=2\nEXPOSURE= 4\nCOLORCORR= 1 2 4\n" + format, "-Y 2 +X 3");
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(exposed(0, 0, c) * 8.0F * static_cast<float>(1 << c), plain(0, 0, c), 1e-6F);
  }
  const Image<float> upright = read_hdr(format, "+Y 2 +X 3");
  EXPECT_EQ(upright(0, 1, 0), plain(0, 0, 0));
  EXPECT_EQ(read_hdr(format, "-Y 2 -X 3")(2, 0, 0), plain(0, 0, 0));
  EXPECT_THAT(sentence_of([&] { read_hdr("FORMAT=32-bit_rle_xyze\n", "-Y 2 +X 3"); }),
              HasSubstr("other than 32-bit_rle_rgbe"));
  EXPECT_THAT(sentence_of([&] { read_hdr(format, "+X 3 -Y 2"); }), HasSubstr("column by column"));
  // Radiance's own primaries, and those of Display P3.
  read_hdr("PRIMARIES= .64 .33 .29 .60 .15 .06 .3333 .3333\n" + format, "-Y 2 +X 3");
  EXPECT_THAT(sentence_of([&] {
                read_hdr("PRIMARIES= .68 .32 .265 .69 .15 .06 .3127 .329\n" + format, "-Y 2 +X 3");
              }),
              HasSubstr("other primaries than those of sRGB"));
  EXPECT_THAT(sentence_of([&] { read_hdr(format, "-Y 20 +X 3"); }), HasSubstr("truncated"));
}

// EXIF 2.3: the sides of the picture that the first row and the first column show.
TEST(Orientation, TurnsThePictureUpright) {
  Image<int> stored(3, 2, 1);
  for (int i = 0; i < 6; ++i) stored.values()[static_cast<std::size_t>(i)] = i;
  const std::vector<std::vector<int>> upright{
      {0, 1, 2, 3, 4, 5}, {2, 1, 0, 5, 4, 3}, {5, 4, 3, 2, 1, 0}, {3, 4, 5, 0, 1, 2},
      {0, 3, 1, 4, 2, 5}, {3, 0, 4, 1, 5, 2}, {5, 2, 4, 1, 3, 0}, {2, 5, 1, 4, 0, 3}};
  for (int tag = 1; tag <= 8; ++tag) {
    const Image<int> image = turned(stored, tag);
    EXPECT_EQ(image.values(), upright[static_cast<std::size_t>(tag - 1)]) << tag;
    EXPECT_EQ(image.width(), swaps_sides(tag) ? 2 : 3);
  }
}

}  // namespace
}  // namespace kappamu::io

// TIFF and DNG as other programs write them: pages, photometric kinds, exposure in IFD 0.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "io/image/image_file.h"
#include "io/image/photo_settings.h"
#include "io/image/raw_file.h"
#include "io/image/tiff_pages.h"
#include "tests/io/image/plain_exr.h"
#include "tests/io/image/plain_tiff.h"
#include "tests/io/support.h"

namespace kappamu::io {
namespace {

using testing::HasSubstr;

class Tiff : public FolderTest {
 protected:
  std::filesystem::path write(const std::vector<Page>& pages, const char* name = "a.tif") {
    write_text_atomically(folder_ / name, tiff(pages));
    return folder_ / name;
  }
  std::string refusal(const std::vector<Page>& pages) {
    const auto file = write(pages);
    return sentence_of([&] { read_code_image(file); });
  }
  std::string refusal_of_raw(const Page& page) {
    const auto file = write({page}, "a.dng");
    return sentence_of([&] { read_raw(file); });
  }
};

TEST_F(Tiff, BlackIsZero) {
  EXPECT_EQ(read_code_image(write({Page{1}}))(2, 1), 3100);
  EXPECT_THAT(refusal({Page{0}}), HasSubstr("a.tif: holds white as code 0 (MinIsWhite)"));
}

TEST_F(Tiff, ThePageThatIsNoPreviewIsRead) {
  const Page preview{1, 1, 2, 1}, mask{4, 4, 4, 2}, full{2, 0, 4, 2, 3};
  for (const std::vector<Page>& pages : std::vector<std::vector<Page>>{{full},
                                                                       {preview, full},
                                                                       {full, preview},
                                                                       {preview, mask, full},
                                                                       {preview, preview, full}}) {
    const Image<std::uint16_t> image = read_code_image(write(pages));
    ASSERT_EQ(image.channels(), 3);
    EXPECT_EQ(image(3, 1, 2), 4100);
  }
  EXPECT_EQ(read_code_image(write({preview})).width(), 2) << "the only page";
  EXPECT_THAT(refusal({full, full}), HasSubstr("a.tif: holds 2 full pictures (pages)"));
  EXPECT_THAT(refusal({preview, mask}), HasSubstr("previews and masks only"));
  Page above = preview;  // the full picture lies in a directory below it
  above.more = {{330, 4, {8}}};
  EXPECT_THAT(refusal({above}), HasSubstr("previews and masks only"));
}

TEST_F(Tiff, PagesAreReadByNumberOnceAsked) {
  const Page preview{1, 1, 2, 1}, small{1}, large{1, 0, 8, 4};
  const auto file = write({small, preview, large});
  TiffPages pages(file);
  EXPECT_EQ(pages.count(), 2U);
  EXPECT_EQ(pages.read(1)(7, 3), 8300.0F);
  EXPECT_EQ(pages.read(0).width(), 4) << "back";
  EXPECT_EQ(pages.read(1)(7, 3), 8300.0F);
  EXPECT_THAT(sentence_of([&] { pages.read(2); }), HasSubstr("a.tif: has pages 0 to 1, no page 2"));
}

TEST_F(Tiff, OtherColoursAreRefusedByName) {
  EXPECT_THAT(refusal({Page{5, 0, 4, 2, 4}}), HasSubstr("CMYK"));
  EXPECT_THAT(refusal({Page{8, 0, 4, 2, 3}}), HasSubstr("Lab"));
  EXPECT_THAT(refusal({Page{32803, 0, 4, 2, 1}}), HasSubstr("mosaic"));
}

/// 5 x 3 values k / 8 of three channels, k counted along [y][x][channel]; SampleFormat 1 without
/// sign, 2 with, 3 floats.
template <class Value>
Page numbers(unsigned format, bool planes = false) {
  Page page{2, 0, 5, 3, 3, {{339, 3, {format, format, format}}, {284, 3, {planes ? 2U : 1U}}}};
  page.bits = 8 * sizeof(Value);
  page.strips = planes ? 3 : 1;
  for (int k = 0; k < 45; ++k) {
    const auto value = static_cast<Value>((planes ? k % 15 * 3 + k / 15 : k) / 8.0);
    page.pixels.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  return page;
}

TEST_F(Tiff, FloatsAreLinearLightAndPlanesAreReadInOrder) {
  for (const bool planes : {false, true}) {
    const auto floats = write({numbers<float>(3, planes)});
    ASSERT_TRUE(is_float_image(floats));
    const Image<float> image = read_float_image(floats);
    for (int k = 0; k < 45; ++k) ASSERT_EQ(image(k / 3 % 5, k / 15, k % 3), k / 8.0F) << planes;
    const auto codes = write({numbers<std::uint16_t>(1, planes)});
    EXPECT_FALSE(is_float_image(codes));
    EXPECT_EQ(read_code_image(codes)(4, 2, 1), 43 / 8) << planes;
  }
}

TEST_F(Tiff, FloatPagesAreReadByNumber) {
  const auto file = write({numbers<float>(3), numbers<float>(3, true), numbers<float>(3)});
  TiffPages pages(file);
  EXPECT_EQ(pages.count(), 3U);
  for (const std::size_t page : {0, 1, 2}) {
    const Image<float> image = pages.read(page);
    for (int k = 0; k < 45; ++k) ASSERT_EQ(image(k / 3 % 5, k / 15, k % 3), k / 8.0F) << page;
  }
}

TEST_F(Tiff, OtherNumbersAreRefusedByName) {
  EXPECT_THAT(refusal({numbers<std::int16_t>(2)}),
              HasSubstr("a.tif: holds signed whole numbers of 16 bits; save it with 8 or 16 bits"));
  EXPECT_THAT(refusal({numbers<std::uint32_t>(1)}), HasSubstr("numbers of 32 bits"));
  EXPECT_THAT(refusal({numbers<float>(3)}), HasSubstr("floats of 32 bits"));
  const auto doubles = write({numbers<double>(3)});
  EXPECT_THAT(sentence_of([&] { read_float_image(doubles); }),
              HasSubstr("floats of 64 bits; save it with 32"));
}

TEST_F(Tiff, ExposureComesFromIfd0OrTheShutterSpeed) {
  const Tag exposure{33434, 5, {1, 10}}, speed{37377, 10, {4, 1}}, turned{274, 3, {6}};
  EXPECT_EQ(read_photo_settings(write({Page{1, 0, 4, 2, 1, {exposure}}})).exposure_s, 0.1);
  EXPECT_EQ(read_photo_settings(write({Page{1, 0, 4, 2, 1, {speed, turned}}})).exposure_s,
            1.0 / 16.0);
  EXPECT_EQ(read_photo_settings(folder_ / "a.tif").orientation, 6);
  EXPECT_FALSE(read_photo_settings(write({Page{1}})).orientation);
}

TEST_F(Tiff, RawExposureComesFromIfd0OrTheShutterSpeed) {
  const Tag exposure{33434, 5, {1, 10}}, speed{37377, 10, {4, 1}};
  const Tag slow{37377, 10, {0xFFFFFFFFU, 1}}, turned{274, 3, {3}};
  const auto settings = [&](const std::vector<Tag>& tags) {
    return read_photo_settings(write({dng(true, tags)}, "a.dng"));
  };
  EXPECT_EQ(settings({exposure, turned}).exposure_s, 0.1);
  EXPECT_EQ(settings({exposure, turned}).orientation, 3);
  EXPECT_EQ(settings({exposure, speed}).exposure_s, 0.1);
  EXPECT_EQ(settings({speed}).exposure_s, 1.0 / 16.0);
  EXPECT_EQ(settings({slow}).exposure_s, 2.0);
  EXPECT_FALSE(settings({}).exposure_s);
}

TEST_F(Tiff, RawOfAGreySensorIsReadWithoutAMosaic) {
  const RawImage colour = read_raw(write({dng(true, {})}, "a.dng"));
  EXPECT_EQ(colour.layout, (BayerLayout{0, 1, 1, 2}));
  const RawImage grey = read_raw(write({dng(false, {})}, "a.dng"));
  EXPECT_FALSE(grey.layout);
  EXPECT_EQ(grey.black[0], 64.0);
  EXPECT_EQ(grey.white, 65000);
  EXPECT_EQ(grey.codes.values(), colour.codes.values());
  Page repeated = dng(true, {{50713, 3, {2, 2}}});
  for (Tag& tag : repeated.more) {
    if (tag.number == 50714) tag.values = {100, 110, 120, 130};
  }
  EXPECT_EQ(read_raw(write({repeated}, "a.dng")).black, (std::array<double, 3>{100, 115, 130}));
}

// Converters write several colours a pixel ("linear raw"), in an odd extent where they like.
TEST_F(Tiff, LinearDngIsReadInItsThreeColours) {
  Page page = dng(false, {{50829, 4, {1, 2, 48, 65}}});  // the first row and two columns are margin
  page.samples = 3;
  page.width = 65;
  page.height = 49;
  const auto code = [](unsigned x, unsigned y, unsigned c) { return 100 * x + 7 * y + 20000 * c; };
  for (unsigned y = 0; y < page.height; ++y) {
    for (unsigned i = 0; i < 3 * page.width; ++i) put_number(page.pixels, code(i / 3, y, i % 3), 2);
  }
  for (Tag& tag : page.more) {
    if (tag.number == 50714) tag.values = {100, 110, 120};
    if (tag.number == 50717) tag.values = {60000, 60000, 60000};
  }
  const RawImage raw = read_raw(write({page}, "a.dng"));
  EXPECT_FALSE(raw.layout);
  EXPECT_EQ(raw.channels(), 3);
  ASSERT_EQ(raw.codes.width(), 63);
  ASSERT_EQ(raw.codes.height(), 47);
  for (unsigned y = 0; y < 47; ++y) {
    for (unsigned x = 0; x < 63; ++x) {
      for (unsigned c = 0; c < 3; ++c) {
        ASSERT_EQ(raw.codes(static_cast<int>(x), static_cast<int>(y), static_cast<int>(c)),
                  static_cast<int>(code(x + 2, y + 1, c)));
      }
    }
  }
  EXPECT_EQ(raw.black, (std::array<double, 3>{100, 110, 120}));
  EXPECT_EQ(raw.white, 60000);
  page.samples = 2;
  page.pixels.clear();
  EXPECT_THAT(refusal_of_raw(page), HasSubstr("a.dng: "));
}

TEST_F(Tiff, RawOfFloatingPointNumbersIsRefused) {
  for (const unsigned samples : {1U, 3U}) {
    Page page = dng(samples == 1, {{339, 3, std::vector<std::uint32_t>(samples, 3)}});
    page.samples = samples;
    page.bits = 32;
    page.compression = 8;
    EXPECT_THAT(refusal_of_raw(page), HasSubstr("a.dng: a DNG of floating point numbers"));
  }
}

// Compression 7 is lossless JPEG (SOF3) or, by cameras and converters that save room, baseline JPEG
// (SOF0), of which LibRaw made other codes, without a word.
TEST_F(Tiff, LossyRawIsRefused) {
  Image<std::uint8_t> picture(64, 48, 1);
  for (int x = 0; x < 64 * 48; ++x) picture(x % 64, x / 64) = static_cast<std::uint8_t>(x % 251);
  const std::vector<std::uint8_t> jpeg = encode_jpeg(picture, 90);
  Page page = dng(true, {});
  page.bits = 8;
  page.pixels.assign(jpeg.begin(), jpeg.end());
  page.compression = 7;
  EXPECT_THAT(refusal_of_raw(page), HasSubstr("a.dng: holds lossy JPEG"));
}

// A lossless JPEG of 2 x 1 codes, made by hand from T.81, annex H: predictor 1, differences of no
// bits (the code 1 << 15 everywhere).
TEST_F(Tiff, LosslessRawIsRead) {
  const std::string jpeg(
      "\xFF\xD8"                                                  // begin
      "\xFF\xC3\x00\x0B\x10\x00\x30\x00\x40\x01\x00\x11\x00"      // 16 bits, 48 x 64, one part
      "\xFF\xC4\x00\x14\x00\x01\x00\x00\x00\x00\x00\x00\x00\x00"  // one code of one bit ...
      "\x00\x00\x00\x00\x00\x00\x00\x00"                          // ... for differences of 0
      "\xFF\xDA\x00\x08\x01\x01\x00\x01\x00\x00",                 // scan, predictor 1
      2 + 13 + 22 + 10);
  Page page = dng(true, {});
  page.pixels = jpeg + std::string(64 * 48 / 8, '\0') + "\xFF\xD9";
  page.compression = 7;
  const RawImage raw = read_raw(write({page}, "a.dng"));
  EXPECT_THAT(raw.codes.values(), testing::Each(1 << 15));
}

}  // namespace
}  // namespace kappamu::io

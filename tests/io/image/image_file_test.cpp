#include "io/image/image_file.h"

#include <fstream>
#include <random>
#include <string_view>

#include "io/image/exr.h"
#include "tests/io/python.h"
#include "tests/io/support.h"

namespace kappamu::io {
namespace {

using testing::HasSubstr;

using ImageFile = FolderTest;
using Exr = FolderTest;

template <class T>
Image<T> noise(int width, int height, int channels, unsigned largest) {
  std::mt19937 random(7);
  Image<T> image(width, height, channels);
  for (T& value : image.values()) value = static_cast<T>(random() % (largest + 1));
  return image;
}

TEST_F(ImageFile, CodesComeBackAtEveryDepthAndFormat) {
  for (const char* name : {"a.png", "a.tif", "a.TIFF"}) {
    for (const int channels : {1, 3}) {
      for (const int bits : {8, 10, 12, 16}) {
        const auto image = noise<std::uint16_t>(37, 23, channels, (1U << bits) - 1);
        write_code_image(folder_ / name, image, bits);
        const auto back = read_code_image(folder_ / name);
        ASSERT_TRUE(back.same_shape(image)) << name << " " << bits;
        EXPECT_EQ(back.values(), image.values()) << name << " " << bits << " bits";
      }
    }
  }
}

TEST_F(ImageFile, ChannelsAreRedGreenBlue) {
  Image<std::uint8_t> image(2, 1, 3);
  image(0, 0, 0) = 200;
  image(1, 0, 2) = 100;
  write_image(folder_ / "a.png", image);
  const auto back = read_code_image(folder_ / "a.png");
  EXPECT_EQ(back(0, 0, 0), 200);
  EXPECT_EQ(back(0, 0, 2), 0);
  EXPECT_EQ(back(1, 0, 2), 100);
  const auto jpeg = encode_jpeg(Image<std::uint8_t>(8, 8, 3, 128), 90);
  write_bytes_atomically(folder_ / "grey.jpg", std::as_bytes(std::span(jpeg)));
  EXPECT_NEAR(read_code_image(folder_ / "grey.jpg")(4, 4, 1), 128, 1);
}

TEST_F(ImageFile, VtkSeesTheSameColours) {
  Image<std::uint8_t> image(2, 3, 3);
  image(0, 0, 0) = 200;  // red, top left
  write_image(folder_ / "a.png", image);
  KAPPAMU_NEED_PYTHON("vtkmodules.vtkIOImage");
  // VTK counts rows from the bottom.
  EXPECT_EQ(run_python("from vtkmodules.vtkIOImage import vtkPNGReader\n"
                       "r = vtkPNGReader(); r.SetFileName('a.png'); r.Update(); o = r.GetOutput()\n"
                       "print(o.GetDimensions(),"
                       " [int(o.GetScalarComponentAsDouble(0, 2, 0, c)) for c in range(3)])",
                       folder_),
            "(2, 3, 1) [200, 0, 0]\n");
}

TEST_F(ImageFile, CodeAboveTheBitDepthIsOurBug) {
  EXPECT_THROW(write_code_image(folder_ / "a.png", Image<std::uint16_t>(2, 2, 1, 4096), 12),
               InternalError);
}

TEST_F(ImageFile, UnknownEndingIsRefused) {
  EXPECT_THAT(sentence_of([&] { write_image(folder_ / "a.bmp", Image<std::uint8_t>(2, 2, 1)); }),
              HasSubstr("a.bmp: images are written as .png, .tif or .tiff"));
}

TEST_F(ImageFile, TruncatedImagesAreRefused) {
  const auto read = [](const auto& file) { read_code_image(file); };
  for (const char* name : {"a.png", "a.tif"}) {
    for (const int bits : {8, 16}) {
      write_code_image(folder_ / name, noise<std::uint16_t>(64, 48, 3, 255), bits);
      expect_truncations_are_refused(folder_ / name, read);
    }
  }
  const auto jpeg = encode_jpeg(noise<std::uint8_t>(64, 48, 3, 255), 90);
  write_bytes_atomically(folder_ / "a.jpg", std::as_bytes(std::span(jpeg)));
  expect_truncations_are_refused(folder_ / "a.jpg", read);
}

TEST_F(ImageFile, SentencesNameFileAndReason) {
  EXPECT_EQ(sentence_of([&] { read_code_image(folder_ / "a.png"); }),
            "cannot read " + (folder_ / "a.png").string() + ": there is no such file");
  write_text_atomically(folder_ / "a.png", "not an image at all");
  EXPECT_EQ(sentence_of([&] { read_code_image(folder_ / "a.png"); }),
            (folder_ / "a.png").string() +
                ": not a PNG, TIFF, JPEG or BMP image; convert it to one of them");
  write_code_image(folder_ / "a.png", noise<std::uint16_t>(64, 48, 1, 4095), 12);
  truncate_to(folder_ / "a.png", 3000);
  EXPECT_EQ(sentence_of([&] { read_code_image(folder_ / "a.png"); }),
            (folder_ / "a.png").string() + ": truncated PNG image; copy or photograph it again");
}

TEST_F(ImageFile, FlippedBytesAreFoundByThePngChecksum) {
  write_code_image(folder_ / "a.png", noise<std::uint16_t>(64, 48, 1, 4095), 12);
  std::string text = read_text(folder_ / "a.png");
  text[text.size() / 2] = static_cast<char>(text[text.size() / 2] ^ 0x40);
  write_text_atomically(folder_ / "a.png", text);
  EXPECT_THAT(sentence_of([&] { read_code_image(folder_ / "a.png"); }),
              HasSubstr("a.png: damaged PNG image"));
}

/// Random damage may give an error or another picture, never a crash.
TEST_F(ImageFile, DamagedBytesNeverCrash) {
  std::mt19937 random(3);
  for (const char* name : {"a.png", "a.tif", "a.exr"}) {
    const auto file = folder_ / name;
    if (file.extension() == ".exr") {
      write_float_image(file, Image<float>(24, 16, 3, 0.5F));
    } else {
      write_code_image(file, noise<std::uint16_t>(24, 16, 3, 255), 8);
    }
    const std::string whole = read_text(file);
    for (int round = 0; round < 200; ++round) {
      std::string text = whole;
      for (int i = 0; i < 4; ++i) text[random() % text.size()] = static_cast<char>(random());
      std::ofstream(file, std::ios::binary) << text;
      try {
        if (file.extension() == ".exr") {
          read_float_image(file);
        } else {
          read_code_image(file);
        }
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr(name));
      }
    }
  }
}

/// A small file whose header claims gigapixels is refused before anything makes room for them.
TEST_F(ImageFile, HeadersThatClaimTooMuchAreRefused) {
  const auto patched = [&](const char* name, std::string_view before, std::string_view extents) {
    std::string text = read_text(folder_ / name);
    const std::size_t at = text.find(before);
    ASSERT_NE(at, std::string::npos) << name;
    text.replace(at + before.size(), extents.size(), extents);
    std::ofstream(folder_ / name, std::ios::binary) << text;
    const bool exr = (folder_ / name).extension() == ".exr";
    EXPECT_THAT(sentence_of([&] {
                  exr ? static_cast<void>(read_float_image(folder_ / name))
                      : static_cast<void>(read_code_image(folder_ / name));
                }),
                testing::AllOf(HasSubstr(name), HasSubstr("damaged")));
  };
  using namespace std::string_view_literals;
  const auto jpeg = encode_jpeg(noise<std::uint8_t>(64, 48, 3, 255), 90);
  write_bytes_atomically(folder_ / "a.jpg", std::as_bytes(std::span(jpeg)));
  patched("a.jpg", "\xFF\xC0\0\x11\x08"sv, "\x7F\xFF\x7F\xFF"sv);
  write_code_image(folder_ / "a.tif", noise<std::uint16_t>(64, 48, 1, 4095), 12);
  patched("a.tif", "\0\x01\x03\0\x01\0\0\0"sv, "\xFF\xFF\0\0\x01\x01\x03\0\x01\0\0\0\xFF\xFF"sv);
  write_float_image(folder_ / "a.exr", Image<float>(24, 16, 3, 0.5F));
  patched("a.exr", "dataWindow\0box2i\0\x10\0\0\0"sv, "\0\0\0\0\0\0\0\0\0\xEF\0\0\x1F\0\0\0"sv);
  // Behind its size a PNG holds a checksum; this is that of 65535 x 65535, 16-bit grey.
  write_code_image(folder_ / "a.png", noise<std::uint16_t>(64, 48, 1, 4095), 12);
  patched("a.png", "IHDR"sv, "\0\0\xFF\xFF\0\0\xFF\xFF\x10\0\0\0\0\xC3\xFE\x5A\xCF"sv);
}

TEST_F(Exr, LayersAndAttributesComeBack) {
  ExrImage image{5, 3, {}, {{"units", "full scales per second"}, {"sample", "marble"}}};
  float next = 0.25F;
  for (const char* name : {"R", "radiance.R", "variance.R", "flags.R"}) {
    auto& values = image.channels[name];
    for (int i = 0; i < 15; ++i) values.push_back(next *= -1.37F);
  }
  write_exr(folder_ / "a.exr", image);
  const ExrImage back = read_exr(folder_ / "a.exr");
  EXPECT_EQ(back.width, 5);
  EXPECT_EQ(back.height, 3);
  EXPECT_EQ(back.channels, image.channels);
  EXPECT_EQ(back.attributes.at("units"), "full scales per second");
  EXPECT_EQ(back.attributes.at("sample"), "marble");
  EXPECT_THAT(listing(), testing::ElementsAre("a.exr"));
}

TEST_F(Exr, ColourImageComesBack) {
  Image<float> image(4, 3, 3);
  for (std::size_t i = 0; i < image.size(); ++i) image.values()[i] = static_cast<float>(i);
  write_float_image(folder_ / "a.exr", image);
  const auto back = read_float_image(folder_ / "a.exr");
  ASSERT_TRUE(back.same_shape(image));
  EXPECT_EQ(back.values(), image.values());
}

TEST_F(Exr, MissingChannelIsNamed) {
  ExrImage image{1, 1, {{"R", {1.0F}}, {"G", {1.0F}}}, {}};
  write_exr(folder_ / "a.exr", image);
  EXPECT_THAT(
      sentence_of([&] { read_float_image(folder_ / "a.exr"); }),
      HasSubstr("a.exr: no part or layer holds R, G, B, or grey as Y; the channels are R, G"));
}

TEST_F(Exr, TruncatedFilesAreRefused) {
  const auto codes = noise<std::uint16_t>(64, 48, 3, 65535);
  Image<float> image(64, 48, 3);
  for (std::size_t i = 0; i < image.size(); ++i) image.values()[i] = codes.values()[i];
  write_float_image(folder_ / "a.exr", image);
  expect_truncations_are_refused(folder_ / "a.exr",
                                 [](const auto& file) { read_float_image(file); });
}

}  // namespace
}  // namespace kappamu::io

// Small files that claim much: each is refused with its sentence by a process of its own, whose
// memory and time are measured. As a sparse file costs nothing to make, sizes on the disk are
// claims too.
#include <sys/resource.h>
#include <sys/wait.h>
#include <zlib.h>

#include <array>
#include <fstream>
#include <functional>

#include "io/image/exr.h"
#include "io/image/image_file.h"
#include "io/image/photo_settings.h"
#include "io/image/raw_file.h"
#include "io/json_node.h"
#include "io/npy.h"
#include "io/volume/volume_file.h"
#include "tests/io/python.h"
#include "tests/io/support.h"

namespace kappamu::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double most_memory = 1e9;   ///< [bytes]
constexpr double most_seconds = 2.0;  ///< of processor time: the machine may be busy otherwise

using Bomb = FolderTest;

/// What a child of this process says of `read`: its InputError's sentence. It may not exceed the
/// bounds above.
std::string refusal(const std::function<void()>& read) {
  std::array<int, 2> channel{};
  if (::pipe(channel.data()) != 0) return "no pipe";
  const pid_t child = ::fork();
  if (child == 0) {
    std::string sentence = "accepted";
    try {
      read();
    } catch (const InputError& error) {
      sentence = error.what();
    } catch (const std::exception& error) {
      sentence = std::string("not an InputError: ") + error.what();
    }
    const auto written = ::write(channel[1], sentence.data(), sentence.size());
    ::_exit(written == static_cast<ssize_t>(sentence.size()) ? 0 : 1);
  }
  ::close(channel[1]);
  std::string sentence;
  std::array<char, 4096> part{};
  for (ssize_t n = 0; (n = ::read(channel[0], part.data(), part.size())) > 0;) {
    sentence.append(part.data(), static_cast<std::size_t>(n));
  }
  ::close(channel[0]);
  int status = 0;
  rusage usage{};
  ::wait4(child, &status, 0, &usage);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "ended by " << status;
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  EXPECT_LT(1024.0 * static_cast<double>(usage.ru_maxrss), most_memory) << sentence;
  EXPECT_LT(seconds(usage.ru_utime) + seconds(usage.ru_stime), most_seconds) << sentence;
  std::printf("  %.0f MB, %.2f s: %s\n", static_cast<double>(usage.ru_maxrss) / 1024.0,
              seconds(usage.ru_utime) + seconds(usage.ru_stime), sentence.c_str());
  return sentence;
}

void put(std::string& to, std::uint64_t value, int bytes, bool big_endian) {
  for (int i = 0; i < bytes; ++i) {
    to += static_cast<char>(value >> 8 * (big_endian ? bytes - 1 - i : i) & 0xFFU);
  }
}

std::string deflate_zeros(std::size_t size) {
  const std::string zeros(std::size_t{1} << 20, '\0');
  std::string packed(size / 500 + 1000, '\0');
  z_stream stream{};
  deflateInit(&stream, Z_BEST_SPEED);
  stream.next_out = reinterpret_cast<unsigned char*>(packed.data());
  stream.avail_out = static_cast<unsigned>(packed.size());
  for (std::size_t done = 0; done < size; done += zeros.size()) {
    stream.next_in = reinterpret_cast<unsigned char*>(const_cast<char*>(zeros.data()));
    stream.avail_in = static_cast<unsigned>(std::min(zeros.size(), size - done));
    deflate(&stream, done + zeros.size() < size ? Z_NO_FLUSH : Z_FINISH);
  }
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

void add_chunk(std::string& png, const std::string& type, const std::string& data) {
  put(png, data.size(), 4, true);
  const std::string checked = type + data;
  png += checked;
  put(png,
      crc32(0, reinterpret_cast<const unsigned char*>(checked.data()),
            static_cast<unsigned>(checked.size())),
      4, true);
}

/// A whole PNG, grey, of 16 bits; rows of zeros take a thousandth of their size.
std::string png_of_zeros(unsigned width, unsigned height, const std::string& chunks) {
  std::string header;
  put(header, width, 4, true);
  put(header, height, 4, true);
  header += std::string("\x10\0\0\0\0", 5);
  std::string png("\x89PNG\r\n\x1a\n");
  add_chunk(png, "IHDR", header);
  png += chunks;
  add_chunk(png, "IDAT", deflate_zeros(std::size_t{height} * (2 * std::size_t{width} + 1)));
  add_chunk(png, "IEND", "");
  return png;
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

/// A file of `text` and then a hole.
void write_sparse(const std::filesystem::path& file, const std::string& text, std::uintmax_t size) {
  write_text(file, text);
  std::filesystem::resize_file(file, size);
}

void expect_camera_size(const ImageSize& size) {
  if (size.width != 640 || size.height != 480) throw InputError("the camera has 640 x 480 pixels");
}

TEST_F(Bomb, PngOf20000Squared) {
  const auto file = folder_ / "a.png";
  write_text(file, png_of_zeros(20000, 20000, ""));
  EXPECT_LT(std::filesystem::file_size(file), 2'300'000U);
  EXPECT_EQ(refusal([&] { read_code_image(file, expect_camera_size); }),
            "the camera has 640 x 480 pixels");
  EXPECT_THAT(refusal([&] { read_code_image(file); }), HasSubstr("more than 300 million values"));
}

/// libpng inflates each text to as much as 8 MB.
TEST_F(Bomb, PngOfCompressedTexts) {
  std::string chunks;
  const std::string text = deflate_zeros(7'900'000);
  for (int i = 0; i < 900; ++i) {
    add_chunk(chunks, "zTXt", "k" + std::to_string(i) + std::string(2, '\0') + text);
  }
  write_text(folder_ / "a.png", png_of_zeros(8, 8, chunks));
  EXPECT_THAT(refusal([&] { read_code_image(folder_ / "a.png"); }), HasSubstr("damaged PNG image"));
  refusal([&] { read_photo_settings(folder_ / "a.png"); });
}

/// libtiff makes room for the same 800 kB once per entry: of unknown tags, of one tag again and
/// again (the offsets of its strips), and behind the EXIF tag.
TEST_F(Bomb, TiffOf65000DirectoryEntries) {
  constexpr unsigned entries = 65000;
  const auto directory = [&](std::string& tiff, const std::function<unsigned(unsigned)>& tag) {
    put(tiff, entries, 2, false);
    for (unsigned i = 0; i < entries; ++i) {
      put(tiff, tag(i), 2, false);
      put(tiff, 4, 2, false);
      put(tiff, 200'000, 4, false);
      put(tiff, 1000, 4, false);
    }
    put(tiff, 0, 4, false);
  };
  const std::string header("II*\0\x08\0\0\0", 8);
  const auto write = [&](const std::string& tiff) {
    write_sparse(folder_ / "a.tif", tiff, 1'600'000);
    return refusal([&] { read_code_image(folder_ / "a.tif"); });
  };
  std::string unknown = header;
  directory(unknown, [](unsigned i) { return 400 + i; });
  EXPECT_THAT(write(unknown), HasSubstr("a.tif: damaged TIFF image"));
  std::string strips = header;
  directory(strips, [](unsigned i) { return 273 + 6 * (i % 2); });
  EXPECT_THAT(write(strips), HasSubstr("a.tif: damaged TIFF image"));
  std::string exif = header;
  put(exif, 1, 2, false);
  put(exif, 34665, 2, false);
  put(exif, 4, 2, false);
  put(exif, 1, 4, false);
  put(exif, 8 + 2 + 12 + 4, 4, false);
  put(exif, 0, 4, false);
  directory(exif, [](unsigned i) { return 400 + i; });
  EXPECT_THAT(write(exif), HasSubstr("a.tif: damaged TIFF image"));
}

/// A progressive JPEG: libjpeg decodes all of it while it opens it.
TEST_F(Bomb, JpegOf65500Squared) {
  for (const char frame : {'\xC0', '\xC2'}) {
    std::string jpeg("\xFF\xD8\xFF");
    jpeg += frame;
    jpeg += std::string("\0\x11\x08\xFF\xDC\xFF\xDC\x03\x01\x11\0\x02\x11\0\x03\x11\0", 17);
    jpeg += std::string("\xFF\xDA\0\x0C\x03\x01\0\x02\0\x03\0\0\0\0", 14);
    jpeg += std::string(2'000'000, '\x55') + "\xFF\xD9";
    write_text(folder_ / "a.jpg", jpeg);
    EXPECT_EQ(refusal([&] { read_code_image(folder_ / "a.jpg", expect_camera_size); }),
              "the camera has 640 x 480 pixels");
    EXPECT_THAT(refusal([&] { read_code_image(folder_ / "a.jpg"); }), HasSubstr("a.jpg: damaged"));
    EXPECT_THAT(refusal([&] { read_photo_settings(folder_ / "a.jpg"); }), HasSubstr("a.jpg: "));
  }
}

TEST_F(Bomb, ExrOfAHugeDataWindow) {
  const auto file = folder_ / "a.exr";
  write_float_image(file, Image<float>(24, 16, 3, 0.5F));
  std::string exr = read_text(file);
  const std::string window("dataWindow\0box2i\0\x10\0\0\0", 21);
  const std::size_t at = exr.find(window);
  ASSERT_NE(at, std::string::npos);
  for (const unsigned extent : {19'999U, 65'535U, 1'000'000'000U}) {
    std::string extents(8, '\0');
    put(extents, extent, 4, false);
    put(extents, extent, 4, false);
    write_text(file, exr.replace(at + window.size(), extents.size(), extents));
    EXPECT_THAT(refusal([&] { read_exr(file, expect_camera_size); }),
                testing::AnyOf(HasSubstr("640 x 480"), HasSubstr("damaged")));
    EXPECT_THAT(refusal([&] { read_exr(file); }),
                AllOf(HasSubstr("a.exr: "), HasSubstr("damaged")));
  }
}

/// A DNG of 16 bits a site without the sites.
TEST_F(Bomb, ExrOfTwoHundredMillionRows) {
  const auto file = folder_ / "a.exr";
  write_float_image(file, Image<float>(1, 16, 3, 0.5F));
  std::string exr = read_text(file);
  const std::string window("dataWindow\0box2i\0\x10\0\0\0", 21);
  const std::size_t at = exr.find(window);
  ASSERT_NE(at, std::string::npos);
  std::string rows;
  put(rows, 200'000'000U, 4, false);
  write_text(file, exr.replace(at + window.size() + 12, rows.size(), rows));
  EXPECT_THAT(refusal([&] { read_exr(file); }), AllOf(HasSubstr("a.exr: "), HasSubstr("damaged")));
  EXPECT_THAT(refusal([&] { read_float_image(file); }), HasSubstr("a.exr: "));
}

// Found by the fuzzer: a text of 1.9 GB in a file of 368 bytes.
TEST_F(Bomb, ExrOfAHugeAttribute) {
  const auto file = folder_ / "a.exr";
  write_float_image(file, Image<float>(24, 16, 3, 0.5F));
  std::string exr = read_text(file);
  exr.insert(8, std::string("capDate\0string\0\0\0\0\x74", 19));
  write_text(file, exr);
  EXPECT_THAT(refusal([&] { read_exr(file); }), AllOf(HasSubstr("a.exr: "), HasSubstr("damaged")));
  EXPECT_THAT(refusal([&] { read_float_image(file); }), HasSubstr("a.exr: "));
}

TEST_F(Bomb, DngOf30000Squared) {
  std::string dng("II*\0\x08\0\0\0", 8);
  const std::vector<std::array<unsigned, 4>> tags{{254, 4, 1, 0},
                                                  {256, 4, 1, 30000},
                                                  {257, 4, 1, 30000},
                                                  {258, 3, 1, 16},
                                                  {259, 3, 1, 1},
                                                  {262, 3, 1, 32803},
                                                  {273, 4, 1, 512},
                                                  {277, 3, 1, 1},
                                                  {278, 4, 1, 30000},
                                                  {279, 4, 1, 4000000000},
                                                  {33421, 3, 2, 0x00020002},
                                                  {33422, 1, 4, 0x02010100},
                                                  {50706, 1, 4, 0x0401},
                                                  {50714, 4, 1, 64},
                                                  {50717, 4, 1, 4095}};
  put(dng, tags.size(), 2, false);
  for (const auto& [tag, type, count, value] : tags) {
    put(dng, tag, 2, false);
    put(dng, type, 2, false);
    put(dng, count, 4, false);
    put(dng, value, 4, false);
  }
  write_sparse(folder_ / "a.dng", dng, 4096);
  EXPECT_THAT(refusal([&] { read_raw(folder_ / "a.dng", expect_camera_size); }),
              HasSubstr("640 x 480"));
  EXPECT_THAT(refusal([&] { read_raw(folder_ / "a.dng"); }), HasSubstr("a.dng: damaged image"));
  refusal([&] { read_photo_settings(folder_ / "a.dng"); });
}

/// 18 kB of tiles that stand for 2048³ voxels.
TEST_F(Bomb, VdbOfTiles) {
  const auto file = folder_ / "a.vdb";
  KAPPAMU_NEED_PYTHON("pyopenvdb");
  run_python(
      "import pyopenvdb as v\n"
      "gs = []\n"
      "for n in ('kappa', 'mu'):\n"
      "  g = v.FloatGrid(); g.name = n; g.transform = v.createLinearTransform(0.1)\n"
      "  g.fill((0, 0, 0), (2047, 2047, 2047), 1.0); gs.append(g)\n"
      "v.write('a.vdb', grids=gs)",
      folder_);
  ASSERT_LT(std::filesystem::file_size(file), 100'000U);
  EXPECT_THAT(refusal([&] { read_volume(file); }),
              HasSubstr("a.vdb: 2 volumes of 2048 x 2048 x 2048 voxels are more than the 100000000 "
                        "voxels allowed; allow more if the file is meant so"));
}

TEST_F(Bomb, NpyOfAHole) {
  std::string npy("\x93NUMPY\x01\0", 8);
  std::string header = "{'descr': '|u1', 'fortran_order': False, 'shape': (65536, 1024, 1024), }\n";
  put(npy, header.size(), 2, false);
  npy += header;
  write_sparse(folder_ / "a.npy", npy, npy.size() + (std::uintmax_t{1} << 36));
  EXPECT_THAT(refusal([&] {
                read_npy(folder_ / "a.npy", {3, 4, 5});
              }),
              HasSubstr("a.npy: array has shape [65536][1024][1024] instead of [3][4][5]"));
  write_text(folder_ / "volume.json",
             R"({"format":"kappamu-volume","version":1,"grid":[65536,65536,65536],"voxel_mm":1,)"
             R"("channels":["R"],"units":{"kappa_R":"mm","mu_R":"1/mm"}})");
  EXPECT_THAT(refusal([&] { read_volume(folder_); }), HasSubstr("voxels allowed; allow more"));
}

TEST_F(Bomb, FilesOfHolesAreRefusedByTheirSize) {
  constexpr std::uintmax_t size = 50'000'000'000;
  for (const char* name : {"a.png", "a.jpg", "a.tif", "a.dng", "a.exr"}) {
    const auto file = folder_ / name;
    write_sparse(file, "II*", size);
    EXPECT_THAT(refusal([&] {
                  file.extension() == ".dng"   ? static_cast<void>(read_raw(file))
                  : file.extension() == ".exr" ? static_cast<void>(read_exr(file))
                                               : static_cast<void>(read_code_image(file));
                }),
                HasSubstr("its 50000000000 bytes are more than the 1073741824 that"));
  }
}

/// Text of half the size again is refused by its size; what is parsed stays within the memory.
TEST_F(Bomb, JsonOfManySmallValues) {
  const auto file = folder_ / "a.json";
  const auto read = [&] { JsonDocument(file, "f").root().expect_fields({"b"}); };
  std::string text = "{\"a\":[";
  while (text.size() + 8 < largest_text) text += "{},";
  text += "{}]}";
  write_text(file, text);
  EXPECT_THAT(refusal(read), HasSubstr("a.json"));
  write_text(file, "\"" + std::string(largest_text, 'a') + "\"");
  EXPECT_THAT(refusal(read), HasSubstr("are more than the 8388608 that such a file may have"));
  write_text(file, std::string(largest_text - 1, '['));
  EXPECT_THAT(refusal(read),
              HasSubstr("a.json: its lists and objects are nested more than 100 deep"));
  const std::string nested = std::string(1'000'000, '[') + std::string(1'000'000, ']');
  write_text(file, "{\"b\":" + nested + "}");
  EXPECT_THAT(refusal([&] { JsonDocument(file, "f").root()["b"].choice({"c"}); }),
              HasSubstr("nested more than 100 deep"));
}

}  // namespace
}  // namespace kappamu::io

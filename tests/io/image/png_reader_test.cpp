// PNG rows that ISA-L inflates: every filter of the specification (9.2) gives the codes back, and
// what is no plain picture is left to OpenImageIO.
#include "io/image/png_reader.h"

#include <zlib.h>

#include <array>
#include <cmath>
#include <random>
#include <string>

#include "io/image/image_file.h"
#include "tests/io/support.h"

namespace kappamu::io {
namespace {

using testing::HasSubstr;

struct Layout {
  int width, height, channels, bits;
};
constexpr int noisy_filter = -1;  // another one in each row

void put_number(std::string& to, std::size_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) to += static_cast<char>(number >> shift);
}

std::string chunk_of(const std::string& type, const std::string& data) {
  std::string chunk;
  put_number(chunk, data.size());
  chunk += type + data;
  put_number(chunk, ::crc32(0, reinterpret_cast<const Bytef*>(&chunk[4]),
                            static_cast<uInt>(data.size() + 4)));
  return chunk;
}

/// As the specification has it (9.4).
int paeth(int left, int above, int corner) {
  const int estimate = left + above - corner;
  const int a = std::abs(estimate - left), b = std::abs(estimate - above),
            c = std::abs(estimate - corner);
  return a <= b && a <= c ? left : b <= c ? above : corner;
}

/// Rows of bytes behind the number of their filter.
std::string filtered_rows(const Image<std::uint16_t>& codes, const Layout& layout, int filter) {
  const auto bytes = static_cast<std::size_t>(layout.bits / 8);
  const std::size_t pixel = bytes * static_cast<std::size_t>(layout.channels);
  const std::size_t row = pixel * static_cast<std::size_t>(layout.width);
  std::string above(row, '\0'), rows;
  for (int y = 0; y < layout.height; ++y) {
    std::string here;
    for (int x = 0; x < layout.width; ++x) {
      for (int c = 0; c < layout.channels; ++c) {
        if (bytes == 2) here += static_cast<char>(codes(x, y, c) >> 8);
        here += static_cast<char>(codes(x, y, c));
      }
    }
    const int used = filter == noisy_filter ? (y * 7 + y / 3) % 5 : filter;
    rows += static_cast<char>(used);
    const auto at = [](const std::string& of, std::size_t i) {
      return static_cast<int>(static_cast<unsigned char>(of[i]));
    };
    for (std::size_t i = 0; i < row; ++i) {
      const int left = i < pixel ? 0 : at(here, i - pixel), up = at(above, i);
      const int corner = i < pixel ? 0 : at(above, i - pixel);
      const std::array<int, 5> predicted{0, left, up, (left + up) / 2, paeth(left, up, corner)};
      rows += static_cast<char>(at(here, i) - predicted[static_cast<std::size_t>(used)]);
    }
    above = here;
  }
  return rows;
}

/// `colour` and `interlace` as in IHDR; `extra` stands before the data, which lie in chunks of 997
/// bytes.
std::string png_of(const Layout& layout, const std::string& rows, const std::string& extra = {},
                   char colour = '\0', char interlace = '\0') {
  std::string header;
  put_number(header, static_cast<std::size_t>(layout.width));
  put_number(header, static_cast<std::size_t>(layout.height));
  header += static_cast<char>(layout.bits);
  header += layout.channels == 3 ? '\2' : colour;
  header += std::string(2, '\0') + interlace;
  std::string packed(::compressBound(static_cast<uLong>(rows.size())), '\0');
  uLongf size = packed.size();
  ::compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
              reinterpret_cast<const Bytef*>(rows.data()), static_cast<uLong>(rows.size()), 6);
  packed.resize(size);
  std::string png = "\x89PNG\r\n\x1a\n" + chunk_of("IHDR", header) + extra;
  for (std::size_t at = 0; at < packed.size(); at += 997)
    png += chunk_of("IDAT", packed.substr(at, 997));
  return png + chunk_of("IEND", "");
}

Image<std::uint16_t> noisy_ramp(const Layout& layout) {
  Image<std::uint16_t> codes(layout.width, layout.height, layout.channels);
  std::mt19937 random(5);
  const unsigned top = layout.bits == 8 ? 0xFFU : 0xFFFFU;
  for (int y = 0; y < layout.height; ++y) {
    for (int x = 0; x < layout.width; ++x) {
      for (int c = 0; c < layout.channels; ++c) {
        const auto ramp = static_cast<unsigned>(37 * x + 91 * y + 1000 * c);
        codes(x, y, c) =
            static_cast<std::uint16_t>((x % 9 == 0 ? random() : ramp + random() % 30) & top);
      }
    }
  }
  return codes;
}

class PngReader : public FolderTest {
 protected:
  std::filesystem::path written(const std::string& png) const {
    write_text_atomically(folder_ / "a.png", png);
    return folder_ / "a.png";
  }
  static bool is_plain(const std::string& png) {
    return PlainPng::open(std::as_bytes(std::span(png))).has_value();
  }
};

// One pixel; odd widths; rows beyond a block of the reader.
TEST_F(PngReader, EveryFilterGivesTheCodesBack) {
  for (const int channels : {1, 3}) {
    for (const int bits : {8, 16}) {
      for (int filter = noisy_filter; filter < 5; ++filter) {
        for (const auto& [width, height] : {std::pair(1, 1), {131, 67}, {30011, 12}}) {
          const Layout layout{width, height, channels, bits};
          const Image<std::uint16_t> codes = noisy_ramp(layout);
          const std::string png = png_of(layout, filtered_rows(codes, layout, filter));
          ASSERT_TRUE(is_plain(png));
          const auto file = written(png);
          ASSERT_EQ(read_code_image(file).values(), codes.values()) << filter << ' ' << bits;
          if (width == 1) continue;
          const Region part{3, 5, 101, 7};
          ASSERT_EQ(read_code_image(file, {}, part).values(), cropped(codes, part).values());
        }
      }
    }
  }
}

TEST_F(PngReader, DamageBelowTheChecksumsIsRefused) {
  const Layout layout{131, 67, 3, 16};
  const std::string rows = filtered_rows(noisy_ramp(layout), layout, noisy_filter);
  std::string filter = rows;
  filter[0] = '\7';
  std::string stream = png_of(layout, rows);
  const std::size_t begin = stream.find("IDAT");
  stream.replace(begin + 4, 2, "\x79\x9c");  // no zlib header
  stream.replace(begin - 4, 4 + 4 + 997 + 4, chunk_of("IDAT", stream.substr(begin + 4, 997)));
  for (const std::string& png :
       {png_of(layout, rows.substr(0, rows.size() - 1)), png_of(layout, filter), stream}) {
    ASSERT_TRUE(is_plain(png));
    EXPECT_THAT(sentence_of([&] { read_code_image(written(png)); }),
                HasSubstr("a.png: damaged PNG image"));
  }
}

TEST_F(PngReader, OtherKindsAreLeftToOpenImageIo) {
  const Layout layout{131, 67, 1, 8};
  const Image<std::uint16_t> codes = noisy_ramp(layout);
  const std::string rows = filtered_rows(codes, layout, 4);
  const std::string transparent = png_of(layout, rows, chunk_of("tRNS", std::string("\0\3", 2)));
  EXPECT_FALSE(is_plain(transparent));
  EXPECT_EQ(read_code_image(written(transparent)).values(), codes.values());
  EXPECT_TRUE(is_plain(png_of(layout, rows, chunk_of("tEXt", "Title"))));
  EXPECT_FALSE(is_plain(png_of(layout, rows, chunk_of("NEWC", "unknown and critical"))));
  EXPECT_FALSE(is_plain(png_of(layout, rows, {}, '\3')));
  EXPECT_FALSE(is_plain(png_of(layout, rows, {}, '\4')));
  EXPECT_FALSE(is_plain(png_of(layout, rows, {}, '\0', '\1')));
  EXPECT_FALSE(is_plain("\x89PNG\r\n\x1a\n"));
}

}  // namespace
}  // namespace kappamu::io

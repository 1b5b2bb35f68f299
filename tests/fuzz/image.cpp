// Photographs, pictures, HDR files and EXIF.
#include "io/image/exr.h"
#include "io/image/image_file.h"
#include "io/image/photo_settings.h"
#include "io/image/raw_file.h"
#include "io/read_file.h"
#include "tests/fuzz/targets.h"

namespace kappamu::fuzz {

namespace fs = std::filesystem;

namespace {

/// A RAW of 32 x 24 sites: the least that LibRaw takes for a DNG.
std::vector<std::uint8_t> tiny_dng() {
  constexpr unsigned width = 32;
  constexpr unsigned height = 24;
  struct Tag {
    unsigned id;
    unsigned type;  // 1 BYTE, 3 SHORT, 4 LONG
    unsigned count;
    unsigned value;
  };
  constexpr unsigned cfa = 0x02010100;  // R, G, G, B
  const std::vector<Tag> tags{{254, 4, 1, 0},
                              {256, 4, 1, width},
                              {257, 4, 1, height},
                              {258, 3, 1, 16},
                              {259, 3, 1, 1},
                              {262, 3, 1, 32803},
                              {273, 4, 1, 512},
                              {277, 3, 1, 1},
                              {278, 4, 1, height},
                              {279, 4, 1, 2 * width * height},
                              {33421, 3, 2, 0x00020002},
                              {33422, 1, 4, cfa},
                              {50706, 1, 4, 0x0401},
                              {50714, 4, 1, 64},
                              {50717, 4, 1, 4095}};
  std::vector<std::uint8_t> bytes{'I', 'I', 42, 0, 8, 0, 0, 0};
  const auto put = [&](unsigned value, int size) {
    for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
  };
  put(static_cast<unsigned>(tags.size()), 2);
  for (const Tag& tag : tags) {
    put(tag.id, 2);
    put(tag.type, 2);
    put(tag.count, 4);
    put(tag.value, 4);
  }
  bytes.resize(512);
  for (unsigned i = 0; i < width * height; ++i) put(64 + 5 * i, 2);
  return bytes;
}

/// The first byte chooses the reader, since each takes its files by their own beginning.
void (*const readers[])(const fs::path& file) = {
    [](const fs::path& file) { io::read_code_image(file); },
    [](const fs::path& file) { io::read_float_image(file); },
    [](const fs::path& file) { io::read_raw(file); },
    [](const fs::path& file) { io::read_photo_settings(file); },
    [](const fs::path& file) { io::read_exr(file); },
    [](const fs::path& file) {
      // Four bytes of ours are the layout.
      const std::vector<std::byte> bytes = io::read_bytes(file);
      if (bytes.size() < 4) return;
      const auto number = [&](std::size_t k) { return std::to_integer<int>(bytes[k]); };
      io::read_headerless_raw(file, {(number(0) & 1) != 0 ? 8 : 16, (number(0) & 2) != 0, 4, {}},
                              1 + number(1), 1 + number(2) + 256 * number(3));
    },
};

void seed_for(char reader, const fs::path& seeds, const std::string& name, Bytes bytes) {
  std::string content(1, reader);
  content.append(bytes.begin(), bytes.end());
  write(seeds / name, bytes_of(content));
}

}  // namespace

void read_image(Bytes bytes) {
  if (bytes.empty()) return;
  write(folder() / "image", bytes.subspan(1));
  readers[bytes.front() % std::size(readers)](folder() / "image");
}

void seed_image(const fs::path& seeds) {
  Image<std::uint16_t> codes(9, 7, 3);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    codes.values()[i] = static_cast<std::uint16_t>(331 * i);
  }
  io::write_image(folder() / "a.png", codes);
  io::write_image(folder() / "a.tif", codes);
  io::write_float_image(folder() / "a.exr", Image<float>(9, 7, 3, 0.25F));
  const auto content = [](const char* name) { return io::read_text(folder() / name); };
  for (const char* name : {"a.png", "a.tif"}) {
    seed_for(0, seeds, std::string("code_") + name, bytes_of(content(name)));
    seed_for(3, seeds, std::string("settings_") + name, bytes_of(content(name)));
  }
  seed_for(1, seeds, "float_a.exr", bytes_of(content("a.exr")));
  seed_for(4, seeds, "layers_a.exr", bytes_of(content("a.exr")));
  seed_for(2, seeds, "raw_a.dng", tiny_dng());
  seed_for(5, seeds, "headerless_a.raw",
           std::vector<std::uint8_t>{0, 1, 1, 0, 1, 2, 3, 4, 5, 6, 7, 8});
  const std::vector<std::uint8_t> jpeg = io::encode_jpeg(Image<std::uint8_t>(16, 16, 3, 90), 80);
  seed_for(0, seeds, "code_a.jpg", jpeg);
  seed_for(3, seeds, "settings_a.jpg", jpeg);
}

}  // namespace kappamu::fuzz

// make_seeds FOLDER FORMATS.MD: small good inputs for the fuzzers to begin from.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "io/image/image_file.h"
#include "io/image/raw_file.h"
#include "io/read_file.h"

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

}  // namespace

int main(int argc, char** argv) {
  using namespace kappamu;
  namespace fs = std::filesystem;
  if (argc != 3) {
    std::cerr << "usage: make_seeds FOLDER FORMATS.MD\n";
    return 2;
  }
  const fs::path folder = argv[1];
  fs::create_directories(folder / "session");
  fs::create_directories(folder / "image");
  const std::string text = io::read_text(argv[2]);
  const std::size_t begin = text.find("```json\n") + 8;
  std::ofstream(folder / "session" / "documented.json")
      << text.substr(begin, text.find("```", begin) - begin);

  // The image fuzzer's first byte chooses the reader.
  const auto seed = [&](const std::string& name, char reader, std::span<const std::byte> bytes) {
    std::ofstream out(folder / "image" / name, std::ios::binary);
    out.put(reader);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  };
  Image<std::uint16_t> codes(9, 7, 3);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    codes.values()[i] = static_cast<std::uint16_t>(331 * i);
  }
  io::write_image(folder / "a.png", codes);
  io::write_image(folder / "a.tif", codes);
  io::write_float_image(folder / "a.exr", Image<float>(9, 7, 3, 0.25F));
  for (const char* name : {"a.png", "a.tif", "a.exr"}) {
    const std::vector<std::byte> bytes = io::read_bytes(folder / name);
    seed(std::string("code_") + name, 0, bytes);
    seed(std::string("float_") + name, 1, bytes);
    seed(std::string("raw_") + name, 2, bytes);
    seed(std::string("settings_") + name, 3, bytes);
    fs::remove(folder / name);
  }
  const std::vector<std::uint8_t> dng = tiny_dng();
  std::ofstream(folder / "a.dng", std::ios::binary)
      .write(reinterpret_cast<const char*>(dng.data()), static_cast<std::streamsize>(dng.size()));
  io::read_raw(folder / "a.dng");  // a seed that is refused would be none
  fs::remove(folder / "a.dng");
  seed("raw_a.dng", 2, std::as_bytes(std::span(dng)));
  const auto jpeg = io::encode_jpeg(Image<std::uint8_t>(16, 16, 3, 90), 80);
  seed("code_a.jpg", 0, std::as_bytes(std::span(jpeg)));
  seed("settings_a.jpg", 3, std::as_bytes(std::span(jpeg)));
  return 0;
}

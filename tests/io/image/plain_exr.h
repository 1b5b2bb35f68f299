// Uncompressed EXR files as other programs write them, with all that ours do not have: windows,
// parts, subsampled channels, deep samples (OpenEXR file layout).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

namespace kappamu::io {

struct PlainExr {
  struct Channel {
    std::string name;
    float value;       ///< everywhere
    int sampling = 1;  ///< every such pixel and row
  };
  std::vector<Channel> channels;
  std::array<int, 4> data{0, 0, 15, 7};     ///< window: left, top, right, bottom
  std::array<int, 4> display{0, 0, 15, 7};  ///< the same
  std::string name{};                       ///< of a part
  int cube = -1;                            ///< attribute envmap: 1 is a cube map
  bool deep = false;                        ///< one sample a pixel
  std::vector<float> chromaticities{};      ///< x and y of red, green, blue, white
};

inline void put_number(std::string& to, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) to += static_cast<char>(value >> 8 * i & 0xFFU);
}

inline void put_attribute(std::string& to, const char* name, const char* type,
                          const std::string& value) {
  to.append(name).append(1, '\0').append(type).append(1, '\0');
  put_number(to, value.size(), 4);
  to += value;
}

/// Rows of the part as chunks, uncompressed.
inline std::vector<std::string> exr_chunks(const PlainExr& part) {
  const auto [left, top, right, bottom] = part.data;
  std::vector<std::string> chunks;
  for (int y = top; y <= bottom; ++y) {
    std::string samples, chunk;
    for (const PlainExr::Channel& channel : part.channels) {
      for (int x = left; y % channel.sampling == 0 && x <= right; x += channel.sampling) {
        put_number(samples, std::bit_cast<std::uint32_t>(channel.value), 4);
      }
    }
    put_number(chunk, static_cast<std::uint32_t>(y), 4);
    if (part.deep) {
      std::string counts;
      for (int x = left; x <= right; ++x) {
        put_number(counts, static_cast<std::uint32_t>(x - left + 1), 4);
      }
      put_number(chunk, counts.size(), 8);
      put_number(chunk, samples.size(), 8);
      put_number(chunk, samples.size(), 8);
      chunk += counts;
    } else {
      put_number(chunk, samples.size(), 4);
    }
    chunks.push_back(chunk + samples);
  }
  return chunks;
}

inline std::string plain_exr(std::vector<PlainExr> parts) {
  const bool several = parts.size() > 1;
  std::string bytes("\x76\x2f\x31\x01", 4);
  put_number(bytes, 2U | (several ? 0x1000U : 0U) | (parts[0].deep ? 0x800U : 0U), 4);
  std::vector<std::vector<std::string>> chunks;
  for (PlainExr& part : parts) {
    std::sort(part.channels.begin(), part.channels.end(),
              [](const auto& a, const auto& b) { return a.name < b.name; });
    chunks.push_back(exr_chunks(part));
    std::string list, window, display;
    for (const PlainExr::Channel& channel : part.channels) {
      list.append(channel.name).append(1, '\0');
      put_number(list, 2, 4);  // float
      put_number(list, 0, 4);
      put_number(list, static_cast<std::uint64_t>(channel.sampling), 4);
      put_number(list, static_cast<std::uint64_t>(channel.sampling), 4);
    }
    list += '\0';
    for (const int at : part.data) put_number(window, static_cast<std::uint32_t>(at), 4);
    for (const int at : part.display) put_number(display, static_cast<std::uint32_t>(at), 4);
    std::string one, count;
    put_number(one, std::bit_cast<std::uint32_t>(1.0F), 4);
    put_number(count, chunks.back().size(), 4);
    put_attribute(bytes, "channels", "chlist", list);
    if (!part.chromaticities.empty()) {
      std::string numbers;
      for (const float x : part.chromaticities) {
        put_number(numbers, std::bit_cast<std::uint32_t>(x), 4);
      }
      put_attribute(bytes, "chromaticities", "chromaticities", numbers);
    }
    put_attribute(bytes, "compression", "compression", std::string(1, '\0'));
    put_attribute(bytes, "dataWindow", "box2i", window);
    put_attribute(bytes, "displayWindow", "box2i", display);
    if (part.cube >= 0) {
      put_attribute(bytes, "envmap", "envmap", std::string(1, static_cast<char>(part.cube)));
    }
    put_attribute(bytes, "lineOrder", "lineOrder", std::string(1, '\0'));
    put_attribute(bytes, "pixelAspectRatio", "float", one);
    put_attribute(bytes, "screenWindowCenter", "v2f", std::string(8, '\0'));
    put_attribute(bytes, "screenWindowWidth", "float", one);
    if (several || part.deep) {
      put_attribute(bytes, "name", "string", part.name.empty() ? "part" : part.name);
      put_attribute(bytes, "type", "string", part.deep ? "deepscanline" : "scanlineimage");
      put_attribute(bytes, "chunkCount", "int", count);
    }
    if (part.deep) {
      put_attribute(bytes, "version", "int", std::string("\x01\0\0\0", 4));
      put_attribute(bytes, "maxSamplesPerPixel", "int", std::string("\x01\0\0\0", 4));
    }
    bytes += '\0';
  }
  if (several) bytes += '\0';
  std::size_t at = bytes.size();
  for (const auto& rows : chunks) at += 8 * rows.size();
  std::string body;
  for (std::size_t p = 0; p < chunks.size(); ++p) {
    for (const std::string& chunk : chunks[p]) {
      put_number(bytes, at + body.size(), 8);
      if (several) put_number(body, p, 4);
      body += chunk;
    }
  }
  return bytes + body;
}

}  // namespace kappamu::io

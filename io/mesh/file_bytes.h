// What readers of mesh files take from a file's bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

namespace kappamu::io {

inline std::string_view text_of(std::span<const std::byte> file) {
  return {reinterpret_cast<const char*>(file.data()), file.size()};
}

/// Little endian, of the four bytes at `offset`, which the file must have.
inline std::uint32_t word_at(std::span<const std::byte> file, std::size_t offset) {
  std::uint32_t value = 0;
  std::memcpy(&value, file.data() + offset, sizeof value);
  return value;
}

}  // namespace kappamu::io

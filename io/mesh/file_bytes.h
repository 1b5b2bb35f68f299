// What readers of mesh files take from a file's bytes.
#pragma once

#include <algorithm>
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

/// Takes the next line, without its end, off `text`.
inline std::string_view next_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

/// Takes the next word, an empty one where there is none, and white space before it.
inline std::string_view next_word(std::string_view& line) {
  constexpr std::string_view white = " \t\r\n";
  const std::size_t begin = std::min(line.find_first_not_of(white), line.size());
  line.remove_prefix(begin);
  const std::string_view word = line.substr(0, line.find_first_of(white));
  line.remove_prefix(word.size());
  return word;
}

}  // namespace kappamu::io

// What readers of mesh files take from a file's bytes.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>

namespace kappamu::io {

/// The file as text, without the byte order mark of UTF-8.
inline std::string_view text_of(std::span<const std::byte> file) {
  std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

/// Little endian, of the four bytes at `offset`, which the file must have.
inline std::uint32_t word_at(std::span<const std::byte> file, std::size_t offset) {
  std::uint32_t value = 0;
  std::memcpy(&value, file.data() + offset, sizeof value);
  return value;
}

/// Takes the next line, without its end, off `text`: LF, CR LF or CR.
inline std::string_view next_line(std::string_view& text) {
  const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end);
  text.remove_prefix(text.starts_with("\r\n") ? 2 : std::min<std::size_t>(text.size(), 1));
  return line;
}

/// Takes the next word, an empty one where there is none, and white space before it.
inline std::string_view next_word(std::string_view& line) {
  constexpr std::string_view white = " \t\v\f\r\n";
  const std::size_t begin = std::min(line.find_first_not_of(white), line.size());
  line.remove_prefix(begin);
  const std::string_view word = line.substr(0, line.find_first_of(white));
  line.remove_prefix(word.size());
  return word;
}

/// The whole word as a finite number, if it is one; what is too small for one is 0.
inline std::optional<double> finite_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.begin(), word.end(), value);
  if (error == std::errc::result_out_of_range && end == word.end() &&
      (word.find("e-") != word.npos || word.find("E-") != word.npos)) {
    return 0.0;
  }
  if (error != std::errc() || end != word.end() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace kappamu::io

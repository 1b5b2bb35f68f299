// Text read word by word or line by line.
#pragma once

#include <ios>
#include <sstream>
#include <string>
#include <utility>

namespace kappamu::io {

/// Throws std::bad_alloc where memory is short; std::getline and >> of other streams take that for
/// the end of the text.
inline std::istringstream text_reader(std::string text) {
  std::istringstream stream(std::move(text));
  stream.exceptions(std::ios::badbit);
  return stream;
}

}  // namespace kappamu::io

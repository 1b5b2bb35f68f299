// What a JSON library's exception says, for one of our sentences.
#pragma once

#include <exception>
#include <string>

namespace kappamu::io {

/// Without the library's tag ("[json.exception.parse_error.101] ").
inline std::string json_reason(const std::exception& error) {
  const std::string text = error.what();
  const std::size_t tag = text.starts_with("[json.exception") ? text.find("] ") : std::string::npos;
  return tag == std::string::npos ? text : text.substr(tag + 2);
}

}  // namespace kappamu::io

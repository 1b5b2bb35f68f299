// What a JSON library's exception says, for one of our sentences.
#pragma once

#include <exception>
#include <string>

namespace kappamu::io {

/// Without the library's tag ("[json.exception.parse_error.101] "), wherever in a sentence it
/// stands.
inline std::string json_reason(const std::exception& error) {
  std::string text = error.what();
  const std::size_t tag = text.find("[json.exception");
  const std::size_t end = tag == std::string::npos ? tag : text.find("] ", tag);
  return end == std::string::npos ? text : text.erase(tag, end + 2 - tag);
}

}  // namespace kappamu::io

#include "tests/capture/session_files.h"

#include <fstream>
#include <stdexcept>

namespace kappamu::capture {

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::string documented_session_text() {
  const std::string text =
      read_text(std::filesystem::path(KAPPAMU_SOURCE_DIR) / "docs" / "formats.md");
  const std::size_t begin = text.find("```json\n");
  const std::size_t end = text.find("```", begin + 8);
  if (begin == std::string::npos || end == std::string::npos) {
    throw std::runtime_error("docs/formats.md holds no JSON example");
  }
  return text.substr(begin + 8, end - begin - 8);
}

}  // namespace kappamu::capture

#include "tests/capture/session_files.h"

#include <stdlib.h>

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace kappamu::capture {

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "kappamu-capture-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp failed for " + name);
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
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

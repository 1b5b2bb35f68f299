// Shared by capture's tests: temporary folders, the documented example session.
#pragma once

#include <filesystem>
#include <string>

namespace kappamu::capture {

/// A folder of its own for one test, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The JSON example of docs/formats.md, word for word.
std::string documented_session_text();

void write_text(const std::filesystem::path& file, const std::string& text);
std::string read_text(const std::filesystem::path& file);

}  // namespace kappamu::capture

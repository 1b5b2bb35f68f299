// A fuzzer's bytes as files for readers that take paths, and small good files to begin from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kappamu::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// A folder of this process, removed when it ends.
const std::filesystem::path& folder();

void write(const std::filesystem::path& file, Bytes bytes);
inline Bytes bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// Files that belong together, all good but one, which the first byte chooses and the rest
/// replaces.
class Files {
 public:
  /// Relative to `folder`, which holds them.
  Files(std::filesystem::path folder, const std::vector<std::string>& names);
  /// Calls `read` with one file replaced, and puts the good one back.
  template <class Read>
  void with(Bytes bytes, const Read& read) const {
    if (bytes.empty()) return;
    const File& file = files_[bytes.front() % files_.size()];
    const Restored restored{path_ / file.name, file.content};
    write(path_ / file.name, bytes.subspan(1));
    read();
  }
  /// Each good file as a seed.
  void seed(const std::filesystem::path& seeds) const;
  const std::filesystem::path& path() const { return path_; }

 private:
  struct File {
    std::string name;
    std::string content;
  };
  struct Restored {
    std::filesystem::path file;
    const std::string& content;
    ~Restored() { write(file, bytes_of(content)); }
  };
  std::filesystem::path path_;
  std::vector<File> files_;
};

}  // namespace kappamu::fuzz

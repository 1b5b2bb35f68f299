#include "tests/fuzz/fuzz_file.h"

#include <cstdlib>
#include <exception>
#include <fstream>
#include <system_error>

#include "io/read_file.h"

namespace kappamu::fuzz {

namespace fs = std::filesystem;

const fs::path& folder() {
  static const struct Folder {
    fs::path path;
    Folder() {
      std::string made = (fs::temp_directory_path() / "kappamu-fuzz-XXXXXX").string();
      if (mkdtemp(made.data()) == nullptr) std::terminate();
      path = made;
    }
    ~Folder() {
      std::error_code ignored;
      fs::remove_all(path, ignored);
    }
  } made;
  return made.path;
}

void write(const fs::path& file, Bytes bytes) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

Files::Files(fs::path folder, const std::vector<std::string>& names) : path_(std::move(folder)) {
  for (const std::string& name : names) files_.push_back({name, io::read_text(path_ / name)});
}

void Files::seed(const fs::path& seeds) const {
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const std::string content = static_cast<char>(i) + files_[i].content;
    write(seeds / fs::path(files_[i].name).filename(), bytes_of(content));
  }
}

}  // namespace kappamu::fuzz

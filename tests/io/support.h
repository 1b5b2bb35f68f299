// What the tests of io share: a folder of their own, expected sentences, damaged copies.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/read_file.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::io {

/// A fresh folder per test, removed afterwards.
class FolderTest : public testing::Test {
 protected:
  /// All files and folders below the test's folder.
  std::vector<std::string> listing() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_)) {
      names.push_back(entry.path().filename().string());
    }
    return names;
  }

  const OwnFolder own_;
  const std::filesystem::path& folder_ = own_.path();
};

/// Overwrites `file` with its first `size` bytes.
inline void truncate_to(const std::filesystem::path& file, std::size_t size) {
  std::filesystem::resize_file(file, size);
}

/// Calls `read` on every truncation of `file` on a coarse ladder of sizes, and expects InputError
/// naming the file from each.
template <class Read>
void expect_truncations_are_refused(const std::filesystem::path& file, const Read& read) {
  const std::vector<std::byte> whole = read_bytes(file);
  ASSERT_NO_THROW(read(file));
  std::vector<std::size_t> sizes{0, 1, 5, 9, 20, 47, whole.size() - 1, whole.size() - 5};
  for (int i = 1; i < 16; ++i) sizes.push_back(whole.size() * static_cast<std::size_t>(i) / 16);
  for (const std::size_t size : sizes) {
    if (size >= whole.size()) continue;
    write_bytes_atomically(file, std::span(whole).first(size));
    const std::string sentence = sentence_of([&] { read(file); });
    EXPECT_THAT(sentence, testing::HasSubstr(file.filename().string())) << "at size " << size;
  }
  write_bytes_atomically(file, whole);
}

}  // namespace kappamu::io

// A fuzzer's bytes as a file for readers that take a path.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/error.h"

namespace kappamu {

/// Writes the bytes to `name` in a folder of this process and gives the path.
inline std::filesystem::path fuzz_file(const std::uint8_t* data, std::size_t size,
                                       const std::string& name) {
  static const std::filesystem::path folder = [] {
    std::string made = (std::filesystem::temp_directory_path() / "kappamu-fuzz-XXXXXX").string();
    if (mkdtemp(made.data()) == nullptr) std::terminate();
    static const struct Remover {
      std::filesystem::path path;
      ~Remover() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
      }
    } remover{made};
    return std::filesystem::path(made);
  }();
  const std::filesystem::path file = folder / name;
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return file;
}

/// Bad input may be refused; any other exception is a bug and ends the fuzzer.
template <class Act>
void refused_or_read(const Act& act) {
  try {
    act();
  } catch (const InputError&) {
  }
}

}  // namespace kappamu

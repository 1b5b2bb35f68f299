// References that nobody here made. Small ones are shipped in tests/data, each folder with its
// source and licence; larger ones may lie beside the source folder.
#pragma once

#include <filesystem>
#include <string>

namespace kappamu {

/// Where the reference `name` would be; tests skip where that does not exist.
inline std::filesystem::path reference_data(const std::string& name) {
  const std::filesystem::path source = KAPPAMU_SOURCE_DIR;
  const std::filesystem::path shipped = source / "tests" / "data" / name;
  return std::filesystem::exists(shipped) ? shipped
                                          : source.parent_path() / "shared" / "data" / name;
}

}  // namespace kappamu

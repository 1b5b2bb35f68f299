// Fingerprints that tell whether a stage's inputs are still the same.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/numbers/fnv.h"

namespace kappamu::pipeline {

/// Of 64 bits (core/numbers/fnv.h).
class Fingerprint {
 public:
  /// Adds a piece of text; ("ab", "c") and ("a", "bc") differ.
  Fingerprint& add(std::string_view piece);
  /// Adds name and contents of a file, or that it is missing.
  Fingerprint& add_file(const std::filesystem::path& file);
  /// 16 hexadecimal digits.
  std::string text() const;

 private:
  Fnv hash_;
};

/// XXH3 (64 bit, 16 hexadecimal digits) of contents that come piece by piece.
class ContentFingerprint {
 public:
  ContentFingerprint();
  ~ContentFingerprint();
  void add(std::span<const char> piece);
  std::string text() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Of files whose contents passed by as they were written, by their paths in a folder.
using KnownFingerprints = std::map<std::string, std::string>;

/// ContentFingerprint of a file. Throws InputError when it cannot be
/// read.
std::string content_fingerprint(const std::filesystem::path& file);

/// Of this program itself: equal programs give equal bits from equal inputs, another build may not.
const std::string& program_fingerprint();

/// The files of a folder of measurements that are there.
std::vector<std::string> measurement_files(const std::filesystem::path& folder);

/// Of the contents of all files of a folder of measurements.
std::string measurements_fingerprint(const std::filesystem::path& folder);

}  // namespace kappamu::pipeline

#include "pipeline/records/fingerprint.h"

#include <array>
#include <cstdio>
#include <span>
#include <system_error>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "io/read_file.h"

namespace kappamu::pipeline {

namespace {

std::string hexadecimal(std::uint64_t value) {
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(value));
  return digits.data();
}

}  // namespace

Fingerprint& Fingerprint::add(std::string_view piece) {
  hash_.add(piece.data(), piece.size());
  const std::uint64_t length = piece.size();
  hash_.add(&length, sizeof length);
  return *this;
}

Fingerprint& Fingerprint::add_file(const std::filesystem::path& file) {
  add(file.filename().string());
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return add("missing");
  return add(content_fingerprint(file));
}

std::string Fingerprint::text() const {
  return hexadecimal(hash_.value());
}

struct ContentFingerprint::State {
  XXH3_state_t hash;
};

ContentFingerprint::ContentFingerprint() : state_(std::make_unique<State>()) {
  XXH3_64bits_reset(&state_->hash);
}
ContentFingerprint::~ContentFingerprint() = default;

void ContentFingerprint::add(std::span<const char> piece) {
  XXH3_64bits_update(&state_->hash, piece.data(), piece.size());
}

std::string ContentFingerprint::text() const {
  return hexadecimal(XXH3_64bits_digest(&state_->hash));
}

std::string content_fingerprint(const std::filesystem::path& file) {
  ContentFingerprint result;
  io::read_parts(file, [&](std::span<const char> part) { result.add(part); });
  return result.text();
}

const std::string& program_fingerprint() {
  static const std::string program = content_fingerprint("/proc/self/exe");
  return program;
}

std::vector<std::string> measurement_files(const std::filesystem::path& folder) {
  std::vector<std::string> files;
  for (const char* name : {"measurements.json", "irradiance.npy", "value.npy", "variance.npy",
                           "mask.npy", "lit.npy"}) {
    if (std::filesystem::exists(folder / name)) files.emplace_back(name);
  }
  return files;
}

std::string measurements_fingerprint(const std::filesystem::path& folder) {
  Fingerprint result;
  for (const std::string& name : measurement_files(folder)) result.add_file(folder / name);
  return result.text();
}

}  // namespace kappamu::pipeline

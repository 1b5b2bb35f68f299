#include "pipeline/records/fingerprint.h"

#include <array>
#include <cstdio>
#include <fstream>
#include <limits>
#include <system_error>
#include <vector>

#include "capture/session/session_files.h"
#include "core/error.h"

namespace kappamu::pipeline {

Fingerprint& Fingerprint::add(std::string_view piece) {
  return add_bytes(piece).add_length(piece.size());
}

Fingerprint& Fingerprint::add_bytes(std::string_view bytes) {
  constexpr std::uint64_t prime = 1099511628211ULL;
  for (const char c : bytes) state_ = (state_ ^ static_cast<unsigned char>(c)) * prime;
  return *this;
}

Fingerprint& Fingerprint::add_length(std::size_t length) {
  std::array<char, 8> digits{};
  for (char& digit : digits) {
    digit = static_cast<char>(length & 0xFFU);
    length >>= 8U;
  }
  return add_bytes({digits.data(), digits.size()});
}

Fingerprint& Fingerprint::add_file(const std::filesystem::path& file) {
  add(file.filename().string());
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) return add("missing");
  const auto time = std::filesystem::last_write_time(file, error);
  if (error) return add("missing");
  return add(std::to_string(size)).add(std::to_string(time.time_since_epoch().count()));
}

std::string Fingerprint::text() const {
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(state_));
  return digits.data();
}

std::string content_fingerprint(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<char> buffer(1 << 16);
  Fingerprint result;
  std::size_t size = 0;
  while (in) {
    in.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    const auto count = static_cast<std::size_t>(in.gcount());
    result.add_bytes({buffer.data(), count});
    size += count;
  }
  if (!in.eof()) {
    throw InputError("cannot read " + file.string() + "; check that it is there and readable");
  }
  return result.add_length(size).text();
}

const std::string& program_fingerprint() {
  static const std::string program = content_fingerprint("/proc/self/exe");
  return program;
}

std::string session_fingerprint(const capture::Session& session) {
  Fingerprint result;
  result.add(content_fingerprint(session.folder / "session.json"));
  for (const std::string& file : capture::named_files(session)) {
    result.add_file(session.folder / file);
  }
  return result.text();
}

std::string measurements_fingerprint(const std::filesystem::path& folder) {
  Fingerprint result;
  result.add(content_fingerprint(folder / "measurements.json"));
  for (const char* name : {"irradiance.npy", "value.npy", "variance.npy", "mask.npy"})
    result.add_file(folder / name);
  return result.text();
}

}  // namespace kappamu::pipeline

#include "pipeline/stages/checkpoint_files.h"

#include <algorithm>
#include <fstream>
#include <utility>

#include "io/atomic_file.h"

namespace kappamu::pipeline {

namespace fs = std::filesystem;

namespace {

/// Empty where it is too long or cannot be read.
std::vector<std::byte> read_bytes(const fs::path& file, std::size_t most_bytes) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (error || size > most_bytes) return {};
  std::vector<std::byte> bytes(size);
  std::ifstream in(file, std::ios::binary);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!in) return {};
  return bytes;
}

}  // namespace

CheckpointFiles::CheckpointFiles(fs::path newest, std::size_t most_bytes)
    : newest_(std::move(newest)), previous_(newest_), most_bytes_(most_bytes) {
  previous_.replace_extension(".previous" + newest_.extension().string());
}

void CheckpointFiles::save(std::span<const std::byte> bytes) const {
  // Killed between the two there is no newest one, and load() begins with the one before.
  std::error_code none;
  fs::rename(newest_, previous_, none);
  io::write_bytes_atomically(newest_, bytes);
}

std::optional<std::vector<std::byte>> CheckpointFiles::load() {
  std::error_code ignored;
  if (!tried_.empty()) fs::remove(tried_.back(), ignored);
  for (const fs::path& file : {newest_, previous_}) {
    const bool tried = std::find(tried_.begin(), tried_.end(), file) != tried_.end();
    if (tried || !fs::exists(file, ignored)) continue;
    tried_.push_back(file);
    return read_bytes(file, most_bytes_);
  }
  return std::nullopt;
}

void CheckpointFiles::remove() const {
  fs::remove(newest_);
  fs::remove(previous_);
}

}  // namespace kappamu::pipeline

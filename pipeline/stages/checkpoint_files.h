// Where a fit's checkpoints lie: the newest, and the one before for when the newest is damaged.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace kappamu::pipeline {

class CheckpointFiles {
 public:
  /// `newest` is FOLDER/NAME.bin; the one before is FOLDER/NAME.previous.bin. Longer files than
  /// `most_bytes` are not read.
  CheckpointFiles(std::filesystem::path newest, std::size_t most_bytes);

  /// The newest becomes the one before.
  void save(std::span<const std::byte> bytes) const;
  /// The newest, on the next call the one before, then nothing. Another call means that what came
  /// last is of no use: its file is removed, so that it never takes a good one's place.
  std::optional<std::vector<std::byte>> load();
  void remove() const;

 private:
  std::filesystem::path newest_;
  std::filesystem::path previous_;
  std::size_t most_bytes_;
  std::vector<std::filesystem::path> tried_;
};

}  // namespace kappamu::pipeline

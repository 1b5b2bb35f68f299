// Device memory that several users need in turn, never at the same time: the set-up of the levels
// and the vectors of conjugate gradients. Of one pattern the former takes more, of many the latter.
#pragma once

#include <cstddef>
#include <vector>

#include "device/context.h"

namespace kappamu::forward {

class Workspace {
 public:
  explicit Workspace(device::Context& context) : context_(context) {}

  /// The next user begins: what was taken before stays valid memory, but will be overwritten.
  /// Pieces smaller than `least` bytes, the smallest large one that comes, are given back.
  void begin(std::size_t least);
  /// Uninitialised; a part of a piece that has room, or a piece of its own.
  device::Buffer take(std::size_t bytes);

 private:
  struct Piece {
    device::Buffer memory;
    std::size_t used = 0;
  };
  device::Context& context_;
  std::vector<Piece> pieces_;
};

}  // namespace kappamu::forward

#include "forward/grid/opencl/multigrid/workspace.h"

namespace kappamu::forward {

void Workspace::begin(std::size_t least) {
  std::erase_if(pieces_, [&](const Piece& piece) { return piece.memory.bytes() < least; });
  for (Piece& piece : pieces_) piece.used = 0;
}

device::Buffer Workspace::take(std::size_t bytes) {
  constexpr std::size_t unit = device::Context::part_alignment;
  for (Piece& piece : pieces_) {
    if (piece.used + bytes > piece.memory.bytes()) continue;
    const device::Buffer part = context_.part(piece.memory, piece.used, bytes);
    piece.used += (bytes + unit - 1) / unit * unit;
    return part;
  }
  pieces_.push_back({context_.allocate(bytes), bytes});
  return pieces_.back().memory;
}

}  // namespace kappamu::forward

// Large blocks of memory that are freed and soon wanted again. The kernel clears what it gives,
// which takes as long as merging what a stack of photographs puts there.
#pragma once

#include <cstddef>

namespace kappamu {

/// While one lives, large blocks that are freed are kept for those who ask for as much next, in
/// programs whose operator new asks here first (app/large_memory.cpp).
class KeepsBlocks {
 public:
  /// Blocks in use and kept ones together hold at most `spare` bytes more than those in use once
  /// did. Of several the last one's `spare` counts.
  explicit KeepsBlocks(std::size_t spare = 0);
  KeepsBlocks(const KeepsBlocks&) = delete;
  KeepsBlocks& operator=(const KeepsBlocks&) = delete;
  /// The last of them gives all kept blocks back.
  ~KeepsBlocks();
};

/// From here on a block is large [bytes].
inline constexpr std::size_t large_block = std::size_t{1} << 22;

/// A kept block of `size` bytes or up to an eighth more; null where there is none. Then the caller
/// takes new memory, and the longest kept blocks go that it would make too many.
void* take_kept_block(std::size_t size);

/// Whether the block, from malloc() and of `size` bytes, is kept. The caller frees it otherwise.
bool keep_block(void* block, std::size_t size);

}  // namespace kappamu

#include "core/memory/kept_blocks.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <mutex>

namespace kappamu {

namespace {

struct Block {
  void* begin;
  std::size_t size;
};

/// All of it lies in static memory: operator new calls it.
class Store {
 public:
  void open(std::size_t spare) {
    const std::lock_guard lock(mutex_);
    ++users_;
    spare_ = spare;
  }
  void close() {
    const std::lock_guard lock(mutex_);
    if (--users_ > 0) return;
    while (count_ > 0) drop_oldest();
  }
  void* take(std::size_t size) {
    const std::lock_guard lock(mutex_);
    Block* const end = blocks_.data() + count_;
    Block* best = end;
    for (Block* block = blocks_.data(); block != end; ++block) {
      const bool fits = block->size >= size && block->size - size <= size / 8;
      if (fits && (best == end || block->size < best->size)) best = block;
    }
    if (best != end) {
      void* const found = best->begin;
      remove(best);
      return found;
    }
    for (std::size_t dropped = 0; dropped < size && kept_ > spare_;) dropped += drop_oldest();
    return nullptr;
  }
  bool keep(void* begin, std::size_t size) {
    const std::lock_guard lock(mutex_);
    if (users_ == 0) return false;
    if (count_ == blocks_.size()) drop_oldest();
    blocks_[count_++] = {begin, size};
    kept_ += size;
    return true;
  }

 private:
  void remove(Block* block) {
    kept_ -= block->size;
    std::copy(block + 1, blocks_.data() + count_, block);
    --count_;
  }
  std::size_t drop_oldest() {
    const Block block = blocks_.front();
    std::free(block.begin);
    remove(blocks_.data());
    return block.size;
  }

  std::mutex mutex_;
  int users_ = 0;
  std::size_t count_ = 0, kept_ = 0, spare_ = 0;
  std::array<Block, 64> blocks_{};  ///< the longest kept first
};

constinit Store store;

}  // namespace

KeepsBlocks::KeepsBlocks(std::size_t spare) {
  store.open(spare);
}
KeepsBlocks::~KeepsBlocks() {
  store.close();
}

void* take_kept_block(std::size_t size) {
  return store.take(size);
}

bool keep_block(void* block, std::size_t size) {
  return store.keep(block, size);
}

}  // namespace kappamu

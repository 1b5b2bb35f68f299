// Large blocks of memory come in huge pages. The kernel gives memory page by page, and photographs
// and merged pictures touch hundreds of megabytes only once: a third of a merge was page faults.
// Where stack follows stack, freed blocks are used again.
#include <malloc.h>
#include <sys/mman.h>

#include <cstdint>
#include <cstdlib>
#include <new>

#include "core/memory/kept_blocks.h"

// The sanitizers have their own.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

constexpr std::size_t huge_page = std::size_t{1} << 21;

void ask_for_huge_pages(void* block, std::size_t size) {
  const auto begin = reinterpret_cast<std::uintptr_t>(block);
  const std::uintptr_t first = (begin + huge_page - 1) / huge_page * huge_page;
  const std::uintptr_t end = (begin + size) / huge_page * huge_page;
  // A wish: without huge pages the memory is as good.
  if (end > first) madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
}

}  // namespace

void* operator new(std::size_t size) {
  const bool large = size >= kappamu::large_block;
  if (large) {
    if (void* const kept = kappamu::take_kept_block(size)) return kept;
  }
  void* block = std::malloc(size > 0 ? size : 1);
  while (block == nullptr) {
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
    block = std::malloc(size > 0 ? size : 1);
  }
  if (large) ask_for_huge_pages(block, size);
  return block;
}
void operator delete(void* block) noexcept {
  const std::size_t size = malloc_usable_size(block);
  if (size < kappamu::large_block || !kappamu::keep_block(block, size)) std::free(block);
}
void operator delete(void* block, std::size_t size) noexcept {
  if (size < kappamu::large_block) return std::free(block);
  ::operator delete(block);
}

#endif

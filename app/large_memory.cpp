// Large blocks of memory come in huge pages. The kernel gives memory page by page, and photographs
// and merged pictures touch hundreds of megabytes only once: a third of a merge was page faults.
#include <cstdlib>
#include <new>

#include "core/process_memory.h"

// The sanitizers have their own.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

void* operator new(std::size_t size) {
  void* block = std::malloc(size > 0 ? size : 1);
  while (block == nullptr) {
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
    block = std::malloc(size > 0 ? size : 1);
  }
  kappamu::ask_for_huge_pages(block, size);
  return block;
}
void operator delete(void* block) noexcept {
  std::free(block);
}
void operator delete(void* block, std::size_t) noexcept {
  std::free(block);
}

#endif

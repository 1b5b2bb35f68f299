#include "device/buffer_pool.h"

#include <utility>

namespace kappamu::device {

Buffer BufferPool::take(std::size_t bytes) {
  std::vector<Buffer>& spare = (*spare_)[bytes];
  Buffer own;
  if (spare.empty()) {
    own = context_.allocate(bytes);
  } else {
    own = std::move(spare.back());
    spare.pop_back();
  }
  Buffer lent;
  lent.bytes_ = bytes;
  lent.handle_ =
      std::shared_ptr<void>(own.handle_.get(), [own, keeper = std::weak_ptr<Spare>(spare_)](void*) {
        if (const auto alive = keeper.lock()) (*alive)[own.bytes()].push_back(own);
      });
  return lent;
}

}  // namespace kappamu::device

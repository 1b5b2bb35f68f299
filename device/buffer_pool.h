// Device memory that is asked for again and again in the same sizes: fresh pages cost a solver's
// fields a fifth of its time on a processor.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <vector>

#include "device/context.h"

namespace kappamu::device {

class BufferPool {
 public:
  explicit BufferPool(Context& context) : context_(context) {}

  /// Uninitialised, like Context::allocate(); kept for the next of this size when its last owner is
  /// gone, or freed where the pool is gone by then.
  Buffer take(std::size_t bytes);

 private:
  using Spare = std::map<std::size_t, std::vector<Buffer>>;  ///< by bytes
  Context& context_;
  std::shared_ptr<Spare> spare_ = std::make_shared<Spare>();
};

}  // namespace kappamu::device

// Known answers every OpenCL device must give before its results are believed: drivers have
// miscompiled kernels and returned wrong reductions.
#pragma once

#include <string>

#include "device/context.h"

namespace kappamu::device {

struct SelfTest {
  bool passed = false;
  std::string message;  ///< one phrase: what was tested, or what was wrong
};

/// axpy, tree reduction and prefix sum at awkward sizes, compared to the bit. Never throws: a
/// failing OpenCL call is a failed test.
SelfTest self_test(Context& context);

}  // namespace kappamu::device

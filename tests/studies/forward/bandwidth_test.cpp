#include "studies/forward/bandwidth.h"

#include <gtest/gtest.h>

#include <vector>

#include "device/device_info.h"

namespace kappamu::studies {
namespace {

TEST(Bandwidth, OfACopyIsPlausibleAndLeavesNothingBehind) {
  if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device";
  device::Context& context = device::Context::chosen("auto");
  const std::size_t before = context.allocated_bytes();
  const double bandwidth = measured_copy_bandwidth(context);
  EXPECT_GT(bandwidth, 1e8);
  EXPECT_LT(bandwidth, 1e14);
  EXPECT_EQ(context.allocated_bytes(), before);
}

}  // namespace
}  // namespace kappamu::studies

// The OpenCL runtime: choosing devices, error sentences, known answers. Tests that need a device
// are skipped where none is installed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "core/error.h"
#include "device/buffer_pool.h"
#include "device/context.h"
#include "device/device_info.h"
#include "device/self_test.h"
#include "device/traffic.h"
#include "tests/sentence.h"

namespace kappamu::device {
namespace {

using ::testing::HasSubstr;

DeviceInfo named(const char* platform, const char* name, Kind kind) {
  DeviceInfo info;
  info.platform = platform;
  info.name = name;
  info.kind = kind;
  return info;
}

const std::vector<DeviceInfo> rig{named("Portable Computing Language", "pthread-EPYC", Kind::cpu),
                                  named("NVIDIA CUDA", "NVIDIA H200", Kind::gpu)};

std::string choice_refused(const std::vector<DeviceInfo>& devices, const std::string& wanted) {
  return sentence_of([&] { choose(devices, wanted); });
}

TEST(DeviceChoice, AutoPrefersGpuThenCpu) {
  EXPECT_EQ(choose(rig, "auto").index, 1U);
  EXPECT_EQ(choose({rig[0]}, "auto").index, 0U);
}

TEST(DeviceChoice, WordsMatchPlatformOrNameWhateverTheCase) {
  EXPECT_EQ(choose(rig, "epyc").index, 0U);
  EXPECT_EQ(choose(rig, "PORTABLE").index, 0U);
  EXPECT_EQ(choose(rig, "h200").index, 1U);
}

TEST(DeviceChoice, NoMatchIsOneSentenceWithTheFix) {
  const std::string sentence = choice_refused(rig, "radeon");
  EXPECT_THAT(sentence, HasSubstr("no OpenCL device matches 'radeon'"));
  EXPECT_THAT(sentence, HasSubstr("NVIDIA H200"));
  EXPECT_THAT(sentence, HasSubstr("install pocl-opencl-icd or use the device reference"));
  EXPECT_THAT(choice_refused(rig, "reference"), HasSubstr("is computed by OpenCL alone"));
}

TEST(DeviceChoice, NoDeviceAtAllIsOneSentenceWithTheFix) {
  EXPECT_EQ(choice_refused({}, "auto"),
            "no OpenCL device was found; install pocl-opencl-icd or use the device reference "
            "(device reference)");
  EXPECT_THAT(choice_refused({}, "pocl"), HasSubstr("no OpenCL device matches 'pocl'"));
}

class OnDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    if (list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
    context_ = &Context::chosen("auto");
  }
  Context* context_ = nullptr;
};

TEST_F(OnDevice, GivesKnownAnswers) {
  const SelfTest result = self_test(*context_);
  EXPECT_TRUE(result.passed) << result.message;
}

TEST_F(OnDevice, BuildErrorsCarryTheLogAndTrueLineNumbers) {
  const KernelSource broken{"broken.cl",
                            "kernel void f(global int *a) {\n  a[0] = missing_name;\n}\n"};
  try {
    context_->program(broken, "");
    FAIL() << "a broken kernel was built";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr("clBuildProgram"));
    EXPECT_THAT(error.what(), HasSubstr("broken.cl"));
    EXPECT_THAT(error.what(), HasSubstr("missing_name"));
    EXPECT_THAT(error.what(), HasSubstr(":2:"));
  }
}

TEST_F(OnDevice, UnknownKernelIsNamed) {
  const KernelSource source{"empty.cl", "kernel void here(global int *a) { a[0] = 1; }\n"};
  Program& program = context_->program(source, "");
  const Buffer buffer = context_->allocate(4);
  try {
    context_->launch(program, "absent", {}, buffer);
    FAIL() << "a kernel that does not exist was launched";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr("clCreateKernel(absent)"));
  }
}

TEST_F(OnDevice, ProgramsAreBuiltOncePerTextAndOptions) {
  const KernelSource source{"k.cl", "kernel void k(global int *a) { a[0] = N; }\n"};
  Program* one = &context_->program(source, "-DN=1");
  EXPECT_EQ(&context_->program(source, "-DN=1"), one);
  EXPECT_NE(&context_->program(source, "-DN=2"), one);
}

TEST_F(OnDevice, RoundTripsAndZeroes) {
  const std::vector<int> sent{3, 1, 4, 1, 5};
  const Buffer a = context_->allocate(sent.size() * sizeof(int));
  const Buffer b = context_->allocate(sent.size() * sizeof(int));
  context_->write(a, sent.data(), a.bytes());
  context_->copy(a, b, a.bytes());
  std::vector<int> received(sent.size());
  context_->read(b, received.data(), b.bytes());
  EXPECT_EQ(received, sent);
  context_->zero(b, b.bytes());
  context_->read(b, received.data(), b.bytes());
  EXPECT_EQ(received, std::vector<int>(sent.size(), 0));
}

TEST_F(OnDevice, WhatPassesIsCounted) {
  const KernelSource source{"one.cl", "kernel void one(global int *a) { a[0] = 1; }\n"};
  Program& program = context_->program(source, "");
  const Buffer buffer = context_->allocate(sizeof(int));
  context_->launch(program, "one", {}, buffer);  // the first of its width waits by itself
  const Traffic before = traffic();
  context_->launch(program, "one", {}, buffer);
  int found = 0;
  context_->read(buffer, &found, sizeof found);
  context_->finish();
  const Traffic passed = traffic().since(before);
  EXPECT_EQ(passed.launches, 1U);
  EXPECT_EQ(passed.waits, 2U);
  EXPECT_EQ(passed.bytes, sizeof found);
  EXPECT_GT(passed.seconds, 0.0);
}

TEST_F(OnDevice, PartsAreOfTheirBuffer) {
  constexpr std::size_t unit = Context::part_alignment;
  const std::size_t before = context_->allocated_bytes();
  Buffer whole = context_->allocate(3 * unit);
  context_->zero(whole, 3 * unit);
  const Buffer part = context_->part(whole, unit, unit);
  const std::vector<char> ones(unit, 1);
  context_->write(part, ones.data(), unit);
  std::vector<char> got(3 * unit);
  context_->read(whole, got.data(), 3 * unit);
  for (std::size_t i = 0; i < got.size(); ++i) ASSERT_EQ(got[i], i / unit == 1 ? 1 : 0) << i;
  EXPECT_EQ(context_->allocated_bytes(), before + 3 * unit);
  whole = {};
  context_->read(part, got.data(), unit);
  EXPECT_EQ(got[0], 1);
  EXPECT_THROW(context_->part(part, 1, 1), std::logic_error);
  EXPECT_THROW(context_->part(part, unit, 1), std::logic_error);
}

TEST_F(OnDevice, BuffersAliveAreCounted) {
  const std::size_t before = context_->allocated_bytes();
  {
    const Buffer a = context_->allocate(1000), again = a;
    EXPECT_EQ(context_->allocated_bytes(), before + 1000);
  }
  EXPECT_EQ(context_->allocated_bytes(), before);
}

/// Between a floppy and more than any memory of this decade; the buffers are given back.
TEST_F(OnDevice, PooledMemoryIsLentAgainAndFreedWithItsPool) {
  const std::size_t before = context_->allocated_bytes();
  auto pool = std::make_unique<BufferPool>(*context_);
  const float value = 3.0F;
  {
    const Buffer first = pool->take(sizeof value);
    context_->write(first, &value, sizeof value);
  }
  EXPECT_EQ(context_->allocated_bytes(), before + sizeof value);
  Buffer again = pool->take(sizeof value);
  float found = 0.0F;
  context_->read(again, &found, sizeof found);
  EXPECT_EQ(found, value);
  const Buffer other = pool->take(sizeof value);
  EXPECT_EQ(context_->allocated_bytes(), before + 2 * sizeof value);
  again = {};
  pool.reset();
  EXPECT_EQ(context_->allocated_bytes(), before + sizeof value) << "the one still lent";
}

TEST_F(OnDevice, LaunchesAreTimedOnlyWhileAskedFor) {
  const KernelSource source{"k.cl", R"(
kernel void fill(const int count, const int value, const float ignored, global int* a) {
  const int i = (int)get_global_id(0);
  if (i < count) a[i] = value;
})"};
  Program& program = context_->program(source, "");
  constexpr int count = 1 << 20;
  const Buffer a = context_->allocate(count * sizeof(int));
  const auto fill = [&](int value) {
    context_->launch(program, "fill", {count, 1, 64, 1}, count, value, 0.5F, a);
  };
  fill(1);
  const auto start = std::chrono::steady_clock::now();
  const auto launches = context_->launches_of([&] {
    fill(2);
    fill(3);
  });
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  ASSERT_EQ(launches.size(), 2U);
  EXPECT_EQ(launches[0].kernel, "fill");
  EXPECT_EQ(launches[0].integers, (std::vector<int>{count, 2}));
  EXPECT_EQ(launches[1].integers, (std::vector<int>{count, 3}));
  EXPECT_GT(launches[0].seconds, 0.0);
  EXPECT_LE(launches[0].seconds + launches[1].seconds, wall.count());
  // What throws leaves the context as it was.
  EXPECT_THROW(context_->launches_of([] { throw InputError("stop"); }), InputError);
  fill(4);
  std::vector<int> values(count);
  context_->read(a, values.data(), a.bytes());
  EXPECT_EQ(values, std::vector<int>(count, 4));
}

// PoCL before 7 ends the process otherwise: context.cpp, "widening".
TEST_F(OnDevice, OneThreadMayWidenAKernelThatAnotherRuns) {
  const KernelSource source{"k.cl", R"(
kernel void count(const int rounds, global int* a) {
  int sum = 0;
  for (int i = 0; i < rounds; ++i) sum = sum * 1664525 + i + (int)get_global_id(0);
  if (sum == -1) a[0] = sum;
})"};
  Program& program = context_->program(source, "");
  const auto launch = [&](std::size_t groups, const Buffer& a) {
    context_->launch(program, "count", {64 * groups, 1, 64, 1}, 20000, a);
  };
  std::atomic<bool> done = false;
  std::vector<std::jthread> others(3);
  for (std::jthread& other : others) {
    other = std::jthread([&] {
      const Buffer a = context_->allocate(sizeof(int));
      while (!done) {
        launch(1, a);
        context_->finish();
      }
    });
  }
  const Buffer a = context_->allocate(sizeof(int));
  for (std::size_t groups = 2; groups < 100; ++groups) {
    launch(groups, a);
    context_->finish();
  }
  done = true;
}

TEST_F(OnDevice, AccessPastABufferIsRefused) {
  const Buffer a = context_->allocate(4);
  std::vector<int> two(2);
  EXPECT_THROW(context_->read(a, two.data(), 8), InternalError);
}

TEST_F(OnDevice, TooLittleMemoryIsTheUsersToMend) {
  const std::string sentence = sentence_of([&] {
    // Larger than any device of this decade.
    context_->allocate(std::size_t{1} << 50);
  });
  EXPECT_THAT(sentence, HasSubstr("in one piece, and"));
  EXPECT_THAT(sentence, HasSubstr("use a coarser grid, fewer patterns at once, or another device"));
}

}  // namespace
}  // namespace kappamu::device

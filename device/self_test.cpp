#include "device/self_test.h"

#include <exception>
#include <vector>

namespace kappamu::device {

extern const KernelSource self_test_cl;

namespace {

constexpr std::size_t group = 64;

/// Small integers without pattern in a power of two.
std::vector<float> integers(std::size_t n) {
  std::vector<float> x(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = static_cast<float>((i * 7 + i / 5) % 13) - 4.0F;
  return x;
}

/// Empty, or which kernel was wrong.
std::string wrong_kernel(Context& context, std::size_t n) {
  Program& program = context.program(self_test_cl, "-DGROUP=64");
  const std::vector<float> x = integers(n);
  const std::size_t groups = (n + group - 1) / group;
  const Range items{n, 1, group, 1};
  const int count = static_cast<int>(n);
  const Buffer in = context.allocate(n * sizeof(float));
  const Buffer out = context.allocate(n * sizeof(float));
  std::vector<float> y(n);

  context.write(in, x.data(), n * sizeof(float));
  context.write(out, x.data(), n * sizeof(float));
  context.launch(program, "axpy", items, count, 3.0F, in, out);
  context.read(out, y.data(), n * sizeof(float));
  for (std::size_t i = 0; i < n; ++i) {
    if (y[i] != 4.0F * x[i]) return "axpy";
  }

  context.launch(program, "prefix", items, count, in, out);
  context.read(out, y.data(), n * sizeof(float));
  float running = 0.0F;
  for (std::size_t i = 0; i < n; ++i) {
    running = (i % group == 0 ? 0.0F : running) + x[i];
    if (y[i] != running) return "prefix sum";
  }

  const Buffer partial = context.allocate(groups * sizeof(float));
  std::vector<float> sums(groups);
  context.launch(program, "reduce", items, count, in, partial);
  context.read(partial, sums.data(), groups * sizeof(float));
  for (std::size_t g = 0; g < groups; ++g) {
    float expected = 0.0F;
    for (std::size_t i = g * group; i < n && i < (g + 1) * group; ++i) expected += x[i];
    if (sums[g] != expected) return "reduction";
  }
  return "";
}

}  // namespace

SelfTest self_test(Context& context) {
  try {
    for (const std::size_t n :
         {std::size_t{1}, std::size_t{63}, std::size_t{597}, std::size_t{4099}}) {
      const std::string wrong = wrong_kernel(context, n);
      if (!wrong.empty()) {
        return {false, "wrong answer from " + wrong + " at size " + std::to_string(n)};
      }
    }
  } catch (const std::exception& error) {
    return {false, error.what()};
  }
  return {true, "axpy, reduction and prefix sum at sizes 1 to 4099 exact"};
}

}  // namespace kappamu::device

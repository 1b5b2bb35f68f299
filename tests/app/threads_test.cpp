// Equal bits on any number of threads: what lets a fit go on where it was killed although the
// machine lends it more cores now, or fewer.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "io/npy.h"
#include "io/read_file.h"
#include "tests/app/process.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;

class ThreadsTest : public TemporaryFolderTest {
 protected:
  /// An uneven block, so that cuts along y fall differently for every number of cores.
  void make_inputs() const {
    constexpr std::size_t nx = 30, ny = 50, nz = 12, patterns = 3;
    std::vector<float> kappa(nx * ny * nz), mu(kappa.size()), light(patterns * nx * ny);
    for (std::size_t i = 0; i < kappa.size(); ++i) {
      kappa[i] = 0.3F + 0.2F * static_cast<float>(std::sin(0.37 * static_cast<double>(i)));
      mu[i] = 0.02F + 0.015F * static_cast<float>(std::cos(0.11 * static_cast<double>(i)));
    }
    for (std::size_t i = 0; i < light.size(); ++i) light[i] = i % 7 < 3 ? 1.0F : 0.0F;
    io::write_npy(folder() / "kappa.npy", {nz, ny, nx}, std::span<const float>(kappa));
    io::write_npy(folder() / "mu.npy", {nz, ny, nx}, std::span<const float>(mu));
    io::write_npy(folder() / "light.npy", {patterns, ny, nx}, std::span<const float>(light));
  }
  /// The exitance that PoCL finds on `threads`, in double: where the order of sums shows at once.
  std::string exitance(int threads) const {
    const fs::path out = folder() / ("out" + std::to_string(threads));
    const auto file = [&](const char* name) { return (folder() / name).string(); };
    const ProcessResult result =
        kappamu("--device Portable forward --kappa " + file("kappa.npy") + " --mu " +
                    file("mu.npy") + " --precision double --voxel 0.5 --eta 1.3 --irradiance " +
                    file("light.npy") + " --lit-face z- -o " + out.string(),
                "POCL_MAX_PTHREAD_COUNT=" + std::to_string(threads));
    EXPECT_EQ(result.exit_code, 0) << result.standard_error;
    return io::read_text(out / "exitance_z+.npy");
  }
};

TEST_F(ThreadsTest, SolutionsHaveTheSameBitsOnAnyNumberOfThreads) {
  make_inputs();
  std::set<unsigned> units;
  const std::string one = exitance(1);
  for (const int threads : {2, 3, 7}) {
    const nlohmann::json doctor = nlohmann::json::parse(
        last_line(kappamu("doctor --json", "POCL_MAX_PTHREAD_COUNT=" + std::to_string(threads))
                      .standard_output));
    for (const auto& device : doctor["devices"])
      units.insert(device["compute_units"].get<unsigned>());
    EXPECT_TRUE(exitance(threads) == one) << threads << " threads";
  }
  EXPECT_GT(units.size(), 1U) << "the number of threads must differ for this to be a test";
}

}  // namespace
}  // namespace kappamu::app

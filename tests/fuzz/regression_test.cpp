// What fuzzing found (regression/TARGET, scripts/fuzz.sh) is refused or read ever since, and the
// inputs that fuzzing begins with are good.
#include <gtest/gtest.h>
#include <unistd.h>

#include "core/error.h"
#include "io/read_file.h"
#include "tests/fuzz/targets.h"

namespace kappamu::fuzz {
namespace {

namespace fs = std::filesystem;

class Fuzzed : public testing::TestWithParam<Target> {};

TEST_P(Fuzzed, SeedsAreRead) {
  const fs::path seeds = folder() / "seeds" / GetParam().name;
  fs::create_directories(seeds);
  GetParam().seed(seeds);
  int count = 0;
  for (const auto& entry : fs::directory_iterator(seeds)) {
    ++count;
    const std::string bytes = io::read_text(entry.path());
    EXPECT_NO_THROW(GetParam().read(bytes_of(bytes))) << entry.path();
  }
  EXPECT_GT(count, 0);
}

TEST_P(Fuzzed, FindingsAreReadOrRefused) {
  const fs::path findings =
      fs::path(KAPPAMU_SOURCE_DIR) / "tests" / "fuzz" / "regression" / GetParam().name;
  if (!fs::exists(findings)) return;
  for (const auto& entry : fs::directory_iterator(findings)) {
    const std::string bytes = io::read_text(entry.path());
    try {
      GetParam().read(bytes_of(bytes));
    } catch (const InputError&) {
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, Fuzzed, testing::ValuesIn(targets),
                         [](const auto& named) { return std::string(named.param.name); });

}  // namespace
}  // namespace kappamu::fuzz

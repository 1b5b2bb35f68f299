// libFuzzer (https://llvm.org/docs/LibFuzzer.html): any bytes are read or refused, by the target
// that KAPPAMU_FUZZ names (scripts/fuzz.sh). With KAPPAMU_FUZZ_SEEDS=FOLDER writes the target's
// seeds there, reads each, and ends.
#include <cstdio>
#include <cstdlib>

#include "core/error.h"
#include "forward/registry.h"
#include "io/read_file.h"
#include "pipeline/records/versions.h"
#include "tests/fuzz/targets.h"

namespace kappamu::pipeline {
/// Takes the place of the one that asks OpenCL for its devices.
std::map<std::string, std::string> library_versions() {
  return {{"kappamu", "fuzzed"}};
}
}  // namespace kappamu::pipeline

namespace kappamu::forward {

/// Takes the place of all models: scenes are read by their descriptions alone.
class WithParameter final : public ObjectModel {
 public:
  void describe(const OptionVisitor& visit) override {
    visit({"photons", "", "", "", bounds::at_least_one, ""}, &photons_);
  }
  ObjectResult solve(const ObjectProblem&, const ObjectOptions&, Progress&) override { return {}; }

 private:
  std::uint64_t photons_ = 1;
};

const std::deque<ModelDescription>& object_models() {
  const auto make = [] { return std::make_unique<WithParameter>(); };
  // Those that scenes/ names.
  static const std::deque<ModelDescription> models{
      {.name = "embedded", .text = "", .limits = "", .can = {}, .make = make},
      {.name = "dipole-rotated", .text = "", .limits = "", .can = {}, .make = make},
      {.name = "polygrid", .text = "", .limits = "", .can = {}, .make = make}};
  return models;
}

const ModelDescription& object_model(const std::string& /*name*/) {
  return object_models().front();
}

}  // namespace kappamu::forward

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

const kappamu::fuzz::Target* target = nullptr;

/// A seed that is refused would be none.
int write_seeds(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  target->seed(folder);
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string bytes = kappamu::io::read_text(entry.path());
    try {
      target->read(kappamu::fuzz::bytes_of(bytes));
    } catch (const kappamu::InputError& error) {
      std::fprintf(stderr, "seed %s: %s\n", entry.path().c_str(), error.what());
      return 1;
    }
  }
  return 0;
}

}  // namespace

/// What OpenVDB has of a grid that ends too early it never frees: little, and the program ends
/// then.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:openvdb::";
}

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  const char* name = std::getenv("KAPPAMU_FUZZ");
  for (const kappamu::fuzz::Target& known : kappamu::fuzz::targets) {
    if (name != nullptr && known.name == name) target = &known;
    if (name == nullptr)
      std::printf("%.*s\n", static_cast<int>(known.name.size()), known.name.data());
  }
  if (target == nullptr) std::exit(name == nullptr ? 0 : 2);
  if (const char* seeds = std::getenv("KAPPAMU_FUZZ_SEEDS")) std::exit(write_seeds(seeds));
  // What a target makes for itself at its first input is made here, before the clock runs.
  constexpr std::uint8_t nothing = 0;
  LLVMFuzzerTestOneInput(&nothing, 1);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    target->read({data, size});
  } catch (const kappamu::InputError&) {
  }
  return 0;
}

#include "capture/import/code_depth.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "capture/session/frames.h"
#include "core/file_name.h"
#include "io/image/image_file.h"
#include "io/image/raw_file.h"

namespace kappamu::capture {
namespace {

namespace fs = std::filesystem;

// Values that share the largest code where the sensor saturates. Without saturation noise spreads
// the brightest: two or three have the largest code.
constexpr std::size_t least_saturated = 30;
// As saturation_code(): codes may end a little below the largest that their bits hold.
constexpr double least_full_scale = 0.99;

bool tells_depth_itself(const Camera& camera, const fs::path& file) {
  return io::is_raw_file(file) || io::is_float_image(file) || is_headerless(camera, file) ||
         lower_extension(file).starts_with(".j");
}

struct LargestCode {
  const Photograph* photograph = nullptr;
  int code = 0;
  std::size_t values = 0;  // that have it
  int stored_bits = 0;     // of the photograph that has most
};

LargestCode largest_code_of(const std::vector<Photograph>& photographs, const Camera& camera) {
  LargestCode found;
  for (std::size_t i = 0; i < photographs.size(); ++i) {
    const bool longest =
        i + 1 == photographs.size() || photographs[i + 1].shot != photographs[i].shot;
    const fs::path& file = photographs[i].path;
    if (!longest || photographs[i].shot == "dark" || tells_depth_itself(camera, file)) continue;
    const Image<std::uint16_t> codes = io::read_code_image(file, [&](const io::ImageSize& size) {
      found.stored_bits = std::max(found.stored_bits, size.bits);
    });
    const auto& values = codes.values();
    const int largest = *std::max_element(values.begin(), values.end());
    if (found.photograph != nullptr && largest < found.code) continue;
    if (largest > found.code) found.values = 0;
    found.photograph = &photographs[i];
    found.code = largest;
    found.values += static_cast<std::size_t>(std::count(values.begin(), values.end(), largest));
  }
  return found;
}

int bits_that_hold(int code) {
  int bits = 8;
  while (code >> bits != 0) ++bits;
  return bits;
}

}  // namespace

void settle_depth(const std::vector<Photograph>& photographs, const fs::path& plan, Camera& camera,
                  Progress& progress) {
  const LargestCode largest = largest_code_of(photographs, camera);
  if (largest.photograph == nullptr) return;
  const int planned = camera.bit_depth;
  const int bits = bits_that_hold(largest.code);
  const int top = (1 << bits) - 1;
  const bool saturates =
      largest.values >= least_saturated && largest.code >= least_full_scale * top;
  if (largest.stored_bits == 8) {
    camera.bit_depth = 8;
  } else if (bits > planned || (bits < planned && saturates)) {
    camera.bit_depth = bits;
  }
  if (camera.bit_depth == planned) return;
  progress.warn(
      largest.photograph->path.string() +
      (largest.stored_bits == 8 ? ": its codes are stored with 8 bits"
                                : ": its largest code is " + std::to_string(largest.code)) +
      ", while camera.bit_depth of " + (plan / "session.json").string() + " is " +
      std::to_string(planned) + "; " + std::to_string(camera.bit_depth) + " bits are taken.");
}

}  // namespace kappamu::capture

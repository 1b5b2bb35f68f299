#include "io/image/image_limits.h"

#include <string>

#include "core/error.h"

namespace kappamu::io {

void check_size(const std::filesystem::path& file, const ImageSize& claimed, std::size_t bytes,
                const SizeCheck& expected) {
  constexpr int largest_side = 1 << 16;
  constexpr std::uint64_t always_allowed = std::uint64_t{1} << 22;
  constexpr std::uint64_t values_per_byte = 1024;  // about what deflate makes of zeros
  const std::string size = std::to_string(claimed.width) + " x " + std::to_string(claimed.height) +
                           " pixels of " + std::to_string(claimed.channels) + " channels";
  if (claimed.width < 1 || claimed.height < 1 || claimed.channels < 1) {
    throw InputError(file.string() + ": damaged image without pixels; copy or photograph it again");
  }
  if (expected) expected(claimed);
  const std::uint64_t values = static_cast<std::uint64_t>(claimed.width) *
                               static_cast<std::uint64_t>(claimed.height) *
                               static_cast<std::uint64_t>(claimed.channels);
  if (claimed.width > largest_side || claimed.height > largest_side ||
      (values > always_allowed && values / values_per_byte > bytes)) {
    throw InputError(file.string() + ": damaged image, " + size + " in " + std::to_string(bytes) +
                     " bytes; copy or photograph it again");
  }
  if (!expected && values > most_image_values) {
    throw InputError(file.string() + ": " + size + " are more than " +
                     std::to_string(most_image_values / 1'000'000) +
                     " million values; reduce or crop the image");
  }
}

}  // namespace kappamu::io

// libFuzzer: any bytes as a photograph are read or refused (scripts/fuzz.sh). The first byte
// chooses the reader, since each takes its files by their own beginning.
#include "io/image/image_file.h"
#include "io/image/photo_settings.h"
#include "io/image/raw_file.h"
#include "tests/fuzz/fuzz_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::filesystem::path file = kappamu::fuzz_file(data + 1, size - 1, "image");
  kappamu::refused_or_read([&] {
    switch (data[0] % 4) {
      case 0:
        kappamu::io::read_code_image(file);
        break;
      case 1:
        kappamu::io::read_float_image(file);
        break;
      case 2:
        kappamu::io::read_raw(file);
        break;
      default:
        kappamu::io::read_photo_settings(file);
    }
  });
  return 0;
}

// An image's bytes behind OpenImageIO's reader of one format. Only .cpp files of this folder
// include this: OpenImageIO's header is large.
#pragma once

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace kappamu::io {

class OiioInput {
 public:
  /// Opens by the reader of the bytes' own format, never by whichever of OpenImageIO's thirty takes
  /// them. `bytes` must outlive this.
  OiioInput(const std::filesystem::path& file, std::span<std::byte> bytes);
  ~OiioInput();
  OiioInput(const OiioInput&) = delete;
  OiioInput& operator=(const OiioInput&) = delete;

  bool opened() const { return opened_; }
  /// Goes on to a part of an EXR or a page of a TIFF, from 0; false where there is none.
  bool select(int part);
  /// What the library says of a failure; for its cause, not for people.
  std::string error() const { return input_->geterror(false); }
  const OIIO::ImageSpec& spec() const { return input_->spec(); }

  /// Calls `take`(first row, rows, pixels) for blocks of rows in order, with pixels of `format` and
  /// all channels, [row][x][channel], of the first `wanted_rows`, or all. False where the picture
  /// is damaged. Blocks keep two copies of the picture from being held at once.
  using TakeRows = std::function<void(int first, int rows, const std::byte* pixels)>;
  bool read(OIIO::TypeDesc format, const TakeRows& take,
            std::optional<int> wanted_rows = std::nullopt);

 private:
  /// OpenImageIO's own reads before and behind the bytes where a file tells it to.
  class Memory : public OIIO::Filesystem::IOMemReader {
   public:
    using IOMemReader::IOMemReader;
    std::size_t read(void* buffer, std::size_t size) override;
    std::size_t pread(void* buffer, std::size_t size, std::int64_t offset) override;
  };

  Memory memory_;
  std::unique_ptr<OIIO::ImageInput> input_;
  bool opened_ = false;
  int part_ = 0;
};

/// The bytes of a file that OpenImageIO writes from `pixels` of the spec's format, [y][x][channel].
/// `format` is "tiff", "jpeg" or "openexr" (PNG: png_writer.h); `what` names the picture where that
/// fails.
std::vector<unsigned char> encode_image(const char* format, OIIO::ImageSpec spec,
                                        const void* pixels, const std::string& what);

/// The same, block by block: `fill` writes rows [first, first + rows) to `pixels`.
using FillRows = std::function<void(int first, int rows, std::byte* pixels)>;
std::vector<unsigned char> encode_image(const char* format, OIIO::ImageSpec spec,
                                        const FillRows& fill, const std::string& what);

}  // namespace kappamu::io

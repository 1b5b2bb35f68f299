#include "io/image/oiio_input.h"

#include <algorithm>
#include <exception>
#include <new>
#include <string>

#include "core/error.h"
#include "io/image/image_integrity.h"

namespace kappamu::io {

namespace {

const char* reader_of(ImageKind kind) {
  switch (kind) {
    case ImageKind::png:
      return "png";
    case ImageKind::tiff:
      return "tiff";
    case ImageKind::jpeg:
      return "jpeg";
    case ImageKind::bmp:
      return "bmp";
    case ImageKind::exr:
      return "openexr";
    case ImageKind::radiance:
      return "hdr";
    default:
      throw InternalError("internal error: bytes of an unknown image format are to be opened");
  }
}

}  // namespace

std::size_t OiioInput::Memory::read(void* buffer, std::size_t size) {
  const std::size_t taken = pread(buffer, size, tell());
  seek(tell() + static_cast<std::int64_t>(taken));
  return taken;
}

std::size_t OiioInput::Memory::pread(void* buffer, std::size_t size, std::int64_t offset) {
  const auto end = static_cast<std::int64_t>(m_buf.size());
  if (offset < 0 || offset >= end) return 0;
  const std::size_t taken = std::min(size, static_cast<std::size_t>(end - offset));
  std::copy_n(m_buf.data() + offset, taken, static_cast<unsigned char*>(buffer));
  return taken;
}

OiioInput::OiioInput(const std::filesystem::path& file, std::span<std::byte> bytes)
    : memory_(bytes.data(), bytes.size()),
      input_(OIIO::ImageInput::create(reader_of(image_kind(bytes)))) {
  check(input_ != nullptr, "OpenImageIO lacks a reader of PNG, TIFF, JPEG, BMP, EXR or Radiance");
  if (!holds_exr_header(bytes)) return;
  hide_photoshop_segments(bytes);
  OIIO::ImageSpec spec;
  OIIO::ImageSpec wishes;
  OIIO::Filesystem::IOProxy* proxy = &memory_;
  wishes.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  wishes.attribute("oiio:UnassociatedAlpha", 1);  // colours are not multiplied by it
  try {
    opened_ = input_->open(file.string(), spec, wishes);
  } catch (const std::exception&) {
    opened_ = false;
  }
}

OiioInput::~OiioInput() {
  input_->geterror();  // an error that nobody asks for goes to standard error
}

bool OiioInput::select(int part) {
  try {
    if (!input_->seek_subimage(part, 0)) return false;
  } catch (const std::exception&) {
    return false;
  }
  part_ = part;
  return true;
}

bool OiioInput::read(OIIO::TypeDesc format, const TakeRows& take, std::optional<int> wanted_rows) {
  const OIIO::ImageSpec& image = spec();
  const bool tiled = image.tile_width > 0;
  // EXR is compressed in blocks of up to 32 rows. Other formats go row by row: for several rows of
  // TIFF OpenImageIO 2.4 inflates strips itself and reports success where that fails.
  const bool exr = input_->format_name() == std::string("openexr");
  const int block = tiled ? image.tile_height : exr ? 32 : 1;
  const std::size_t row_bytes = static_cast<std::size_t>(image.width) *
                                static_cast<std::size_t>(image.nchannels) * format.size();
  std::vector<std::byte> pixels(row_bytes * static_cast<std::size_t>(block));
  input_->geterror();  // of a part that was looked for
  try {
    const int wanted = std::min(image.height, wanted_rows.value_or(image.height));
    for (int y = 0; y < wanted; y += block) {
      const int rows = std::min(block, image.height - y);
      const int begin = image.y + y;
      const bool read =
          tiled ? input_->read_tiles(part_, 0, image.x, image.x + image.width, begin, begin + rows,
                                     0, 1, 0, image.nchannels, format, pixels.data())
          : exr ? input_->read_scanlines(part_, 0, begin, begin + rows, 0, 0, image.nchannels,
                                         format, pixels.data())
                : input_->read_scanline(begin, 0, format, pixels.data());
      if (!read) return false;
      take(y, rows, pixels.data());
    }
  } catch (const std::exception&) {
    return false;
  }
  return !input_->has_error();  // libjpeg goes on with grey where data are missing, and warns
}

namespace {

using WritePixels = std::function<bool(OIIO::ImageOutput& output)>;

std::vector<unsigned char> encode(const char* format, OIIO::ImageSpec spec,
                                  const WritePixels& write, const std::string& what) {
  // A task of OpenEXR's own threads whose allocation fails leaves its lines out without a word; the
  // library's words on the way are for its authors.
  [[maybe_unused]] static const bool alone = OIIO::attribute("exr_threads", -1);
  [[maybe_unused]] static const bool silent = OIIO::attribute("debug", 0);
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  OIIO::Filesystem::IOProxy* proxy = &memory;
  spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  const auto output = OIIO::ImageOutput::create(format);
  check(output != nullptr, std::string("OpenImageIO has no writer of ") + format);
  const bool written = output->open(what, spec) && write(*output) && output->close();
  // Encoders say in words that an allocation failed.
  if (!written && output->geterror(false).find("memory") != std::string::npos)
    throw std::bad_alloc();
  check(written, "OpenImageIO cannot encode " + what + ": " + output->geterror());
  return bytes;
}

}  // namespace

std::vector<unsigned char> encode_image(const char* format, OIIO::ImageSpec spec,
                                        const void* pixels, const std::string& what) {
  const OIIO::TypeDesc type = spec.format;
  return encode(
      format, std::move(spec),
      [&](OIIO::ImageOutput& output) { return output.write_image(type, pixels); }, what);
}

std::vector<unsigned char> encode_image(const char* format, OIIO::ImageSpec spec,
                                        const FillRows& fill, const std::string& what) {
  constexpr int block = 64;  // a multiple of the rows that EXR compresses together
  std::vector<std::byte> pixels(spec.scanline_bytes() * static_cast<std::size_t>(block));
  const OIIO::ImageSpec shape = spec;
  return encode(
      format, std::move(spec),
      [&](OIIO::ImageOutput& output) {
        for (int y = 0; y < shape.height; y += block) {
          const int rows = std::min(block, shape.height - y);
          fill(y, rows, pixels.data());
          if (!output.write_scanlines(shape.y + y, shape.y + y + rows, 0, shape.format,
                                      pixels.data())) {
            return false;
          }
        }
        return true;
      },
      what);
}

}  // namespace kappamu::io

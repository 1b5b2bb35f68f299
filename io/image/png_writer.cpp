#include "io/image/png_writer.h"

#include <png.h>
#include <zlib.h>

#include <bit>
#include <csetjmp>
#include <new>

namespace kappamu::io {

namespace {

void on_warning(png_structp, png_const_charp) {}

[[noreturn]] void on_error(png_structp png, png_const_charp) {
  png_longjmp(png, 1);
}

void append(png_structp png, png_bytep data, std::size_t length) {
  auto& bytes = *static_cast<std::vector<unsigned char>*>(png_get_io_ptr(png));
  bool appended = true;
  try {
    bytes.insert(bytes.end(), data, data + length);
  } catch (const std::bad_alloc&) {
    appended = false;  // no C++ exception passes through libpng
  }
  if (!appended) png_error(png, "memory");
}

void flush(png_structp) {}

/// Nothing here has a destructor: longjmp leaves without calling any.
bool write(png_structp png, png_infop info, const PngPixels& pixels, PngEffort effort,
           std::vector<unsigned char>& bytes) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, &bytes, append, flush);
  if (effort == PngEffort::fast) {
    png_set_compression_level(png, 1);
    png_set_compression_strategy(png, Z_RLE);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  }
  png_set_IHDR(png, info, static_cast<png_uint_32>(pixels.width),
               static_cast<png_uint_32>(pixels.height), pixels.bits,
               pixels.channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  if (pixels.bits == 16 && std::endian::native == std::endian::little) png_set_swap(png);
  const auto row = static_cast<std::size_t>(pixels.width) *
                   static_cast<std::size_t>(pixels.channels) *
                   static_cast<std::size_t>(pixels.bits / 8);
  for (int y = 0; y < pixels.height; ++y) {
    png_write_row(png,
                  static_cast<png_const_bytep>(pixels.values) + static_cast<std::size_t>(y) * row);
  }
  png_write_end(png, info);
  return true;
}

}  // namespace

std::vector<unsigned char> write_png(const PngPixels& pixels, PngEffort effort) {
  std::vector<unsigned char> bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, on_error, on_warning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  const bool written = info != nullptr && write(png, info, pixels, effort, bytes);
  png_destroy_write_struct(&png, &info);
  if (!written) throw std::bad_alloc();
  return bytes;
}

}  // namespace kappamu::io

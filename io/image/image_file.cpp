#include "io/image/image_file.h"

#include <algorithm>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/image/exr.h"
#include "io/image/image_integrity.h"
#include "io/read_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

/// OpenCV writes its decoders' complaints to standard error; ours go to the caller as exceptions.
void silence_decoders() {
  static const auto previous =
      cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  static_cast<void>(previous);
}

/// OpenCV keeps colours as B, G, R; ours are R, G, B. Works in either direction.
template <class To, class From>
void copy_swapping_red_and_blue(const From* from, To* to, std::size_t pixels, int channels) {
  if (channels == 1) {
    std::copy_n(from, pixels, to);
    return;
  }
  for (std::size_t i = 0; i < pixels; ++i, from += 3, to += 3) {
    to[0] = static_cast<To>(from[2]);
    to[1] = static_cast<To>(from[1]);
    to[2] = static_cast<To>(from[0]);
  }
}

template <class Code>
Image<std::uint16_t> from_opencv(const cv::Mat& mat) {
  Image<std::uint16_t> image(mat.cols, mat.rows, mat.channels());
  const std::size_t row = static_cast<std::size_t>(mat.cols) * mat.channels();
  for (int y = 0; y < mat.rows; ++y) {
    copy_swapping_red_and_blue(mat.ptr<Code>(y), image.values().data() + y * row,
                               static_cast<std::size_t>(mat.cols), mat.channels());
  }
  return image;
}

template <class Code>
cv::Mat to_opencv(const Image<Code>& image) {
  check(!image.empty() && (image.channels() == 1 || image.channels() == 3),
        "only images of one or three channels can be written");
  constexpr int depth = sizeof(Code) == 1 ? CV_8U : CV_16U;
  cv::Mat mat(image.height(), image.width(), CV_MAKETYPE(depth, image.channels()));
  copy_swapping_red_and_blue(image.values().data(), mat.ptr<Code>(),
                             image.size() / static_cast<std::size_t>(image.channels()),
                             image.channels());
  return mat;
}

/// For camera frames: noise hardly compresses, and looking for runs only is a third faster than
/// zlib's default search and gives smaller files (measured on 16-bit frames with shot noise).
const std::vector<int> fast_png{cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_PNG_STRATEGY,
                                cv::IMWRITE_PNG_STRATEGY_RLE};
/// For pictures on a page, small and smooth.
const std::vector<int> small_png{cv::IMWRITE_PNG_COMPRESSION, 6};

template <class Code>
std::vector<std::uint8_t> encode(const std::string& extension, const Image<Code>& image,
                                 const std::vector<int>& options) {
  silence_decoders();
  std::vector<std::uint8_t> bytes;
  bool encoded = false;
  try {
    encoded = cv::imencode(extension, to_opencv(image), bytes, options);
  } catch (const cv::Exception& error) {
    throw InternalError("internal error: OpenCV cannot encode " + extension + ": " + error.what());
  }
  check(encoded, "OpenCV cannot encode " + extension);
  return bytes;
}

template <class Code>
void write_by_extension(const fs::path& file, const Image<Code>& image) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".png" && extension != ".tif" && extension != ".tiff") {
    throw InputError("cannot write " + file.string() +
                     ": images are written as .png, .tif or .tiff, choose one of these endings");
  }
  const auto bytes = encode(extension, image, extension == ".png" ? fast_png : std::vector<int>());
  write_bytes_atomically(file, std::as_bytes(std::span(bytes)));
}

}  // namespace

Image<std::uint16_t> read_code_image(const fs::path& file) {
  silence_decoders();
  std::vector<std::byte> bytes = read_bytes(file);
  const ImageKind kind = image_kind(bytes);
  const auto fail = [&](const std::string& why) { throw InputError(file.string() + ": " + why); };
  if (bytes.empty()) fail("the file is empty");
  if (kind == ImageKind::unknown || kind == ImageKind::exr) {
    fail("not a PNG, TIFF or JPEG image");
  }
  const Integrity integrity = check_integrity(bytes);
  if (integrity != Integrity::complete) {
    fail(std::string(integrity == Integrity::truncated ? "truncated " : "damaged ") +
         to_string(kind) + " image; copy or photograph it again");
  }
  cv::Mat mat;
  const auto damaged = [&] {
    fail(std::string("unreadable ") + to_string(kind) +
         " image; it must be grey or RGB with 8 or 16 bits per channel");
  };
  try {
    if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) damaged();
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U, bytes.data());
    mat = cv::imdecode(encoded,
                       cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    damaged();
  }
  if (mat.empty() || (mat.channels() != 1 && mat.channels() != 3)) damaged();
  if (mat.depth() == CV_8U) return from_opencv<std::uint8_t>(mat);
  if (mat.depth() != CV_16U) damaged();
  return from_opencv<std::uint16_t>(mat);
}

Image<float> read_float_image(const fs::path& file) {
  const ExrImage exr = read_exr(file);
  std::vector<std::string> names;
  if (exr.channels.size() == 1) {
    names = {exr.channels.begin()->first};
  } else {
    names = {"R", "G", "B"};
  }
  Image<float> image(exr.width, exr.height, static_cast<int>(names.size()));
  for (std::size_t c = 0; c < names.size(); ++c) {
    const auto found = exr.channels.find(names[c]);
    if (found == exr.channels.end()) {
      throw InputError(file.string() + ": EXR image has no channel " + names[c] +
                       "; it must have R, G and B, or one channel only");
    }
    for (std::size_t i = 0; i < found->second.size(); ++i) {
      image.values()[i * names.size() + c] = found->second[i];
    }
  }
  return image;
}

void write_image(const fs::path& file, const Image<std::uint8_t>& image) {
  write_by_extension(file, image);
}
void write_image(const fs::path& file, const Image<std::uint16_t>& image) {
  write_by_extension(file, image);
}

void write_float_image(const fs::path& file, const Image<float>& image) {
  check(image.channels() == 1 || image.channels() == 3, "float images have one or three channels");
  ExrImage exr{image.width(), image.height(), {}, {}};
  const std::vector<std::string> names = image.channels() == 1
                                             ? std::vector<std::string>{"Y"}
                                             : std::vector<std::string>{"R", "G", "B"};
  for (std::size_t c = 0; c < names.size(); ++c) {
    std::vector<float>& plane = exr.channels[names[c]];
    plane.resize(image.size() / names.size());
    for (std::size_t i = 0; i < plane.size(); ++i) plane[i] = image.values()[i * names.size() + c];
  }
  write_exr(file, exr);
}

void write_code_image(const fs::path& file, const Image<std::uint16_t>& image, int bit_depth) {
  check(bit_depth >= 8 && bit_depth <= 16, "camera codes have 8 to 16 bits");
  const auto& codes = image.values();
  check(std::all_of(codes.begin(), codes.end(), [&](int code) { return code >> bit_depth == 0; }),
        "camera code above 2^" + std::to_string(bit_depth) + " - 1 for " + file.string());
  if (bit_depth > 8) return write_image(file, image);
  Image<std::uint8_t> narrow(image.width(), image.height(), image.channels());
  std::transform(codes.begin(), codes.end(), narrow.values().begin(),
                 [](std::uint16_t code) { return static_cast<std::uint8_t>(code); });
  write_image(file, narrow);
}

std::vector<std::uint8_t> encode_png(const Image<std::uint8_t>& image) {
  return encode(".png", image, small_png);
}

std::vector<std::uint8_t> encode_jpeg(const Image<std::uint8_t>& image, int quality) {
  return encode(".jpg", image, {cv::IMWRITE_JPEG_QUALITY, quality});
}

}  // namespace kappamu::io

#include "capture/session/frames.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "capture/session/bayer.h"
#include "capture/session/filled_border.h"
#include "core/error.h"
#include "core/file_name.h"
#include "io/image/image_file.h"

namespace kappamu::capture {
namespace {

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

std::filesystem::path existing_path(const Session& session, const Frame& frame) {
  std::filesystem::path path = session.folder / frame.file;
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw InputError(path.string() + ": no such frame; session.json lists it, so put it back or " +
                     "take it out of session.json.");
  }
  return path;
}

void check_extent(const Session& session, const std::filesystem::path& path,
                  const io::ImageSize& frame) {
  const Camera& camera = session.camera;
  if (frame.width != camera.width || frame.height != camera.height) {
    throw InputError(path.string() + ": the frame is " + size_text(frame.width, frame.height) +
                     " pixels, session.json says camera.width x camera.height = " +
                     size_text(camera.width, camera.height) +
                     "; all frames must be of the camera's full size.");
  }
}

void check_shape(const Session& session, const std::filesystem::path& path,
                 const io::ImageSize& frame) {
  check_extent(session, path, frame);
  if (frame.channels != static_cast<int>(session.channels.size())) {
    throw InputError(path.string() + ": the frame has " + std::to_string(frame.channels) +
                     " channels, session.json lists " + std::to_string(session.channels.size()) +
                     " in channels; make the two agree.");
  }
}

void check_codes(const Session& session, const std::filesystem::path& path,
                 const Image<std::uint16_t>& image) {
  const int top = largest_code(session.camera);
  const std::uint16_t largest = *std::max_element(image.values().begin(), image.values().end());
  if (largest > top) {
    throw InputError(path.string() + ": the frame holds code " + std::to_string(largest) +
                     ", session.json says camera.bit_depth = " +
                     std::to_string(session.camera.bit_depth) + ", that is at most " +
                     std::to_string(top) + "; correct bit_depth or store the codes unshifted.");
  }
}

}  // namespace

std::string shown_session(const Session& session) {
  const std::filesystem::path file = session.folder / "session.json";
  std::error_code ignored;
  return (std::filesystem::exists(file, ignored) ? file : session.folder).string();
}

bool is_float_frame(const Frame& frame) {
  return lower_extension(frame.file) == ".exr";
}

bool is_headerless(const Camera& camera, const std::filesystem::path& file) {
  return camera.raw_layout && lower_extension(file) == ".raw";
}

bool is_raw_frame(const Session& session, const Frame& frame) {
  if (is_headerless(session.camera, frame.file))
    return session.camera.raw_layout->mosaic.has_value();
  return io::is_raw_file(frame.file);
}

io::RawImage load_raw_frame(const Session& session, const Frame& frame) {
  const std::filesystem::path path = existing_path(session, frame);
  const Camera& camera = session.camera;
  if (session.channels.size() != 3 || camera.encoding != Encoding::linear) {
    throw InputError(path.string() +
                     ": a RAW frame is linear and has channels R, G, B; write camera.encoding = "
                     "'linear' and channels = [\"R\", \"G\", \"B\"] in session.json.");
  }
  io::RawImage image;
  if (is_headerless(camera, frame.file)) {
    image.mosaic = io::read_headerless_raw(path, *camera.raw_layout, camera.width, camera.height);
    image.layout = *camera.raw_layout->mosaic;
    image.white = camera.white_level.value_or(largest_code(camera));
    check_codes(session, path, image.mosaic);
    return image;
  }
  image = io::read_raw(path, [&](const io::ImageSize& size) { check_extent(session, path, size); });
  if (camera.white_level != image.white) {
    throw InputError(path.string() + ": the sensor saturates at code " +
                     std::to_string(image.white) + ", session.json says camera.white_level = " +
                     (camera.white_level ? std::to_string(*camera.white_level) : "nothing") +
                     "; write " + std::to_string(image.white) + " there.");
  }
  check_codes(session, path, image.mosaic);
  return image;
}

Image<std::uint16_t> load_sites(const Session& session, const Frame& frame) {
  if (!is_raw_frame(session, frame)) return load_frame(session, frame);
  const io::RawImage raw = load_raw_frame(session, frame);
  return pack_colours(raw.mosaic, raw.layout);
}

Image<float> load_float_frame(const Session& session, const Frame& frame) {
  const std::filesystem::path path = existing_path(session, frame);
  Image<float> image = io::read_float_image(
      path, [&](const io::ImageSize& size) { check_shape(session, path, size); });
  const auto bad = std::find_if(image.values().begin(), image.values().end(),
                                [](float value) { return !std::isfinite(value); });
  if (bad != image.values().end()) {
    const auto pixel = static_cast<long>(bad - image.values().begin()) / image.channels();
    throw InputError(
        path.string() + ": the value at pixel (" + std::to_string(pixel % image.width()) + ", " +
        std::to_string(pixel / image.width()) + ") is not finite; write the frame again.");
  }
  return image;
}

Image<std::uint16_t> load_frame(const Session& session, const Frame& frame) {
  const int top = largest_code(session.camera);
  if (is_float_frame(frame)) {
    const Image<float> linear = load_float_frame(session, frame);
    Image<std::uint16_t> codes(linear.width(), linear.height(), linear.channels());
    std::transform(
        linear.values().begin(), linear.values().end(), codes.values().begin(), [top](float value) {
          const float code = std::round(value * static_cast<float>(top));
          return static_cast<std::uint16_t>(std::clamp(code, 0.0F, static_cast<float>(top)));
        });
    return codes;
  }
  if (is_raw_frame(session, frame)) {
    const io::RawImage raw = load_raw_frame(session, frame);
    return demosaic(raw.mosaic, raw.layout);
  }
  const std::filesystem::path path = existing_path(session, frame);
  const Camera& camera = session.camera;
  Image<std::uint16_t> image =
      is_headerless(camera, frame.file)
          ? io::read_headerless_raw(path, *camera.raw_layout, camera.width, camera.height)
          : io::read_code_image(
                path, [&](const io::ImageSize& size) { check_shape(session, path, size); });
  check_codes(session, path, image);
  if (session.camera.encoding == Encoding::response) saturate_filled_border(image, top);
  return image;
}

}  // namespace kappamu::capture

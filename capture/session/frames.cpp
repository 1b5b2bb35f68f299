#include "capture/session/frames.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "capture/session/bayer.h"
#include "capture/session/filled_border.h"
#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"
#include "io/image/image_file.h"
#include "io/image/orientation.h"
#include "io/image/picture_values.h"

namespace kappamu::capture {
namespace {

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

// Of a session without a file, made of photographs alone, the first photograph tells the camera.
bool has_file(const Session& session) {
  std::error_code ignored;
  return !session.source.empty() ||
         std::filesystem::exists(session.folder / "session.json", ignored);
}

std::filesystem::path existing_path(const Session& session, const Frame& frame) {
  std::filesystem::path path = session.folder / frame.file;
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw InputError(path.string() + ": no such frame; " +
                     (has_file(session) ? shown_session(session) + " lists it: put it back or " +
                                              "take it out there."
                                        : "it was there a moment ago: put it back."));
  }
  return path;
}

int orientation_of(const Session& session) {
  return session.camera.orientation.value_or(1);
}

void check_extent(const Session& session, const std::filesystem::path& path,
                  const io::ImageSize& stored) {
  const Camera& camera = session.camera;
  io::ImageSize frame = stored;
  if (io::swaps_sides(orientation_of(session))) std::swap(frame.width, frame.height);
  if (frame.width != camera.width || frame.height != camera.height) {
    throw InputError(
        path.string() + ": the frame is " + size_text(frame.width, frame.height) + " pixels, " +
        (has_file(session) ? shown_session(session) + " says camera.width x camera.height = "
                           : "another photograph ") +
        size_text(camera.width, camera.height) + "; all frames must be of the camera's full size.");
  }
}

void check_shape(const Session& session, const std::filesystem::path& path,
                 const io::ImageSize& frame) {
  check_extent(session, path, frame);
  if (frame.channels != static_cast<int>(session.channels.size())) {
    throw InputError(
        path.string() + ": the frame has " + std::to_string(frame.channels) + " channels, " +
        (has_file(session) ? shown_session(session) + " lists " : "the other photographs have ") +
        std::to_string(session.channels.size()) + (has_file(session) ? " in channels" : "") +
        "; make the two agree.");
  }
  if (frame.bits == 8 && session.camera.bit_depth > 8) {
    throw InputError(
        path.string() + ": the frame is stored with 8 bits per channel, " +
        (has_file(session)
             ? shown_session(session) +
                   " says camera.bit_depth = " + std::to_string(session.camera.bit_depth) +
                   "; correct bit_depth, or save the frame again as the camera gave it."
             : "another photograph with 16; save all with the same number of bits, as "
               "the camera gave them."));
  }
}

void check_largest(const Session& session, const std::filesystem::path& path, int largest) {
  const int top = largest_code(session.camera);
  if (largest > top) {
    throw InputError(
        path.string() + ": the frame holds code " + std::to_string(largest) +
        (has_file(session) ? ", " + shown_session(session) + " says camera.bit_depth = "
                           : ", the photograph of the longest exposure fits into fewer bits: ") +
        std::to_string(session.camera.bit_depth) + ", that is at most " + std::to_string(top) +
        (has_file(session)
             ? "; correct bit_depth or store the codes unshifted."
             : "; correct the exposure times, or save all with the same number of bits, "
               "as the camera gave them."));
  }
}

/// As a plain loop, which compilers turn into wide registers: std::max_element() keeps a place.
std::uint16_t largest_of(const std::uint16_t* codes, std::size_t count) {
  std::uint16_t largest = 0;
  for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, codes[i]);
  return largest;
}

void check_codes(const Session& session, const std::filesystem::path& path,
                 const Image<std::uint16_t>& image) {
  check_largest(session, path, largest_of(image.values().data(), image.size()));
}

/// Whether the frame's rows can be had one by one: those of turned pictures need the whole first.
bool has_plain_rows(const Session& session, const Frame& frame) {
  return !is_float_frame(session, frame) && !is_raw_frame(session, frame) &&
         !is_headerless(session.camera, frame.file) && orientation_of(session) == 1;
}

/// Whether a row of the whole picture has filled pixels where a filled region begins.
bool touches_filled_border(const Camera& camera, std::size_t channels, int y,
                           const std::uint16_t* codes) {
  const int step = y == 0 || y == camera.height - 1 ? 1 : std::max(1, camera.width - 1);
  for (int x = 0; x < camera.width; x += step) {
    if (is_filled(codes + static_cast<std::size_t>(x) * channels, channels, largest_code(camera)))
      return true;
  }
  return false;
}

template <class T>
Image<T> kept(Image<T> picture, const Part& part) {
  return part ? cropped(std::move(picture), *part) : picture;
}

Image<std::uint16_t> read_headerless(const Camera& camera, const std::filesystem::path& path) {
  int width = camera.width, height = camera.height;
  if (io::swaps_sides(camera.orientation.value_or(1))) std::swap(width, height);
  return io::read_headerless_raw(path, *camera.raw_layout, width, height);
}

}  // namespace

std::string shown_session(const Session& session) {
  if (!session.source.empty()) return session.source.string();
  const std::filesystem::path file = session.folder / "session.json";
  std::error_code ignored;
  return (std::filesystem::exists(file, ignored) ? file : session.folder).string();
}

bool is_float_frame(const Session& session, const Frame& frame) {
  return io::is_float_image(session.folder / frame.file);
}

bool is_headerless(const Camera& camera, const std::filesystem::path& file) {
  return camera.raw_layout && lower_extension(file) == ".raw";
}

bool is_raw_frame(const Session& session, const Frame& frame) {
  if (is_headerless(session.camera, frame.file))
    return session.camera.raw_layout->mosaic.has_value();
  return io::is_raw_file(frame.file);
}

io::RawImage load_raw_frame(const Session& session, const Frame& frame, const Part& part) {
  const std::filesystem::path path = existing_path(session, frame);
  const Camera& camera = session.camera;
  io::RawImage image;
  if (is_headerless(camera, frame.file)) {
    image.codes = read_headerless(camera, path);
    image.layout = camera.raw_layout->mosaic;
    image.white = camera.white_level.value_or(largest_code(camera));
  } else {
    image =
        io::read_raw(path, [&](const io::ImageSize& size) { check_extent(session, path, size); });
  }
  const int channels = image.channels();
  if (static_cast<int>(session.channels.size()) != channels ||
      camera.encoding != Encoding::linear) {
    throw InputError(path.string() + ": this RAW frame is linear and has " +
                     (channels == 3 ? "channels R, G, B" : "one channel, grey") + "; " +
                     (has_file(session)
                          ? std::string("write camera.encoding = 'linear' and channels = ") +
                                (channels == 3 ? "[\"R\", \"G\", \"B\"]" : "[\"Y\"]") + " in " +
                                shown_session(session) + "."
                          : "the others are of another kind: give photographs of one kind."));
  }
  if (!is_headerless(camera, frame.file) && camera.white_level != image.white) {
    throw InputError(path.string() + ": the sensor saturates at code " +
                     std::to_string(image.white) + ", " +
                     (has_file(session) ? shown_session(session) + " says camera.white_level = "
                                        : "another photograph at ") +
                     (camera.white_level ? std::to_string(*camera.white_level) : "nothing") +
                     (has_file(session) ? "; write " + std::to_string(image.white) + " there."
                                        : "; give photographs of one camera and setting."));
  }
  image.codes = kept(io::turned(std::move(image.codes), orientation_of(session)), part);
  check_codes(session, path, image.codes);
  if (image.layout) {
    Image<int> cell(2, 2, 1);
    std::copy(image.layout->begin(), image.layout->end(), cell.values().begin());
    cell = io::turned(std::move(cell), orientation_of(session));
    std::copy(cell.values().begin(), cell.values().end(), image.layout->begin());
  }
  return image;
}

Image<std::uint16_t> load_sites(const Session& session, const Frame& frame) {
  if (!is_raw_frame(session, frame)) return load_frame(session, frame);
  io::RawImage raw = load_raw_frame(session, frame);
  return raw.layout ? pack_colours(raw.codes, *raw.layout) : std::move(raw.codes);
}

Image<float> load_float_frame(const Session& session, const Frame& frame, const Part& part) {
  // Codes of 8 or more bits, as RAW converters may write them, are beyond it.
  constexpr float most_full_scales = 16.0F;
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
  const float largest = *std::max_element(image.values().begin(), image.values().end());
  if (largest > most_full_scales) {
    throw InputError(path.string() + ": the frame holds " + shown_number(largest, "%.4g") +
                     ", and 1 is where the sensor saturates; divide its values by those at "
                     "saturation.");
  }
  return kept(io::turned(std::move(image), orientation_of(session)), part);
}

namespace {

/// Read as a whole before the part is taken.
Image<std::uint16_t> whole_frame(const Session& session, const Frame& frame, const Part& part) {
  const int top = largest_code(session.camera);
  if (is_float_frame(session, frame)) {
    const Image<float> linear = load_float_frame(session, frame, part);
    Image<std::uint16_t> codes(linear.width(), linear.height(), linear.channels());
    std::transform(
        linear.values().begin(), linear.values().end(), codes.values().begin(), [top](float value) {
          const float code = std::round(value * static_cast<float>(top));
          return static_cast<std::uint16_t>(std::clamp(code, 0.0F, static_cast<float>(top)));
        });
    return codes;
  }
  if (is_raw_frame(session, frame)) {
    io::RawImage raw = load_raw_frame(session, frame, part);
    return raw.layout ? demosaic(raw.codes, *raw.layout) : std::move(raw.codes);
  }
  const std::filesystem::path path = existing_path(session, frame);
  const Camera& camera = session.camera;
  Image<std::uint16_t> image = is_headerless(camera, frame.file)
                                   ? read_headerless(camera, path)
                                   : io::read_code_image(path, [&](const io::ImageSize& size) {
                                       check_shape(session, path, size);
                                     });
  check_codes(session, path, image);
  if (camera.encoding == Encoding::response) saturate_filled_border(image, top);
  return kept(io::turned(std::move(image), orientation_of(session)), part);
}

}  // namespace

Image<std::uint16_t> load_frame(const Session& session, const Frame& frame, const Part& part) {
  if (!has_plain_rows(session, frame)) return whole_frame(session, frame, part);
  const Camera& camera = session.camera;
  Image<std::uint16_t> image(part ? part->width : camera.width, part ? part->height : camera.height,
                             static_cast<int>(session.channels.size()));
  const std::size_t row = static_cast<std::size_t>(image.width()) * session.channels.size();
  load_rows(
      session, frame,
      [&](int y, const std::uint16_t* codes) { std::copy_n(codes, row, &image(0, y)); }, part);
  return image;
}

void load_rows(const Session& session, const Frame& frame, const TakeRow& take, const Part& part) {
  const Camera& camera = session.camera;
  const std::size_t channels = session.channels.size();
  const auto hand_over = [&] {
    const Image<std::uint16_t> image = whole_frame(session, frame, part);
    for (int y = 0; y < image.height(); ++y) take(y, &image(0, y));
  };
  if (!has_plain_rows(session, frame)) return hand_over();
  const std::filesystem::path path = existing_path(session, frame);
  const auto check_size = [&](const io::ImageSize& size) { check_shape(session, path, size); };
  const Region wanted = part.value_or(Region{0, 0, camera.width, camera.height});
  // A filled border may reach into the part from any edge of the picture.
  const bool looks_at_edges = camera.encoding == Encoding::response && channels > 1;
  const Region read = looks_at_edges ? Region{0, 0, camera.width, camera.height} : wanted;
  const std::size_t row = static_cast<std::size_t>(read.width) * channels;
  int largest = 0;
  bool filled = false;
  io::read_code_rows(path, check_size, read, [&](int y, const std::uint16_t* codes) {
    largest = std::max<int>(largest, largest_of(codes, row));
    filled = filled || (looks_at_edges && touches_filled_border(camera, channels, y, codes));
    const int in_part = y + read.top - wanted.top;
    if (in_part < 0 || in_part >= wanted.height) return;
    take(in_part, codes + static_cast<std::size_t>(wanted.left - read.left) * channels);
  });
  check_largest(session, path, largest);
  if (filled) hand_over();
}

Image<std::uint16_t> load_pattern(const Session& session, const Pattern& pattern) {
  const auto file = session.folder / pattern.image;
  const auto check_shape = [&](const io::ImageSize& size) {
    if (size.width == session.projector.width && size.height == session.projector.height &&
        size.channels == 1) {
      return;
    }
    throw InputError(file.string() + ": the pattern is " + size_text(size.width, size.height) +
                     " with " + std::to_string(size.channels) +
                     " channels, but the projector shows grey images of " +
                     size_text(session.projector.width, session.projector.height) +
                     "; give the image that was shown, as a grey 8-bit PNG");
  };
  Image<std::uint16_t> image = io::read_code_image(file, check_shape);
  if (std::any_of(image.values().begin(), image.values().end(),
                  [](std::uint16_t code) { return code > 255; })) {
    throw InputError(file.string() + ": the pattern has codes above 255; save it with 8 bits");
  }
  return image;
}

}  // namespace kappamu::capture

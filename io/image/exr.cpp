#include "io/image/exr.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>

#include <cstring>
#include <ostream>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/image/image_integrity.h"
#include "io/read_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

constexpr int largest_extent = 1 << 16;  ///< [px]; beyond it a header is taken for damaged

/// OpenEXR's view of bytes in memory.
class MemoryInput : public Imf::IStream {
 public:
  MemoryInput(const std::vector<std::byte>& bytes, const std::string& name)
      : Imf::IStream(name.c_str()), bytes_(bytes) {}
  bool read(char* to, int size) override {
    if (size < 0 || static_cast<std::size_t>(size) > bytes_.size() - at_) {
      throw InputError(std::string(fileName()) + ": truncated EXR file; write or copy it again");
    }
    std::memcpy(to, bytes_.data() + at_, static_cast<std::size_t>(size));
    at_ += static_cast<std::size_t>(size);
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t position) override {
    at_ = std::min<std::size_t>(static_cast<std::size_t>(position), bytes_.size());
  }

 private:
  const std::vector<std::byte>& bytes_;
  std::size_t at_ = 0;
};

/// OpenEXR's view of an output stream.
class StreamOutput : public Imf::OStream {
 public:
  StreamOutput(std::ostream& out, const std::string& name)
      : Imf::OStream(name.c_str()), out_(out) {}
  void write(const char* data, int size) override {
    if (!out_.write(data, size)) throw std::runtime_error("the disk refuses the data");
  }
  std::uint64_t tellp() override { return static_cast<std::uint64_t>(out_.tellp()); }
  void seekp(std::uint64_t position) override { out_.seekp(static_cast<std::streamoff>(position)); }

 private:
  std::ostream& out_;
};

Imf::Slice float_slice(float* first, int width) {
  const auto x_stride = sizeof(float);
  return {Imf::FLOAT, reinterpret_cast<char*>(first), x_stride,
          x_stride * static_cast<std::size_t>(width)};
}

ExrImage decode(const std::vector<std::byte>& bytes, const fs::path& file) {
  MemoryInput stream(bytes, file.string());
  Imf::InputFile input(stream);
  const Imf::Header& header = input.header();
  const Imath::Box2i window = header.dataWindow();
  const auto fail = [&](const std::string& why) { throw InputError(file.string() + ": " + why); };
  ExrImage image;
  const auto extent = [](int low, int high) { return static_cast<std::int64_t>(high) - low + 1; };
  if (extent(window.min.x, window.max.x) > largest_extent ||
      extent(window.min.y, window.max.y) > largest_extent) {
    fail("EXR data window is larger than 65536 pixels; the file is damaged or not an image");
  }
  std::int64_t channels = 0;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) ++channels;
  if (claims_too_much(static_cast<std::uint64_t>(channels * extent(window.min.x, window.max.x) *
                                                 extent(window.min.y, window.max.y)),
                      bytes.size())) {
    fail("truncated or damaged EXR file; write or copy it again");
  }
  image.width = window.max.x - window.min.x + 1;
  image.height = window.max.y - window.min.y + 1;

  Imf::FrameBuffer frame;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1) {
      fail("channel '" + std::string(it.name()) + "' is subsampled; save it at full resolution");
    }
    std::vector<float>& values = image.channels[it.name()];
    values.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    Imf::Slice slice = float_slice(values.data(), image.width);
    // OpenEXR counts from pixel (0, 0), which need not lie in the data window.
    slice.base -= static_cast<std::ptrdiff_t>(slice.xStride) * window.min.x +
                  static_cast<std::ptrdiff_t>(slice.yStride) * window.min.y;
    frame.insert(it.name(), slice);
  }
  for (auto it = header.begin(); it != header.end(); ++it) {
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute())) {
      image.attributes[it.name()] = text->value();
    }
  }
  input.setFrameBuffer(frame);
  input.readPixels(window.min.y, window.max.y);
  return image;
}

}  // namespace

ExrImage read_exr(const fs::path& file) {
  const std::vector<std::byte> bytes = read_bytes(file);
  if (bytes.size() < 4 || std::memcmp(bytes.data(), "\x76\x2f\x31\x01", 4) != 0) {
    throw InputError(file.string() + ": not an EXR file");
  }
  try {
    return decode(bytes, file);
  } catch (const InputError&) {
    throw;
  } catch (const std::exception&) {
    // OpenEXR's own texts speak of scan lines and offsets: the user's fix is the same for all.
    throw InputError(file.string() +
                     ": truncated, damaged or unusual EXR file; write or copy it again");
  }
}

void write_exr(const fs::path& file, const ExrImage& image) {
  check(image.width > 0 && image.height > 0 && !image.channels.empty(),
        "EXR image for " + file.string() + " is empty");
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer frame;
  for (const auto& [name, values] : image.channels) {
    check(values.size() ==
              static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height),
          "EXR channel " + name + " does not have the image's size");
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    // OpenEXR takes one frame buffer type for reading and writing; writing leaves it as it is.
    frame.insert(name, float_slice(const_cast<float*>(values.data()), image.width));
  }
  for (const auto& [name, text] : image.attributes) {
    header.insert(name, Imf::StringAttribute(text));
  }
  write_stream_atomically(file, [&](std::ostream& out) {
    StreamOutput stream(out, file.string());
    Imf::OutputFile output(stream, header);
    output.setFrameBuffer(frame);
    output.writePixels(image.height);
  });
}

}  // namespace kappamu::io

#include "io/image/plain_exr.h"

#include <OpenImageIO/half.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>
#include <ostream>
#include <string>
#include <string_view>

#include "core/error.h"
#include "core/numbers/widest.h"
#include "io/atomic_file.h"

namespace kappamu::io {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view begin_of_file("\x76\x2f\x31\x01\x02\0\0\0", 8);
constexpr std::uint32_t half_type = 1, float_type = 2;  // of pixels

template <class Number>
void put(std::string& to, Number value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class Number>
Number number_at(const char* from) {
  Number value{};
  std::memcpy(&value, from, sizeof value);
  return value;
}

void put_attribute(std::string& to, const std::string& name, const char* type,
                   const std::string& value) {
  to.append(name).append(1, '\0').append(type).append(1, '\0');
  put(to, static_cast<std::uint32_t>(value.size()));
  to += value;
}

std::string window_text(int left, int top, int width, int height) {
  std::string value;
  for (const int side : {left, top, left + width - 1, top + height - 1}) put(value, side);
  return value;
}

bool is_half(const ExrHeader& header, const std::string& channel) {
  return std::count(header.halves.begin(), header.halves.end(), channel) != 0;
}

/// Of the channels in the order of their names, which is the file's.
std::vector<std::size_t> file_order(const ExrHeader& header) {
  std::vector<std::size_t> order(header.channels.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return header.channels[a] < header.channels[b]; });
  return order;
}

std::size_t row_bytes(const ExrHeader& header) {
  const std::size_t pixel =
      header.channels.size() * sizeof(float) - header.halves.size() * (sizeof(float) - 2);
  return pixel * static_cast<std::size_t>(header.data.width);
}

std::string header_text(const ExrHeader& header) {
  std::string text(begin_of_file), channels, numbers;
  for (const std::size_t c : file_order(header)) {
    const std::string& name = header.channels[c];
    constexpr std::size_t longest = 31;
    check(!name.empty() && name.size() <= longest, "EXR channel name " + name);
    channels.append(name).append(1, '\0');
    for (const std::uint32_t value : {is_half(header, name) ? half_type : float_type, 0U, 1U, 1U})
      put(channels, value);
  }
  channels += '\0';
  put(numbers, 1.0F);
  put_attribute(text, "channels", "chlist", channels);
  put_attribute(text, "compression", "compression", std::string(1, '\0'));
  put_attribute(
      text, "dataWindow", "box2i",
      window_text(header.data.left, header.data.top, header.data.width, header.data.height));
  put_attribute(text, "displayWindow", "box2i", window_text(0, 0, header.width, header.height));
  put_attribute(text, "lineOrder", "lineOrder", std::string(1, '\0'));
  put_attribute(text, "pixelAspectRatio", "float", numbers);
  put_attribute(text, "screenWindowCenter", "v2f", std::string(8, '\0'));
  put_attribute(text, "screenWindowWidth", "float", numbers);
  for (const auto& [name, value] : header.attributes) put_attribute(text, name, "string", value);
  return text + '\0';
}

/// Whether all values, flags for example, are 0 or normal numbers of 16 bits. Their halves then.
KAPPAMU_WIDEST bool to_exact_halves(const float* values, std::size_t count, std::uint16_t* to) {
  constexpr std::uint32_t smallest = 0x38800000, beyond = 0x47800000;  // 2^-14, 2^16
  std::uint32_t inexact = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto bits = std::bit_cast<std::uint32_t>(values[i]);
    const std::uint32_t size = bits & 0x7fffffff;
    const std::uint32_t other = (size < smallest) | (size >= beyond) | ((size & 0x1fff) != 0);
    inexact |= size == 0 ? 0U : other;
    const std::uint32_t moved = size == 0 ? 0U : (size - (112U << 23)) >> 13;
    to[i] = static_cast<std::uint16_t>((bits >> 16 & 0x8000) | moved);
  }
  return inexact == 0;
}

/// As the file has values of 16 bits.
char* pack_halves(const std::vector<float>& values, std::vector<std::uint16_t>& halves, char* to) {
  halves.resize(values.size());
  if (!to_exact_halves(values.data(), values.size(), halves.data()))
    std::transform(values.begin(), values.end(), halves.begin(),
                   [](float value) { return half(value).bits(); });
  const std::size_t bytes = sizeof(std::uint16_t) * halves.size();
  std::memcpy(to, halves.data(), bytes);
  return to + bytes;
}

/// Takes the attributes of a header apart; false where one is not as header_text() writes it.
class HeaderReader {
 public:
  explicit HeaderReader(std::string_view text) : text_(text) {}

  bool read(ExrHeader& header) {
    if (!text_.starts_with(begin_of_file)) return false;
    at_ = begin_of_file.size();
    bool channels = false, data = false, display = false, plain = false, down = false;
    while (at_ < text_.size() && text_[at_] != '\0') {
      const std::string name = word(), type = word();
      if (text_.size() - at_ < 4) return false;
      const auto size = number_at<std::uint32_t>(&text_[at_]);
      at_ += 4;
      if (size > text_.size() - at_) return false;
      const std::string_view value = text_.substr(at_, size);
      at_ += size;
      if (name == "channels") channels = read_channels(value, header);
      if (name == "dataWindow") data = read_box(value, header.data);
      if (name == "displayWindow") display = read_box(value, display_);
      if (name == "compression") plain = value == std::string_view("\0", 1);
      if (name == "lineOrder") down = value == std::string_view("\0", 1);
      if (name == "envmap" || name == "tiles" || name == "type") return false;
      if (type == "string") header.attributes[name] = value;
    }
    header.width = display_.width;
    header.height = display_.height;
    return at_++ < text_.size() && channels && data && display && plain && down &&
           display_.left == 0 && display_.top == 0 &&
           intersection(header.data, display_) == header.data;
  }
  std::size_t end() const { return at_; }

 private:
  std::string word() {
    const std::size_t end = std::min(text_.find('\0', at_), text_.size());
    std::string result(text_.substr(at_, end - at_));
    at_ = std::min(end + 1, text_.size());
    return result;
  }
  static bool read_box(std::string_view value, Region& region) {
    if (value.size() != 16) return false;
    std::array<std::int32_t, 4> sides{};
    std::memcpy(sides.data(), value.data(), value.size());
    constexpr std::int32_t most = 1 << 16;
    for (const std::int32_t side : sides)
      if (side < 0 || side >= most) return false;
    region = {sides[0], sides[1], sides[2] - sides[0] + 1, sides[3] - sides[1] + 1};
    return region.width > 0 && region.height > 0;
  }
  static bool read_channels(std::string_view value, ExrHeader& header) {
    constexpr std::size_t described = 16, most = 64;
    while (value.size() > 1 && header.channels.size() < most) {
      const std::size_t end = value.find('\0');
      if (end == 0 || end == std::string_view::npos || value.size() - end - 1 < described)
        return false;
      const std::string name(value.substr(0, end));
      const char* description = value.data() + end + 1;
      const auto type = number_at<std::uint32_t>(description);
      const bool whole = number_at<std::uint64_t>(description + 8) == 0x1'0000'0001;
      const bool sorted = header.channels.empty() || header.channels.back() < name;
      if ((type != half_type && type != float_type) || !whole || !sorted) return false;
      header.channels.push_back(name);
      if (type == half_type) header.halves.push_back(name);
      value.remove_prefix(end + 1 + described);
    }
    return value == std::string_view("\0", 1) && !header.channels.empty();
  }

  std::string_view text_;
  std::size_t at_ = 0;
  Region display_;
};

}  // namespace

void write_plain_exr(const fs::path& file, const ExrHeader& header, const FillExrChannel& fill,
                     const WatchBytes& watch) {
  const int height = header.data.height;
  check(header.data.width > 0 && height > 0 && !header.channels.empty(),
        "EXR image for " + file.string() + " is empty");
  const std::string text = header_text(header);
  const std::vector<std::size_t> order = file_order(header);
  const std::size_t row = row_bytes(header);
  std::string table;
  for (std::uint64_t y = 0; y < static_cast<std::uint64_t>(height); ++y)
    put(table, text.size() + 8 * static_cast<std::uint64_t>(height) + y * (8 + row));
  std::vector<float> values(static_cast<std::size_t>(header.data.width));
  std::vector<std::uint16_t> halves;
  std::vector<char> packed(8 + row);
  const auto write = [&](std::ostream& out) {
    const auto put_bytes = [&](std::span<const char> bytes) {
      out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      if (watch) watch(bytes);
    };
    put_bytes(text);
    put_bytes(table);
    for (int y = 0; y < height; ++y) {
      const std::array<std::int32_t, 2> place{header.data.top + y, static_cast<std::int32_t>(row)};
      std::memcpy(packed.data(), place.data(), sizeof place);
      char* to = packed.data() + sizeof place;
      for (const std::size_t c : order) {
        fill(y, c, values.data());
        if (is_half(header, header.channels[c])) {
          to = pack_halves(values, halves, to);
        } else {
          std::memcpy(to, values.data(), sizeof(float) * values.size());
          to += sizeof(float) * values.size();
        }
      }
      put_bytes({packed.data(), to});
    }
  };
  const bool large = row * static_cast<std::size_t>(height) >= cache_bypass;
  write_stream_atomically(file, write, large ? Cache::bypassed : Cache::kept);
}

std::optional<PlainExrFile> PlainExrFile::open(const fs::path& file) {
  constexpr std::size_t longest_header = std::size_t{1} << 16;
  PlainExrFile exr;
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  exr.in_.open(file, std::ios::binary);
  if (error || !exr.in_) return {};
  std::string text(std::min<std::uintmax_t>(size, longest_header), '\0');
  exr.in_.read(text.data(), static_cast<std::streamsize>(text.size()));
  HeaderReader reader(text);
  if (!exr.in_ || !reader.read(exr.header_)) return {};
  const auto rows = static_cast<std::uint64_t>(exr.header_.data.height);
  const std::uint64_t row = 8 + row_bytes(exr.header_);
  if (size != reader.end() + rows * (8 + row)) return {};
  for (std::uint64_t y = 0; y < rows; ++y) exr.places_.push_back(reader.end() + 8 * rows + y * row);
  std::vector<std::uint64_t> table(rows);
  exr.in_.seekg(static_cast<std::streamoff>(reader.end()));
  exr.in_.read(reinterpret_cast<char*>(table.data()), static_cast<std::streamsize>(8 * rows));
  if (!exr.in_ || table != exr.places_) return {};
  exr.row_.resize(row);
  return exr;
}

bool PlainExrFile::read(int y, float* values) {
  in_.seekg(static_cast<std::streamoff>(places_[static_cast<std::size_t>(y)]));
  if (!in_.read(row_.data(), static_cast<std::streamsize>(row_.size()))) return false;
  if (number_at<std::int32_t>(row_.data()) != header_.data.top + y ||
      number_at<std::uint32_t>(&row_[4]) != row_.size() - 8) {
    return false;
  }
  const char* from = &row_[8];
  const std::size_t channels = header_.channels.size();
  for (std::size_t c = 0; c < channels; ++c) {
    const bool narrow = is_half(header_, header_.channels[c]);
    float* to = values + c;
    for (int x = 0; x < header_.data.width; ++x, to += channels) {
      if (narrow) {
        half value;
        value.setBits(number_at<std::uint16_t>(from));
        *to = value;
      } else {
        *to = number_at<float>(from);
      }
      from += narrow ? 2 : 4;
    }
  }
  return true;
}

}  // namespace kappamu::io

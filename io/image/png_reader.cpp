#include "io/image/png_reader.h"

#include <isa-l/igzip_lib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <memory>
#include <string_view>

#include "io/image/image_integrity.h"

namespace kappamu::io {

namespace {

/// Whether a reader must know the chunk (PNG specification, 5.4).
bool is_critical(std::string_view type) {
  return (type[0] & 0x20) == 0;
}

/// The inflated bytes of a zlib stream (RFC 1950) that lies in pieces. Its checksum is left out:
/// each chunk has one of its own.
class InflatedBytes {
 public:
  explicit InflatedBytes(const std::vector<std::span<const std::byte>>& pieces)
      : pieces_(pieces), state_(std::make_unique<inflate_state>()) {
    isal_inflate_init(state_.get());
    state_->crc_flag = ISAL_DEFLATE;
  }

  /// Writes the next `size` bytes. False where the stream is damaged or ends before.
  bool read(std::uint8_t* to, std::size_t size) {
    if (!begun_ && !begin()) return false;
    state_->next_out = to;
    state_->avail_out = static_cast<std::uint32_t>(size);
    while (state_->avail_out > 0) {
      if (state_->block_state == ISAL_BLOCK_FINISH) return false;
      if (state_->avail_in == 0 && piece_ < pieces_.size()) take_piece(0);
      const std::uint32_t had_in = state_->avail_in, had_out = state_->avail_out;
      if (isal_inflate(state_.get()) < ISAL_DECOMP_OK) return false;
      const bool moved = state_->avail_in != had_in || state_->avail_out != had_out;
      if (!moved && piece_ == pieces_.size()) return false;
    }
    return true;
  }

 private:
  /// The two bytes before the deflated ones: method 8, no dictionary, a multiple of 31.
  bool begin() {
    constexpr unsigned deflate = 8, dictionary = 0x20;
    constexpr std::size_t head = 2;
    std::array<unsigned, head> bytes{};
    for (std::size_t read = 0; read < head; ++piece_) {
      if (piece_ == pieces_.size()) return false;
      std::size_t at = 0;
      for (; read < head && at < pieces_[piece_].size(); ++at)
        bytes[read++] = std::to_integer<unsigned>(pieces_[piece_][at]);
      if (read < head) continue;
      take_piece(at);
      break;
    }
    begun_ = true;
    return bytes[0] % 16 == deflate && (bytes[1] & dictionary) == 0 &&
           (256 * bytes[0] + bytes[1]) % 31 == 0;
  }
  void take_piece(std::size_t from) {
    const std::span<const std::byte> piece = pieces_[piece_++].subspan(from);
    // ISA-L does not write there.
    state_->next_in =
        const_cast<std::uint8_t*>(reinterpret_cast<const std::uint8_t*>(piece.data()));
    state_->avail_in = static_cast<std::uint32_t>(piece.size());
  }

  const std::vector<std::span<const std::byte>>& pieces_;
  std::size_t piece_ = 0;  ///< the next one
  bool begun_ = false;
  std::unique_ptr<inflate_state> state_;
};

// A pixel of at most eight bytes at a time: each depends on the one before it.
typedef std::uint8_t Pixel __attribute__((vector_size(8)));     // NOLINT
typedef std::int16_t Widened __attribute__((vector_size(16)));  // NOLINT
constexpr std::size_t spare = sizeof(Pixel);  ///< bytes behind a row that may be touched

enum Filter : std::uint8_t { none, sub, up, average, paeth };

/// One of the three neighbours that is nearest to left + above − corner (PNG specification, 9.4).
[[gnu::always_inline]] inline void predict(const Pixel& left, const Pixel& above,
                                           const Pixel& corner, Pixel& predicted) {
  const Widened a = __builtin_convertvector(left, Widened);
  const Widened b = __builtin_convertvector(above, Widened);
  const Widened c = __builtin_convertvector(corner, Widened);
  const Widened by_left = b - c, by_above = a - c, by_corner = by_left + by_above;
  const Widened to_left = by_left < 0 ? -by_left : by_left;
  const Widened to_above = by_above < 0 ? -by_above : by_above;
  const Widened to_corner = by_corner < 0 ? -by_corner : by_corner;
  const Widened rest = to_above <= to_corner ? b : c;
  const Widened nearest = ((to_left <= to_above) & (to_left <= to_corner)) ? a : rest;
  predicted = __builtin_convertvector(nearest, Pixel);
}

/// Undoes the row's filter; `row` becomes what it was before, `prior` is the row above.
template <std::size_t pixel>
void unfilter(Filter filter, const std::uint8_t* prior, std::uint8_t* row, std::size_t size) {
  if (filter == none) return;
  if (filter == up) {
    for (std::size_t i = 0; i < size; ++i) row[i] = static_cast<std::uint8_t>(row[i] + prior[i]);
    return;
  }
  Pixel left{}, above{}, corner{}, value, predicted;
  for (std::size_t i = 0; i < size; i += pixel) {
    std::memcpy(&value, row + i, sizeof value);
    if (filter == sub) {
      value += left;
    } else {
      std::memcpy(&above, prior + i, sizeof above);
      if (filter == average) {
        value += (left & above) + ((left ^ above) >> 1);
      } else {
        predict(left, above, corner, predicted);
        value += predicted;
      }
      corner = above;
    }
    std::memcpy(row + i, &value, pixel);
    left = value;
  }
}

using Unfilter = void (*)(Filter, const std::uint8_t*, std::uint8_t*, std::size_t);

Unfilter unfilter_of(int channels, int bits) {
  if (channels == 1) return bits == 8 ? unfilter<1> : unfilter<2>;
  return bits == 8 ? unfilter<3> : unfilter<6>;
}

}  // namespace

std::optional<PlainPng> PlainPng::open(std::span<const std::byte> bytes) {
  using namespace std::literals;
  constexpr std::size_t signature = 8, head = 8, tail = 4, described = 13;
  PlainPng png;
  for (std::size_t at = signature; at + head + tail <= bytes.size();) {
    const std::uint64_t length = number_in(bytes, at, 4, std::endian::big);
    const std::string_view type(reinterpret_cast<const char*>(bytes.data()) + at + 4, 4);
    if (length > bytes.size() - at - head - tail) return std::nullopt;
    const std::span<const std::byte> data = bytes.subspan(at + head, length);
    if ((at == signature) != (type == "IHDR"sv)) return std::nullopt;
    if (type == "IHDR"sv) {
      if (length != described) return std::nullopt;
      const auto number = [&](std::size_t k) { return std::to_integer<int>(data[k]); };
      const std::uint64_t width = number_in(data, 0, 4, std::endian::big);
      const std::uint64_t height = number_in(data, 4, 4, std::endian::big);
      constexpr std::uint64_t longest = 1U << 24;
      constexpr int grey = 0, rgb = 2;
      const int bits = number(8), colours = number(9);
      const bool plain = (colours == grey || colours == rgb) && (bits == 8 || bits == 16) &&
                         number(10) == 0 && number(11) == 0 && number(12) == 0;
      if (!plain || width < 1 || height < 1 || width > longest || height > longest)
        return std::nullopt;
      png.size_ = {static_cast<int>(width), static_cast<int>(height), colours == grey ? 1 : 3,
                   bits};
    } else if (type == "IDAT"sv) {
      png.data_.push_back(data);
    } else if (type == "IEND"sv) {
      if (png.data_.empty()) return std::nullopt;
      return png;
    } else if (type == "tRNS"sv || (is_critical(type) && type != "PLTE"sv)) {
      return std::nullopt;
    }
    at += head + length + tail;
  }
  return std::nullopt;
}

bool PlainPng::read(int rows, const TakeRow& take) const {
  constexpr std::size_t block_bytes = std::size_t{1} << 18;
  const auto values =
      static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(size_.channels);
  const std::size_t row = values * static_cast<std::size_t>(size_.bits / 8);
  const std::size_t block = std::max<std::size_t>(1, block_bytes / (row + 1));
  const Unfilter undo = unfilter_of(size_.channels, size_.bits);
  InflatedBytes inflated(data_);
  std::vector<std::uint8_t> filtered(block * (row + 1) + spare), prior(row + spare);
  std::vector<std::uint16_t> codes(values);
  for (int y = 0; y < rows;) {
    const std::size_t count = std::min(block, static_cast<std::size_t>(rows - y));
    if (!inflated.read(filtered.data(), count * (row + 1))) return false;
    const std::uint8_t* above = prior.data();
    for (std::size_t k = 0; k < count; ++k, ++y) {
      std::uint8_t* here = &filtered[k * (row + 1)];
      const std::uint8_t filter = *here++;
      if (filter > paeth) return false;
      undo(static_cast<Filter>(filter), above, here, row);
      above = here;
      if (size_.bits == 8) {
        std::copy_n(here, values, codes.begin());
      } else {
        std::memcpy(codes.data(), here, row);
        if constexpr (std::endian::native == std::endian::little) {
          for (std::uint16_t& code : codes)
            code = static_cast<std::uint16_t>(code << 8 | code >> 8);
        }
      }
      take(y, codes.data());
    }
    std::copy_n(above, row, prior.begin());
  }
  return true;
}

}  // namespace kappamu::io

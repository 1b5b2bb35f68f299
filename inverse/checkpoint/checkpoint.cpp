#include "inverse/checkpoint/checkpoint.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "inverse/checkpoint/state_bytes.h"

namespace kappamu::inverse {

namespace {

constexpr std::uint64_t format = 0x54504b432d554d4bULL;  // "KMU-CKPT" in memory, low byte first
constexpr std::uint64_t version = 20;
constexpr std::size_t checksum_at = 4 * sizeof(std::uint64_t);
constexpr std::size_t header_bytes = checksum_at + sizeof(std::uint64_t);

std::uint64_t checksum(std::span<const std::byte> header, std::span<const std::byte> state) {
  Fingerprint print;
  print.add(header);
  print.add(state);
  return print.value();
}

}  // namespace

std::vector<std::byte> seal(std::span<const std::byte> state, std::uint64_t origin) {
  ByteWriter out;
  out(format, version, std::uint64_t{state.size()}, origin);
  out(checksum(out.bytes(), state));
  std::vector<std::byte> sealed(header_bytes + state.size());
  const auto begin = std::copy(out.bytes().begin(), out.bytes().end(), sealed.begin());
  std::copy(state.begin(), state.end(), begin);
  return sealed;
}

std::span<const std::byte> unseal(std::span<const std::byte> bytes, std::uint64_t origin) {
  if (bytes.size() < header_bytes) throw InputError("is cut short");
  ByteReader in(bytes);
  std::array<std::uint64_t, 5> header{};
  for (std::uint64_t& n : header) in(n);
  const auto [found_format, found_version, size, found_origin, sum] = header;
  if (found_format != format) throw InputError("is damaged or no checkpoint");
  if (found_version != version) throw InputError("is damaged or of another version of kappamu");
  const std::span<const std::byte> state = bytes.subspan(header_bytes);
  if (size != state.size()) throw InputError("is damaged: its length is not the one stated");
  if (sum != checksum(bytes.first(checksum_at), state)) {
    throw InputError("is damaged: its checksum does not match");
  }
  if (found_origin != origin) {
    throw InputError("belongs to other measurements or options, or is another program's");
  }
  return state;
}

}  // namespace kappamu::inverse

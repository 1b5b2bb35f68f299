// Deflate (RFC 1951) of bytes that hardly repeat, as those of photographs with noise: Huffman codes
// and runs of one byte, nothing else is searched. zlib's own strategy of that name (Z_RLE) takes
// three times as long for files of the same size.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace kappamu::io {

/// Blocks that hold `bytes` and end on a byte (an empty stored block), none of them the last: what
/// several calls give may follow each other. `end_of_deflate` closes the stream.
void deflate_runs(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& out);

/// An empty last block.
inline constexpr std::uint8_t end_of_deflate[2] = {0x03, 0x00};

}  // namespace kappamu::io

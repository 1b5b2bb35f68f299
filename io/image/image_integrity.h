// Whether the bytes of a photograph are complete. Decoders fill a truncated picture with grey or
// black and tell nobody, which would pass for a measurement.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace kappamu::io {

enum class ImageKind { png, tiff, jpeg, exr, unknown };

/// Recognises the format by its first bytes.
ImageKind image_kind(std::span<const std::byte> bytes);

/// "PNG", "TIFF", ...
const char* to_string(ImageKind kind);

enum class Integrity { complete, truncated, damaged };

/// Truncated: a PNG lacks chunks up to IEND, a JPEG its end marker, or a TIFF the strips or tiles
/// that its directory names. Damaged: a PNG chunk belies its checksum (other formats have none), or
/// the header claims more pixels than the file can hold.
Integrity check_integrity(std::span<const std::byte> bytes);

/// Whether no picture has so many numbers in so few bytes: such a header would only fill the memory
/// of whoever believed it.
bool claims_too_much(std::uint64_t numbers, std::size_t bytes);

}  // namespace kappamu::io

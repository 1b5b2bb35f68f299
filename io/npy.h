// NumPy's .npy files: shape and numbers, C order, little-endian (format versions 1.0 to 3.0 are
// read, 1.0 is written: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace kappamu::io {

struct NpyArray {
  std::vector<std::size_t> shape;  ///< slowest axis first; empty for a single number
  std::vector<float> values;       ///< C order: the last axis varies fastest
};

/// Where the numbers of a file are, for those who read parts of it.
struct NpyLayout {
  std::vector<std::size_t> shape;
  std::string type;       ///< "<f4", "<f8", "<i4", "<i8", "|u1" or "|b1"
  std::size_t begin = 0;  ///< of the numbers [bytes]
};
/// Throws InputError as read_npy().
NpyLayout read_npy_layout(const std::filesystem::path& file);

/// What a file of that `type` and shape begins with.
std::string npy_header(const std::string& type, const std::vector<std::size_t>& shape);

/// Reads float32, float64, int32, int64, uint8 and bool arrays, converted to float. Throws
/// InputError naming the file unless it is a complete little-endian C-order array of those types.
/// `expected` sees the header's shape before anything makes room for the numbers, and throws where
/// it is another.
using ShapeCheck = std::function<void(const std::vector<std::size_t>& shape)>;
NpyArray read_npy(const std::filesystem::path& file, const ShapeCheck& expected = {});

/// The `count` numbers from `first` on alone, which must lie in the array.
std::vector<float> read_npy_part(const std::filesystem::path& file, std::size_t first,
                                 std::size_t count);

/// As read_npy(), and throws InputError naming both shapes unless the array has `shape`.
NpyArray read_npy(const std::filesystem::path& file, const std::vector<std::size_t>& shape);

/// Write float32 / float64 / uint8; `values` holds as many numbers as `shape` says.
void write_npy(const std::filesystem::path& file, const std::vector<std::size_t>& shape,
               std::span<const float> values);
void write_npy(const std::filesystem::path& file, const std::vector<std::size_t>& shape,
               std::span<const double> values);
void write_npy(const std::filesystem::path& file, const std::vector<std::size_t>& shape,
               std::span<const std::uint8_t> values);

/// "[4][3][2]", for messages.
std::string shape_to_string(const std::vector<std::size_t>& shape);

}  // namespace kappamu::io

// Pictures in MATLAB's .mat files (level 5, and 7.3, which is HDF5), through matio.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "core/image.h"

namespace kappamu::io {

/// A real matrix [row][column], or page `page`, from 0, of an array [row][column][page] or
/// [row][column][1][page], as a picture [y][x] of one channel. `variable` may be empty where the
/// file holds a single numeric array. Throws InputError naming the file, and its variables where
/// the name is none of them; for complex, sparse, cell and structure arrays.
Image<float> read_mat_picture(const std::filesystem::path& file, const std::string& variable,
                              std::size_t page);

/// How many pages that array has; 1 of a matrix. Throws as read_mat_picture().
std::size_t count_mat_pages(const std::filesystem::path& file, const std::string& variable);

}  // namespace kappamu::io

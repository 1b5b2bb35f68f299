// Pages of a TIFF that holds several pictures.
#pragma once

#include <cstddef>
#include <filesystem>

#include "core/image.h"

namespace kappamu::io {

/// How many full pictures, neither previews nor masks, the pages of a TIFF hold, and one of them,
/// from 0: codes or floats as stored. Throw InputError naming the file as read_code_image()
/// (image_file.h) does, and where there is no such page.
std::size_t count_tiff_pages(const std::filesystem::path& file);
Image<float> read_tiff_page(const std::filesystem::path& file, std::size_t page);

}  // namespace kappamu::io

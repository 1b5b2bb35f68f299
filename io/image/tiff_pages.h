// Pages of a TIFF that holds several pictures.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include "core/image.h"

namespace kappamu::io {

/// The pages that are full pictures, neither previews nor masks. The file is read once and held.
class TiffPages {
 public:
  /// Throws InputError naming the file as read_code_image() (image_file.h) does.
  explicit TiffPages(const std::filesystem::path& file);
  ~TiffPages();
  TiffPages(const TiffPages&) = delete;
  TiffPages& operator=(const TiffPages&) = delete;

  std::size_t count() const;
  std::size_t bytes() const;  ///< held
  /// Codes or floats as stored; pages count from 0. Throws as above, and where there is none.
  Image<float> read(std::size_t page);

 private:
  struct Opened;
  std::unique_ptr<Opened> opened_;
};

}  // namespace kappamu::io

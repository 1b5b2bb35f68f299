// Names of pictures in sfdi.json: a file, a page of a file, or a folder of numbered frames.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/image.h"
#include "io/image/tiff_pages.h"

namespace kappamu::pipeline::sfdi {

/// The pictures that `name`, relative to `folder`, stands for, each by a name of its own:
/// - a folder: its pictures in the order of the last number in their names;
/// - "stack.tif", "stack.npy" [page][y][x], "raw.mat", "raw.mat:VARIABLE": each page;
/// - "stack.tif:2", "stack.npy:2", "raw.mat:VARIABLE:2": that page, from 0;
/// - any other file: itself.
/// A file that does not exist stands for itself: reading it says so. Throws InputError naming the
/// folder where its pictures have several endings, or where the frames' numbers are missing, appear
/// twice or leave a gap.
std::vector<std::string> pictures_named(const std::filesystem::path& folder,
                                        const std::string& name);

/// Reads them one by one. Stacks of TIFF stay open in between, up to the size of one picture file.
class PictureReader {
 public:
  /// PNG, TIFF, JPEG, BMP as codes; EXR, Radiance, float TIFF, NPY, MATLAB as floats.
  Image<float> read(const std::filesystem::path& folder, const std::string& name);

 private:
  io::TiffPages& pages_of(const std::filesystem::path& file);

  std::map<std::filesystem::path, io::TiffPages> stacks_;
};

}  // namespace kappamu::pipeline::sfdi

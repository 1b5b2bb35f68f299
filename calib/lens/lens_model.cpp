#include "calib/lens/lens_model.h"

#include <algorithm>
#include <numeric>

#include "core/error.h"

namespace kappamu::calib {
namespace {

struct ModelOfLens {
  LensModel model;
  const char* name;  ///< the numbers it estimates; "f": fx, with fy held to it
  PixelShape pixels;
  int distortion;  ///< how many of k1, k2, p1, p2, k3 ... k6, from the first
};
constexpr std::array<ModelOfLens, 9> models_of_lens{
    {{LensModel::pinhole_square, "f cx cy", PixelShape::square, 0},
     {LensModel::radial1_square, "f cx cy k1", PixelShape::square, 1},
     {LensModel::pinhole, "fx fy cx cy", PixelShape::rectangular, 0},
     {LensModel::radial1, "fx fy cx cy k1", PixelShape::rectangular, 1},
     {LensModel::radial2, "fx fy cx cy k1 k2", PixelShape::rectangular, 2},
     {LensModel::radial2_tangential, "fx fy cx cy k1 k2 p1 p2", PixelShape::rectangular, 4},
     {LensModel::full, "fx fy cx cy k1 k2 p1 p2 k3", PixelShape::rectangular, 5},
     {LensModel::rational, "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6", PixelShape::rectangular, 8},
     {LensModel::held, "held", PixelShape::rectangular, 0}}};

const ModelOfLens& entry_of(LensModel model) {
  return *std::find_if(models_of_lens.begin(), models_of_lens.end(),
                       [&](const ModelOfLens& entry) { return entry.model == model; });
}

}  // namespace

std::string to_string(LensModel model) {
  return entry_of(model).name;
}

LensModel lens_model_from_string(const std::string& name, const std::string& file) {
  for (const ModelOfLens& entry : models_of_lens) {
    if (entry.name == name) return entry.model;
  }
  throw InputError(file + ": unknown lens model \"" + name + "\"; calibrate the session again");
}

PixelShape pixel_shape(LensModel model) {
  return entry_of(model).pixels;
}

std::vector<int> fixed_numbers(LensModel model) {
  constexpr int fy = 1;
  constexpr int k1 = 4;
  std::vector<int> fixed;
  if (model == LensModel::held) {
    fixed.resize(lens_numbers);
    std::iota(fixed.begin(), fixed.end(), 0);
    return fixed;
  }
  if (pixel_shape(model) == PixelShape::square) fixed.push_back(fy);
  for (int n = k1 + entry_of(model).distortion; n < lens_numbers; ++n) fixed.push_back(n);
  return fixed;
}

int parameter_count(LensModel model) {
  return lens_numbers - static_cast<int>(fixed_numbers(model).size());
}

}  // namespace kappamu::calib

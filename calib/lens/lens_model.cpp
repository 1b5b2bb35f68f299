#include "calib/lens/lens_model.h"

#include "core/error.h"

namespace kappamu::calib {

std::string to_string(LensModel model) {
  switch (model) {
    case LensModel::pinhole_square:
      return "f cx cy";
    case LensModel::radial1_square:
      return "f cx cy k1";
    case LensModel::pinhole:
      return "fx fy cx cy";
    case LensModel::radial1:
      return "fx fy cx cy k1";
    case LensModel::radial2:
      return "fx fy cx cy k1 k2";
    case LensModel::radial2_tangential:
      return "fx fy cx cy k1 k2 p1 p2";
    case LensModel::full:
      return "fx fy cx cy k1 k2 p1 p2 k3";
    case LensModel::rational:
      return "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6";
  }
  throw InternalError("internal error: unknown lens model");
}

LensModel lens_model_from_string(const std::string& name, const std::string& file) {
  for (const LensModel model :
       {LensModel::pinhole_square, LensModel::radial1_square, LensModel::pinhole,
        LensModel::radial1, LensModel::radial2, LensModel::radial2_tangential, LensModel::full,
        LensModel::rational}) {
    if (to_string(model) == name) return model;
  }
  throw InputError(file + ": unknown lens model \"" + name + "\"; calibrate the session again");
}

bool has_square_pixels(LensModel model) {
  return model == LensModel::pinhole_square || model == LensModel::radial1_square;
}

std::vector<int> fixed_numbers(LensModel model) {
  switch (model) {
    case LensModel::pinhole_square:
      return {1, 4, 5, 6, 7, 8, 9, 10, 11};
    case LensModel::radial1_square:
      return {1, 5, 6, 7, 8, 9, 10, 11};
    case LensModel::pinhole:
      return {4, 5, 6, 7, 8, 9, 10, 11};
    case LensModel::radial1:
      return {5, 6, 7, 8, 9, 10, 11};
    case LensModel::radial2:
      return {6, 7, 8, 9, 10, 11};
    case LensModel::radial2_tangential:
      return {8, 9, 10, 11};
    case LensModel::full:
      return {9, 10, 11};
    case LensModel::rational:
      return {};
  }
  throw InternalError("internal error: unknown lens model");
}

int parameter_count(LensModel model) {
  return lens_numbers - static_cast<int>(fixed_numbers(model).size());
}

}  // namespace kappamu::calib

#include "calib/lens_model.h"

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
  }
  throw InternalError("internal error: unknown lens model");
}

bool has_square_pixels(LensModel model) {
  return model == LensModel::pinhole_square || model == LensModel::radial1_square;
}

std::vector<int> fixed_numbers(LensModel model) {
  switch (model) {
    case LensModel::pinhole_square:
      return {1, 4, 5, 6, 7, 8};
    case LensModel::radial1_square:
      return {1, 5, 6, 7, 8};
    case LensModel::pinhole:
      return {4, 5, 6, 7, 8};
    case LensModel::radial1:
      return {5, 6, 7, 8};
    case LensModel::radial2:
      return {6, 7, 8};
    case LensModel::radial2_tangential:
      return {8};
    case LensModel::full:
      return {};
  }
  throw InternalError("internal error: unknown lens model");
}

int parameter_count(LensModel model) {
  return 9 - static_cast<int>(fixed_numbers(model).size());
}

}  // namespace kappamu::calib

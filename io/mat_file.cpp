#include "io/mat_file.h"

#include <hdf5.h>
#include <matio.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/error.h"
#include "core/file_name.h"
#include "io/image/image_limits.h"

namespace kappamu::io {

namespace {

using MatFile = std::unique_ptr<mat_t, decltype(&Mat_Close)>;
using Variable = std::unique_ptr<matvar_t, decltype(&Mat_VarFree)>;

/// [row][column], [row][column][page] or, of cameras that write colours apart, [row][column][1]
/// [page].
bool is_pictures(const matvar_t& variable) {
  return variable.rank == 2 || variable.rank == 3 || (variable.rank == 4 && variable.dims[2] == 1);
}

bool is_number(const matvar_t& variable) {
  return variable.class_type >= MAT_C_DOUBLE && variable.class_type <= MAT_C_UINT64 &&
         variable.isComplex == 0 && is_pictures(variable);
}

/// The variable's dimensions, its numbers not read yet.
Variable find_variable(mat_t& mat, const std::string& name, const std::string& file) {
  std::string all;
  std::size_t numeric = 0;
  Variable found(nullptr, Mat_VarFree);
  for (Variable one(Mat_VarReadNextInfo(&mat), Mat_VarFree); one;
       one.reset(Mat_VarReadNextInfo(&mat))) {
    if (one->name == nullptr) continue;
    const std::string its_name = one->name;
    all += (all.empty() ? "" : ", ") + shown_name(its_name);
    numeric += is_number(*one) ? 1U : 0U;
    if (name.empty() ? is_number(*one) : its_name == name) found = std::move(one);
  }
  if (all.empty()) {
    throw InputError(file + ": no variable can be read; the file is damaged, truncated or empty");
  }
  if (!name.empty() && !found) {
    throw InputError(file + ": has no variable '" + shown_name(name) + "'; it holds " + all);
  }
  if (name.empty() && numeric != 1) {
    throw InputError(file + ": holds " + std::to_string(numeric) + " numeric arrays (" + all +
                     "); name one as FILE.mat:VARIABLE");
  }
  return found;
}

template <class Number>
void copy_page(const void* data, std::size_t page, Image<float>& picture) {
  const auto rows = static_cast<std::size_t>(picture.height());
  const auto* from = static_cast<const Number*>(data) + page * picture.size();
  for (int y = 0; y < picture.height(); ++y) {  // MATLAB's columns lie one after the other
    for (int x = 0; x < picture.width(); ++x) {
      picture(x, y) = static_cast<float>(
          from[static_cast<std::size_t>(x) * rows + static_cast<std::size_t>(y)]);
    }
  }
}

void copy_any(const matvar_t& variable, std::size_t page, Image<float>& picture) {
  const auto copy = [&]<class Number>() { copy_page<Number>(variable.data, page, picture); };
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      return copy.operator()<double>();
    case MAT_C_SINGLE:
      return copy.operator()<float>();
    case MAT_C_INT8:
      return copy.operator()<std::int8_t>();
    case MAT_C_UINT8:
      return copy.operator()<std::uint8_t>();
    case MAT_C_INT16:
      return copy.operator()<std::int16_t>();
    case MAT_C_UINT16:
      return copy.operator()<std::uint16_t>();
    case MAT_C_INT32:
      return copy.operator()<std::int32_t>();
    case MAT_C_UINT32:
      return copy.operator()<std::uint32_t>();
    case MAT_C_INT64:
      return copy.operator()<std::int64_t>();
    default:
      return copy.operator()<std::uint64_t>();
  }
}

/// An open file and the variable asked for, its numbers not read yet.
struct Opened {
  MatFile mat;
  Variable variable;
  std::string which;  ///< for sentences
  std::size_t rows, columns, pages;
};

Opened open_picture(const std::filesystem::path& file, const std::string& variable) {
  const std::string name = file.string();
  if (!std::filesystem::is_regular_file(file)) throw InputError(name + ": there is no such file");
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // else HDF5 prints what goes wrong
  MatFile mat(Mat_Open(name.c_str(), MAT_ACC_RDONLY), Mat_Close);
  if (!mat) {
    throw InputError(name + ": is no MATLAB file of level 5 or 7.3; save it with -v7 or -v7.3");
  }
  Variable found = find_variable(*mat, variable, name);
  const std::string which = name + ": variable '" + shown_name(found->name) + "' ";
  if (!is_number(*found)) {
    throw InputError(
        which +
        "is no real array of two or three axes; a picture is [row][column], several are "
        "[row][column][page]");
  }
  const std::size_t rows = found->dims[0], columns = found->dims[1];
  const std::size_t pages = found->rank == 2 ? 1 : found->dims[found->rank - 1];
  if (rows == 0 || columns == 0 || rows > most_image_values / columns ||
      rows * columns > most_image_values / std::max<std::size_t>(pages, 1)) {
    throw InputError(which + "has " + std::to_string(rows) + " x " + std::to_string(columns) +
                     " x " + std::to_string(pages) + " numbers; at most " +
                     std::to_string(most_image_values) + " are read");
  }
  return {std::move(mat), std::move(found), which, rows, columns, pages};
}

}  // namespace

std::size_t count_mat_pages(const std::filesystem::path& file, const std::string& variable) {
  return open_picture(file, variable).pages;
}

Image<float> read_mat_picture(const std::filesystem::path& file, const std::string& variable,
                              std::size_t page) {
  const auto [mat, found, which, rows, columns, pages] = open_picture(file, variable);
  if (page >= pages) {
    throw InputError(which + "has pages 0 to " + std::to_string(pages - 1) + ", no page " +
                     std::to_string(page));
  }
  if (Mat_VarReadDataAll(mat.get(), found.get()) != 0 || found->data == nullptr ||
      found->nbytes < rows * columns * pages * static_cast<std::size_t>(found->data_size)) {
    throw InputError(which + "cannot be read; the file is damaged or truncated");
  }
  Image<float> picture(static_cast<int>(columns), static_cast<int>(rows), 1);
  copy_any(*found, page, picture);
  return picture;
}

}  // namespace kappamu::io

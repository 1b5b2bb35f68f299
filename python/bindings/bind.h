// What the files of the bindings share: NumPy arrays in and out, and their counter of copies.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/grid.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::python {

namespace py = pybind11;

inline constexpr Names<forward::SourceModel, 2> source_names{
    {{"first-collision", forward::SourceModel::first_collision},
     {"boundary", forward::SourceModel::boundary}}};

void bind_commands(py::module_& module);
void bind_fit(py::module_& module);
void bind_forward(py::module_& module);
void bind_operator(py::module_& module);
void bind_volumes(py::module_& module);

/// Bad input of which the argument is known.
class KeyedError : public InputError {
 public:
  KeyedError(std::string of, const std::string& sentence)
      : InputError(sentence, {{std::move(of)}}) {}
};

/// Bytes that arguments were copied in, because of their type or layout or because the library owns
/// its volumes; what the package's tests of copies read.
inline std::atomic<std::size_t> copied_bytes{0};

inline std::string in_words(const py::array& array) {
  std::string text;
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += "[" + std::to_string(array.shape(i)) + "]";
  return text.empty() ? "one number" : text;
}

/// What an argument of type T is called in a sentence.
template <class T>
constexpr const char* kind_of() {
  if constexpr (std::is_same_v<T, std::string>) return "a text";
  if constexpr (std::is_same_v<T, bool>) return "True or False";
  if constexpr (std::is_unsigned_v<T>) return "a whole number that is not negative";
  if constexpr (std::is_integral_v<T>) return "a whole number";
  if constexpr (std::is_floating_point_v<T>) return "a number";
  return "three numbers";
}

/// `options[key]` as T. Throws KeyedError.
template <class T>
T value_of_key(const py::dict& options, const char* key) {
  const py::object given = options[key];
  try {
    return given.cast<T>();
  } catch (const py::cast_error&) {
    throw KeyedError(key, std::string(key) + " is " + py::repr(given).cast<std::string>() +
                              "; it must be " + kind_of<T>());
  }
}

/// What `require` refuses is of the argument `key`.
template <class Require>
void require_usual(const std::string& key, const Require& require) {
  try {
    require();
  } catch (const InputError& error) {
    throw KeyedError(key, error.what());
  }
}

inline void require_patterns(py::ssize_t patterns, const std::string& key) {
  if (patterns < 1) throw KeyedError(key, key + " has no pattern; give at least one");
}

/// Tolerance and iterations, within the bounds of the command line.
inline forward::SolveOptions solve_options(const py::dict& options) {
  constexpr double least = 1e-14, most = 0.1;
  const forward::SolveOptions solve{value_of_key<double>(options, "tolerance"),
                                    value_of_key<int>(options, "max_iterations")};
  if (!(solve.tolerance >= least && solve.tolerance <= most))
    throw KeyedError("tolerance", "tolerance must lie between 1e-14 and 0.1");
  if (solve.max_iterations < 1)
    throw KeyedError("max_iterations", "max_iterations must be at least 1");
  return solve;
}

/// Throws KeyedError where values of a masked array are hidden: they are there, and would count.
inline void require_unmasked(const py::object& given, const std::string& key) {
  if (!py::hasattr(given, "mask") || !py::hasattr(given, "filled")) return;
  if (!py::module_::import("numpy").attr("any")(given.attr("mask")).cast<bool>()) return;
  throw KeyedError(key, key +
                            " is a masked array with hidden values; fill them, and say by the mask "
                            "of Measurements which are not to be used");
}

/// `given` as numbers of type T in C order: the same memory where it has them so.
template <class T>
py::array_t<T> numbers(const py::object& given, const std::string& key) {
  using Wanted = py::array_t<T, py::array::c_style | py::array::forcecast>;
  if (given.is_none()) throw KeyedError(key, key + " is missing");
  require_unmasked(given, key);
  if (py::isinstance<py::array>(given)) {
    const char kind = py::reinterpret_borrow<py::array>(given).dtype().kind();
    if (kind != 'f' && kind != 'i' && kind != 'u' && kind != 'b' && kind != 'O')
      throw KeyedError(key, key + " holds no real numbers; convert it to float64");
  }
  const Wanted array = Wanted::ensure(given);
  if (!array) {
    PyErr_Clear();
    throw KeyedError(key, key + " is not an array of numbers");
  }
  const bool same = py::isinstance<py::array>(given) &&
                    py::reinterpret_borrow<py::array>(given).data() == array.data();
  if (!same) copied_bytes += static_cast<std::size_t>(array.nbytes());
  return array;
}

template <class T>
std::span<const T> view(const py::array_t<T>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}
template <class T>
std::span<T> view_to_fill(py::array_t<T>& array) {
  return {array.mutable_data(), static_cast<std::size_t>(array.size())};
}

/// Numbers that the library is to own.
template <class T>
std::vector<T> copy(const py::array_t<T>& array) {
  copied_bytes += static_cast<std::size_t>(array.nbytes());
  return {array.data(), array.data() + array.size()};
}

/// Throws KeyedError unless `array` has the extents; `meaning` names them: "[z][y][x]".
inline void require_shape(const py::array& array, const std::vector<py::ssize_t>& extents,
                          const std::string& key, const std::string& meaning) {
  const bool same = array.ndim() == static_cast<py::ssize_t>(extents.size()) &&
                    std::equal(extents.begin(), extents.end(), array.shape());
  if (same) return;
  std::string wanted;
  for (const py::ssize_t n : extents) wanted += "[" + std::to_string(n) + "]";
  throw KeyedError(key,
                   key + " has shape " + in_words(array) + " where " + meaning + " is " + wanted);
}

/// An array that owns `values` as they are.
template <class T>
py::array_t<T> take(std::vector<T>&& values, std::vector<py::ssize_t> shape) {
  auto owned = std::make_unique<std::vector<T>>(std::move(values));
  T* const data = owned->data();
  const py::capsule owner(owned.release(),
                          [](void* vector) { delete static_cast<std::vector<T>*>(vector); });
  return py::array_t<T>(std::move(shape), data, owner);
}

inline std::vector<py::ssize_t> extents(const GridShape& shape) {
  return {shape.nz, shape.ny, shape.nx};
}
inline std::vector<py::ssize_t> extents(int patterns, const GridShape& shape) {
  return {patterns, shape.nz, shape.ny, shape.nx};
}
inline std::vector<py::ssize_t> extents(int patterns, const FaceShape& face) {
  return {patterns, face.nv, face.nu};
}

/// The grid of an array [z][y][x]. Throws KeyedError.
inline GridShape grid_of(const py::array& array, double voxel_mm, const std::string& key) {
  if (array.ndim() != 3 || array.size() == 0)
    throw KeyedError(key, key + " has shape " + in_words(array) + "; it must be [z][y][x]");
  if (!(voxel_mm > 0.0)) throw KeyedError("voxel_mm", "voxel_mm must be positive");
  return {static_cast<int>(array.shape(2)), static_cast<int>(array.shape(1)),
          static_cast<int>(array.shape(0)), voxel_mm};
}

/// The enumerator of a name among `names`. Throws KeyedError listing them.
template <class Value, std::size_t n>
Value named(const Names<Value, n>& names, const std::string& name, const std::string& key) {
  const auto value = value_of(names, name);
  if (!value) throw KeyedError(key, key + " is '" + name + "'; it must be " + list_of(names));
  return *value;
}

}  // namespace kappamu::python

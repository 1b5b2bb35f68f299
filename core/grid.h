// Voxel grids of a block-shaped sample: shape, faces, cell-centred volumes.
//
// Sample frame: origin at the block's corner, axes x, y, z along its edges, lengths in mm; voxel
// (i, j, k) covers [i h, (i+1) h] x [j h, (j+1) h] x [k h, (k+1) h]. Arrays are [z][y][x] in C
// order: x varies fastest, as in NumPy.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/names.h"

namespace kappamu {

/// Number of voxels along each axis and the voxel edge.
struct GridShape {
  int nx = 0;
  int ny = 0;
  int nz = 0;
  double voxel_mm = 1.0;  ///< voxel edge h [mm]

  std::size_t cells() const {
    return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) *
           static_cast<std::size_t>(nz);
  }
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * ny + y) * static_cast<std::size_t>(nx) + x;
  }
  int extent(int axis) const { return axis == 0 ? nx : axis == 1 ? ny : nz; }
  bool operator==(const GridShape&) const = default;

  /// The same block with every voxel split `factor` times along each axis.
  GridShape refined(int factor) const {
    return {nx * factor, ny * factor, nz * factor, voxel_mm / factor};
  }
};

/// The six faces of the block; the sign tells the direction of the outward normal.
enum class Face { x_minus, x_plus, y_minus, y_plus, z_minus, z_plus };
inline constexpr std::array<Face, 6> all_faces{Face::x_minus, Face::x_plus,  Face::y_minus,
                                               Face::y_plus,  Face::z_minus, Face::z_plus};

inline int axis_of(Face face) {
  return static_cast<int>(face) / 2;
}
inline bool is_plus(Face face) {
  return static_cast<int>(face) % 2 == 1;
}
inline Face opposite(Face face) {
  return static_cast<Face>(static_cast<int>(face) ^ 1);
}

inline constexpr Names<Face, 6> face_names{{{"x-", Face::x_minus},
                                            {"x+", Face::x_plus},
                                            {"y-", Face::y_minus},
                                            {"y+", Face::y_plus},
                                            {"z-", Face::z_minus},
                                            {"z+", Face::z_plus}}};
inline std::string to_string(Face face) {
  return name_of(face_names, face);
}
/// Throws InputError unless `name` is one of the six names.
Face face_from_string(const std::string& name);

/// The voxels of one face as an image [v][u], u fastest: z faces (u, v) = (x, y),
/// y faces (x, z), x faces (y, z), so that arrays are [y][x], [z][x] and [z][y].
struct FaceShape {
  int nu = 0;
  int nv = 0;
  std::size_t cells() const { return static_cast<std::size_t>(nu) * static_cast<std::size_t>(nv); }
};
FaceShape face_shape(const GridShape& grid, Face face);

/// The axes of u and v.
inline std::array<int, 2> face_axes(Face face) {
  const int axis = axis_of(face);
  return {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
}

/// Cell index of the voxel `depth` layers below `face` at face position (u, v); depth 0 is at the
/// surface.
std::size_t face_cell(const GridShape& grid, Face face, int u, int v, int depth = 0);

/// One value per voxel, cell-centred, [z][y][x].
template <class T>
class Volume {
 public:
  Volume() = default;
  explicit Volume(const GridShape& shape, T value = T{})
      : shape_(shape), data_(shape.cells(), value) {}
  Volume(const GridShape& shape, std::vector<T> data) : shape_(shape), data_(std::move(data)) {}

  const GridShape& shape() const { return shape_; }
  std::size_t size() const { return data_.size(); }
  T& operator()(int x, int y, int z) { return data_[shape_.index(x, y, z)]; }
  const T& operator()(int x, int y, int z) const { return data_[shape_.index(x, y, z)]; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  std::vector<T>& values() { return data_; }
  const std::vector<T>& values() const { return data_; }

 private:
  GridShape shape_;
  std::vector<T> data_;
};

/// Optical coefficients of one colour channel.
struct Medium {
  Volume<double> kappa;  ///< diffusion coefficient κ = 1/(3(μ + σs')) [mm]
  Volume<double> mu;     ///< absorption coefficient μ [1/mm]
};

/// Throws InputError, naming the coefficient and the first offending voxel, unless every κ is
/// finite and positive and every μ finite and not negative. `source` names where it came from (a
/// file).
void validate(const Medium& medium, const std::string& source);

}  // namespace kappamu

#include "forward/grid/opencl/face_index.h"

namespace kappamu::forward {

FaceIndex face_index(const GridShape& s, Face face) {
  const FaceShape size = face_shape(s, face);
  const int axis = axis_of(face);
  const std::array<int, 3> cells{1, s.nx, s.nx * s.ny};
  const auto a = static_cast<std::size_t>(axis);
  const std::size_t u = axis == 0 ? 1 : 0;
  const std::size_t v = axis == 2 ? 1 : 2;
  const int last = is_plus(face) ? s.extent(axis) - 1 : 0;
  return {size.nu, size.nv, last * cells[a], cells[u], cells[v]};
}

int cells_inwards(const GridShape& s, Face face) {
  const int axis = axis_of(face);
  return (axis == 0 ? 1 : axis == 1 ? s.nx : s.nx * s.ny) * (is_plus(face) ? -1 : 1);
}

std::array<int, 3> column_strides(const GridShape& s, Face lit) {
  switch (axis_of(lit)) {
    case 0:
      return {0, 1, s.ny};
    case 1:
      return {1, 0, s.nx};
    default:
      return {1, s.nx, 0};
  }
}

}  // namespace kappamu::forward

#include "core/grid.h"

#include "core/error.h"
#include "core/numbers/coefficient_bounds.h"
#include "core/shown_text.h"

namespace kappamu {

Face face_from_string(const std::string& name) {
  if (const auto face = value_of(face_names, name)) return *face;
  throw InputError("face '" + name + "' is not one of x-, x+, y-, y+, z-, z+");
}

FaceShape face_shape(const GridShape& grid, Face face) {
  const auto [u, v] = face_axes(face);
  return {grid.extent(u), grid.extent(v)};
}

std::size_t face_cell(const GridShape& grid, Face face, int u, int v, int depth) {
  const int axis = axis_of(face);
  const int w = is_plus(face) ? grid.extent(axis) - 1 - depth : depth;
  switch (axis) {
    case 0:
      return grid.index(w, u, v);
    case 1:
      return grid.index(u, w, v);
    default:
      return grid.index(u, v, w);
  }
}

namespace {

void validate_one(const Volume<double>& volume, const char* name, double least, const char* rule,
                  const std::string& source) {
  const GridShape& s = volume.shape();
  for (std::size_t i = 0; i < volume.size(); ++i) {
    const double value = volume[i];
    if (value >= least && value <= most_coefficient) continue;
    const auto nx = static_cast<std::size_t>(s.nx);
    const auto ny = static_cast<std::size_t>(s.ny);
    throw InputError(source + formatted(": %s is %g at voxel x=%zu y=%zu z=%zu; %s", name, value,
                                        i % nx, i / nx % ny, i / nx / ny, rule));
  }
}

}  // namespace

void validate(const Medium& medium, const std::string& source) {
  require_usual_voxel(medium.kappa.shape().voxel_mm, source);
  validate_one(medium.kappa, "kappa", least_kappa,
               "every kappa must be positive, from 1e-9 to 1e9 mm", source);
  validate_one(medium.mu, "mu", 0.0, "every mu must be finite and not negative, at most 1e9 /mm",
               source);
}

}  // namespace kappamu

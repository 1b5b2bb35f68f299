#include "forward/grid/block_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/optics.h"
#include "core/shown_text.h"
#include "forward/grid/grid_physics.h"

namespace kappamu::forward {

namespace {

using Eigen::Vector3d;

/// Of each lit voxel, rays × rays carry its light.
constexpr int rays = 4;
/// When no more than this share of a ray is left, the rest collides where it is.
constexpr double least_power = 1e-9;
/// Nearly clear blocks may hold a totally reflected ray for ever: after so many faces, likewise.
constexpr int most_reflections = 1000;

double inward_sign(Face face) {
  return is_plus(face) ? -1.0 : 1.0;
}

std::string shown(const Vector3d& v) {
  return formatted("(%g, %g, %g)", v.x(), v.y(), v.z());
}

/// A ray of unit power; lengths in voxel edges.
struct Ray {
  Vector3d position, direction;
  std::array<int, 3> cell{};
};

/// What becomes of a ray of unit power.
struct RayFate {
  std::vector<std::pair<std::size_t, double>> scattered;  ///< voxel, power; voxels may repeat
  double absorbed = 0.0, unscattered = 0.0;
};

RayFate follow(Ray ray, const GridSetup& setup, const Medium& medium) {
  const GridShape& shape = setup.shape;
  RayFate fate;
  double power = 1.0;
  for (int reflections = 0; power > 0.0;) {
    double way = std::numeric_limits<double>::infinity();
    int axis = 0;
    for (int a = 0; a < 3; ++a) {
      const double along = ray.direction[a];
      if (along == 0.0) continue;
      const double wall = ray.cell[static_cast<std::size_t>(a)] + (along > 0.0 ? 1 : 0);
      const double reach = std::max(0.0, (wall - ray.position[a]) / along);
      if (reach < way) {
        way = reach;
        axis = a;
      }
    }
    const std::size_t i = shape.index(ray.cell[0], ray.cell[1], ray.cell[2]);
    const double thickness = way * shape.voxel_mm / (3.0 * medium.kappa[i]);
    const bool ends =
        power * std::exp(-thickness) <= least_power || reflections >= most_reflections;
    const double collided = ends ? power : -power * std::expm1(-thickness);
    const double albedo = std::max(0.0, 1.0 - 3.0 * medium.kappa[i] * medium.mu[i]);
    fate.scattered.emplace_back(i, albedo * collided);
    fate.absorbed += (1.0 - albedo) * collided;
    power -= collided;
    if (ends) break;

    const bool up = ray.direction[axis] > 0.0;
    int& along = ray.cell[static_cast<std::size_t>(axis)];
    ray.position += way * ray.direction;
    ray.position[axis] = along + (up ? 1 : 0);
    const int next = along + (up ? 1 : -1);
    if (next >= 0 && next < shape.extent(axis)) {
      along = next;
      continue;
    }
    const Face face = static_cast<Face>(2 * axis + (up ? 1 : 0));
    const double reflected =
        is_open(setup, face) ? fresnel_internal(setup.eta, std::abs(ray.direction[axis])) : 1.0;
    fate.unscattered += (1.0 - reflected) * power;
    power *= reflected;
    ray.direction[axis] = -ray.direction[axis];
    ++reflections;
  }
  return fate;
}

void add_beams(const GridSetup& setup, const Medium& medium, const LightGeometry& light,
               std::span<const double> irradiance, LightLoad& load) {
  const GridShape& shape = setup.shape;
  const FaceShape face = face_shape(shape, setup.lit_face);
  const std::size_t patterns = load.entering.size();
  const auto [u_axis, v_axis] = face_axes(setup.lit_face);
  const int axis = axis_of(setup.lit_face);
  const EnteredBeam beam = enter_beam(setup, light);
  const double per_ray =
      beam.transmittance * shape.voxel_mm * shape.voxel_mm / static_cast<double>(rays * rays);
  for (std::size_t k = 0; k < face.cells(); ++k) {
    const int u = static_cast<int>(k) % face.nu, v = static_cast<int>(k) / face.nu;
    const auto lit_by = [&](std::size_t m) { return irradiance[m * face.cells() + k]; };
    bool lit = false;
    for (std::size_t m = 0; m < patterns; ++m) lit = lit || lit_by(m) > 0.0;
    for (int r = 0; lit && r < rays * rays; ++r) {
      Ray ray{Vector3d::Zero(), beam.direction, {}};
      ray.position[u_axis] = u + (r % rays + 0.5) / rays;
      ray.position[v_axis] = v + (r / rays + 0.5) / rays;
      ray.position[axis] = is_plus(setup.lit_face) ? shape.extent(axis) : 0;
      ray.cell[static_cast<std::size_t>(u_axis)] = u;
      ray.cell[static_cast<std::size_t>(v_axis)] = v;
      ray.cell[static_cast<std::size_t>(axis)] =
          is_plus(setup.lit_face) ? shape.extent(axis) - 1 : 0;
      const RayFate fate = follow(ray, setup, medium);
      for (std::size_t m = 0; m < patterns; ++m) {
        const double power = per_ray * lit_by(m);
        if (power == 0.0) continue;
        load.absorbed[m] += power * fate.absorbed;
        load.unscattered[m] += power * fate.unscattered;
        const std::span<double> mine =
            std::span(load.source).subspan(m * shape.cells(), shape.cells());
        for (const auto& [cell, share] : fate.scattered) mine[cell] += power * share;
      }
    }
  }
}

void add_point(const GridShape& shape, const PointSource& point, std::span<double> source) {
  std::array<std::array<int, 2>, 3> cells{};
  std::array<double, 3> upper{};  // the weight of the second
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const int last = shape.extent(axis) - 1;
    const double at =
        std::clamp(point.position_mm[axis] / shape.voxel_mm - 0.5, 0.0, static_cast<double>(last));
    cells[a][0] = std::min(static_cast<int>(at), last);
    cells[a][1] = std::min(cells[a][0] + 1, last);
    upper[a] = at - cells[a][0];
  }
  for (std::size_t corner = 0; corner < 8; ++corner) {
    double weight = point.power;
    std::array<int, 3> cell{};
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t side = corner >> a & 1;
      weight *= side == 1 ? upper[a] : 1.0 - upper[a];
      cell[a] = cells[a][side];
    }
    source[shape.index(cell[0], cell[1], cell[2])] += weight;
  }
}

}  // namespace

void validate(const GridSetup& setup, const LightGeometry& light, int patterns) {
  if (light.direction) {
    const Vector3d& d = *light.direction;
    if (!d.allFinite() || !(d[axis_of(setup.lit_face)] * inward_sign(setup.lit_face) > 0.0)) {
      throw InputError("light: the direction " + shown(d) + " does not lead into the lit face " +
                       to_string(setup.lit_face) + "; give the direction in which light travels");
    }
    if (setup.source != SourceModel::first_collision) {
      throw InputError(
          "light: a direction goes with the first-collision source only; leave it out, or choose "
          "that source");
    }
  }
  if (!light.points.empty() && setup.convention == Convention::wang2008) {
    throw InputError(
        "light: convention wang2008 knows no point sources; choose the physical convention");
  }
  if (light.points.size() > static_cast<std::size_t>(patterns)) {
    throw InputError("light: has more points than patterns; each point is a pattern of its own");
  }
  for (const PointSource& point : light.points) {
    for (int axis = 0; axis < 3; ++axis) {
      const double at = point.position_mm[axis];
      const double end = setup.shape.extent(axis) * setup.shape.voxel_mm;
      if (at > 0.0 && at < end) continue;
      throw InputError(
          "light: the point " + shown(point.position_mm) +
          " does not lie inside the block, which ends at " +
          shown(Vector3d(setup.shape.nx, setup.shape.ny, setup.shape.nz) * setup.shape.voxel_mm) +
          " mm");
    }
    if (!(std::isfinite(point.power) && point.power > 0.0)) {
      throw InputError("light: the point " + shown(point.position_mm) + " has power " +
                       formatted("%g", point.power) + "; it must be positive");
    }
  }
}

EnteredBeam enter_beam(const GridSetup& setup, const LightGeometry& light) {
  const int axis = axis_of(setup.lit_face);
  Vector3d outside = Vector3d::Zero();
  outside[axis] = inward_sign(setup.lit_face);
  if (light.direction) outside = light.direction->normalized();
  const double cosine = std::abs(outside[axis]);
  EnteredBeam beam{outside / setup.eta, 1.0 - fresnel_external(setup.eta, cosine)};
  beam.direction[axis] = 0.0;
  beam.direction[axis] =
      inward_sign(setup.lit_face) * std::sqrt(1.0 - beam.direction.squaredNorm());
  return beam;
}

std::vector<double> entering_power(const GridSetup& setup, const LightGeometry& light,
                                   std::span<const double> irradiance, int patterns) {
  const std::size_t pixels = face_shape(setup.shape, setup.lit_face).cells();
  const double per_irradiance =
      enter_beam(setup, light).transmittance * setup.shape.voxel_mm * setup.shape.voxel_mm;
  std::vector<double> entering(static_cast<std::size_t>(patterns), 0.0);
  for (std::size_t m = 0; m < entering.size(); ++m) {
    for (const double e : irradiance.subspan(m * pixels, pixels)) entering[m] += per_irradiance * e;
  }
  const std::size_t first = entering.size() - light.points.size();
  for (std::size_t p = 0; p < light.points.size(); ++p) entering[first + p] = light.points[p].power;
  return entering;
}

LightLoad light_load(const GridSetup& setup, const Medium& medium, const LightGeometry& light,
                     std::span<const double> irradiance, int patterns) {
  validate(setup, light, patterns);
  const auto count = static_cast<std::size_t>(patterns);
  const std::size_t cells = setup.shape.cells();
  LightLoad load{std::vector<double>(count * cells, 0.0), std::vector<double>(count, 0.0),
                 std::vector<double>(count, 0.0), std::vector<double>(count, 0.0)};
  if (light.direction) {
    load.entering = entering_power(setup, light, irradiance, patterns);
    add_beams(setup, medium, light, irradiance, load);
  }
  const std::size_t first = count - light.points.size();
  for (std::size_t p = 0; p < light.points.size(); ++p) {
    load.entering[first + p] = light.points[p].power;
    add_point(setup.shape, light.points[p],
              std::span(load.source).subspan((first + p) * cells, cells));
  }
  return load;
}

}  // namespace kappamu::forward

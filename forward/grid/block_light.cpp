#include "forward/grid/block_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/optics.h"
#include "core/shown_text.h"
#include "forward/grid/grid_physics.h"
#include "forward/light/voxels.h"

namespace kappamu::forward {

namespace {

using Eigen::Vector3d;

/// Of each lit voxel, rays × rays carry its light.
constexpr int rays = 4;
/// When no more than this share of a ray is left, the rest collides where it is.
constexpr double least_power = 1e-9;

double inward_sign(Face face) {
  return is_plus(face) ? -1.0 : 1.0;
}

std::string shown(const Vector3d& v) {
  return formatted("(%g, %g, %g)", v.x(), v.y(), v.z());
}

void add_beams(const GridSetup& setup, const Medium& medium, const LightGeometry& light,
               std::span<const double> irradiance, LightLoad& load) {
  const GridShape& shape = setup.shape;
  const FaceShape face = face_shape(shape, setup.lit_face);
  const double h = shape.voxel_mm;
  const std::size_t patterns = load.entering.size();
  const auto [u_axis, v_axis] = face_axes(setup.lit_face);
  const int axis = axis_of(setup.lit_face);
  std::array<bool, 6> open{};
  for (const Face f : all_faces) open[static_cast<std::size_t>(f)] = is_open(setup, f);
  const BoxWalls walls(shape, setup.eta, open);
  Beam ray{static_cast<int>(setup.lit_face), Vector3d::Zero(), light.direction->normalized(),
           h * h / (rays * rays)};
  ray.position[axis] = is_plus(setup.lit_face) ? shape.extent(axis) * h : 0.0;
  std::vector<std::pair<std::size_t, double>> scattered;  // voxel, power; voxels may repeat
  for (std::size_t k = 0; k < face.cells(); ++k) {
    const int u = static_cast<int>(k) % face.nu, v = static_cast<int>(k) / face.nu;
    const auto lit_by = [&](std::size_t m) { return irradiance[m * face.cells() + k]; };
    bool lit = false;
    for (std::size_t m = 0; m < patterns; ++m) lit = lit || lit_by(m) > 0.0;
    for (int r = 0; lit && r < rays * rays; ++r) {
      ray.position[u_axis] = (u + (r % rays + 0.5) / rays) * h;
      ray.position[v_axis] = (v + (r / rays + 0.5) / rays) * h;
      scattered.clear();
      const BeamLight fate =
          march_voxels(walls, ray, least_power, medium, Vector3d::Zero(),
                       [&](std::size_t i, double power) { scattered.emplace_back(i, power); });
      for (std::size_t m = 0; m < patterns; ++m) {
        const double lit_m = lit_by(m);
        if (lit_m == 0.0) continue;
        load.absorbed[m] += lit_m * fate.absorbed[0];
        load.unscattered[m] += lit_m * fate.unscattered[0];
        const std::span<double> mine =
            std::span(load.source).subspan(m * shape.cells(), shape.cells());
        for (const auto& [cell, power] : scattered) mine[cell] += lit_m * power;
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
  Vector3d normal = Vector3d::Zero();
  normal[axis] = -inward_sign(setup.lit_face);
  const Vector3d outside = light.direction ? light.direction->normalized() : Vector3d(-normal);
  return {refracted(outside, normal, 1.0 / setup.eta),
          1.0 - fresnel_external(setup.eta, -normal.dot(outside))};
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

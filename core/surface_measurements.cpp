#include "core/surface_measurements.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/file_name.h"
#include "core/numbers/coefficient_bounds.h"

namespace kappamu {

namespace {

template <class Value>
Value from_string(const Names<Value, 2>& names, const std::string& name, const std::string& what) {
  if (const auto value = value_of(names, name)) return *value;
  throw InputError(what + " '" + name + "' is not " + list_of(names));
}

}  // namespace

Quantity quantity_from_string(const std::string& name) {
  return from_string(quantity_names, name, "quantity");
}
Light light_from_string(const std::string& name) {
  return from_string(light_names, name, "light");
}
Sides sides_from_string(const std::string& name) {
  return from_string(sides_names, name, "sides");
}

void set_seen_faces(std::vector<Face> of_patterns, Face& seen_face, std::vector<Face>& seen_faces) {
  seen_faces.clear();
  if (of_patterns.empty()) return;
  seen_face = of_patterns.front();
  const auto other = [&](Face face) { return face != seen_face; };
  if (std::ranges::any_of(of_patterns, other)) seen_faces = std::move(of_patterns);
}

void validate(const SurfaceMeasurements& m, const std::string& source) {
  const auto fail = [&](const std::string& what) { throw InputError(source + ": " + what); };
  if (m.grid.nx < 1 || m.grid.ny < 1 || m.grid.nz < 1)
    fail("grid must have at least one voxel along each axis");
  require_usual_voxel(m.grid.voxel_mm, source);
  if (!(m.eta >= 1.0) || m.eta > 4.0) fail("eta must lie between 1 and 4");
  if (m.channels.empty()) fail("channels must name at least one channel");
  for (const std::string& channel : m.channels) {
    require_plain_name(channel, source + ": a name in channels");
  }
  if (m.patterns < 1) fail("there must be at least one light pattern");
  if (m.two_faces()) {
    if (m.seen_faces.size() != static_cast<std::size_t>(m.patterns)) {
      fail("seen_faces lists " + std::to_string(m.seen_faces.size()) + " faces for " +
           std::to_string(m.patterns) + " patterns; give one for each, or leave it away");
    }
    if (m.seen_faces.front() != m.seen_face) {
      fail("seen_faces begins with " + to_string(m.seen_faces.front()) + ", and seen_face is " +
           to_string(m.seen_face) + "; seen_face is that of the first pattern");
    }
    for (const Face face : m.seen_faces) {
      if (face == m.seen_face || face == opposite(m.seen_face)) continue;
      fail("seen_faces lists " + to_string(face) + " beside " + to_string(m.seen_face) +
           "; patterns are seen on one face or on two opposite ones");
    }
  }
  for (const auto& [face, camera] : m.cameras) {
    const int axis = axis_of(face);
    const double outward =
        is_plus(face) ? camera[axis] - m.grid.extent(axis) * m.grid.voxel_mm : -camera[axis];
    if (axis_of(face) != axis_of(m.seen_face)) {
      fail("camera_mm has a camera for " + to_string(face) + ", which is not seen; name one for " +
           to_string(m.seen_face) + " or its opposite");
    }
    if (!camera.allFinite() || outward <= 0.0) {
      fail(
          "camera_mm places the camera of " + to_string(face) +
          " inside or behind the block; give x, y, z in mm from the outer corner of voxel 0, 0, 0");
    }
  }
  const std::size_t lit = m.lit_shape().cells() * static_cast<std::size_t>(m.patterns);
  const std::size_t seen =
      m.seen_shape().cells() * static_cast<std::size_t>(m.patterns) * m.channels.size();
  if (m.irradiance.size() != lit)
    fail("irradiance does not have shape [patterns][v][u] of the lit face");
  if (m.value.size() != seen)
    fail("value does not have shape [channels][patterns][v][u] of the seen face");
  if (m.variance.size() != seen) fail("variance does not have the shape of value");
  if (!m.mask.empty() && m.mask.size() != seen) fail("mask does not have the shape of value");
  if (!m.lit.empty() && m.lit.size() != seen) fail("lit does not have the shape of value");
  for (const double error : {m.smooth_error.common, m.smooth_error.own}) {
    if (!(error >= 0.0) || error > 1.0) fail("smooth_error must lie between 0 and 1");
  }
  float brightest = 0.0F;
  for (const float e : m.irradiance) {
    if (!std::isfinite(e) || e < 0.0F) fail("irradiance has a negative or non-finite value");
    brightest = std::max(brightest, e);
  }
  if (brightest == 0.0F) {
    fail("irradiance is zero everywhere; at least one pattern must light the sample");
  }
  require_usual_light(brightest, source);
  std::size_t used = 0;
  for (std::size_t i = 0; i < seen; ++i) {
    const bool is_lit = !m.lit.empty() && m.lit[i] != 0;
    if (!m.mask.empty() && m.mask[i] == 0 && !is_lit) continue;
    ++used;
    if (!std::isfinite(m.value[i])) fail("value has a non-finite entry that mask does not exclude");
    if (!std::isfinite(m.variance[i]) || m.variance[i] <= 0.0F) {
      fail("variance must be positive and finite wherever mask allows use");
    }
  }
  if (used == 0) fail("mask leaves nothing to fit");
}

}  // namespace kappamu

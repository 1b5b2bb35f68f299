#include "render/live/surface_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"

namespace kappamu::render {

using Eigen::Vector3d;

namespace {

constexpr std::size_t triangles_at_once = 2048;

/// value(κ, μ) of each channel in the middle of each triangle, a hundredth of a mean free path
/// below it.
template <class Value>
std::vector<Colour> below(const WorldObject& object, const Value& value) {
  constexpr double of_free_path = 0.01;
  std::vector<Colour> values(object.surface.size());
  for_pieces(
      values.size(), triangles_at_once, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
          for (std::size_t c = 0; c < 3; ++c) {
            const ObjectMedium& medium = *object.media.channels[c];
            const double depth = of_free_path * 3.0 * medium.smallest().kappa;
            values[t][static_cast<Eigen::Index>(c)] =
                value(medium.at(object.surface.position[t] - depth * object.surface.normal[t]));
          }
        }
      });
  return values;
}

}  // namespace

BelowSurface below_surface(const WorldObject& object) {
  BelowSurface found;
  found.albedo = below(object, [](const Coefficients& here) {
    return std::max(0.0, 1.0 - 3.0 * here.kappa * here.mu);
  });
  if (object.emission.maxCoeff() <= 0.0) return found;
  found.glow = below(
      object, [](const Coefficients& here) { return 3.0 * here.kappa / (4.0 * std::numbers::pi); });
  for (Colour& of_triangle : found.glow) of_triangle *= object.emission;
  return found;
}

Arriving arriving_on(const World& world, std::size_t object, const LightSources& sources) {
  const WorldObject& lit = world.objects()[object];
  const std::size_t triangles = lit.surface.size();
  Arriving arriving;
  for (std::size_t s = 0; s < std::min(most_drawn_sources, sources.size()); ++s) {
    auto& here = arriving.emplace_back(triangles, Eigen::Array3f::Zero());
    for_pieces(triangles, triangles_at_once, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const Vector3d at = lit.world_from_object * lit.surface.position[t];
        const Arrival arrival = sources[s]->at(at);
        const Vector3d normal = lit.world_from_object.rotation * lit.surface.normal[t];
        if (arrival.direction.dot(normal) >= 0.0 || arrival.irradiance.maxCoeff() <= 0.0) continue;
        if (world.blocked(at, -arrival.direction, arrival.distance)) continue;
        here[t] = arrival.irradiance.cast<float>();
      }
    });
  }
  return arriving;
}

double once_scattered(double cos_light_inside, double cos_view_inside) {
  return cos_light_inside / (cos_light_inside + cos_view_inside) / (4.0 * std::numbers::pi);
}

std::vector<double> exitance_once_scattered(double eta, int steps) {
  constexpr int cosines = 64;  // midpoint rule, smooth but at grazing: 1e-3
  std::vector<double> table;
  for (int i = 0; i <= steps; ++i) {
    const double light = static_cast<double>(i) / steps;
    double sum = 0.0;
    for (int k = 0; k < cosines; ++k) {
      const double c = (k + 0.5) / cosines;
      const double inside = std::sqrt(1.0 - (1.0 - c * c) / (eta * eta));
      sum += (1.0 - fresnel_external(eta, c)) / (eta * eta) * c * once_scattered(light, inside);
    }
    table.push_back(2.0 * std::numbers::pi * sum / cosines);
  }
  return table;
}

}  // namespace kappamu::render

#include "render/light/beam_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "forward/polygrid/closest_point.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

constexpr std::size_t places_per_piece = 256;
/// Edge of the cubes over the places' distance: an even surface meets 3/2 cubes per side of one.
constexpr double cube_edge = 1.22;

/// A cube's place, and which way a triangle in it faces.
using Where = std::array<int, 4>;
struct Small {
  Where where{};
  int triangle = 0;
};

/// Off a triangle's edges, of its height.
constexpr double inside = 1e-3;

std::array<Vector3d, 3> corners_of(const TriangleMesh& mesh, std::size_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return {mesh.vertices[static_cast<std::size_t>(a)], mesh.vertices[static_cast<std::size_t>(b)],
          mesh.vertices[static_cast<std::size_t>(c)]};
}

/// At the middles of `rows`² congruent parts.
void add_parts(int triangle, const std::array<Vector3d, 3>& corner, int rows, const Vector3d& area,
               std::vector<BeamPlace>& places) {
  const Vector3d along = (corner[1] - corner[0]) / rows, across = (corner[2] - corner[0]) / rows;
  const auto add = [&](double i, double j) {
    places.push_back({triangle, corner[0] + i * along + j * across, area / (rows * rows)});
  };
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; i + j < rows; ++j) {
      add(i + 1.0 / 3.0, j + 1.0 / 3.0);
      if (i + j + 1 < rows) add(i + 2.0 / 3.0, j + 2.0 / 3.0);
    }
  }
}

/// One place for small triangles, on the one nearest to the middle of all.
BeamPlace shared_place(std::span<const Small> triangles, const TriangleMesh& mesh,
                       const Surface& surface) {
  BeamPlace place;
  Vector3d middle = Vector3d::Zero();
  double area = 0.0;
  for (const Small& small : triangles) {
    const auto t = static_cast<std::size_t>(small.triangle);
    area += surface.area[t];
    place.area += surface.area[t] * surface.normal[t];
    middle += surface.area[t] * surface.position[t];
  }
  middle /= area;
  double least = std::numeric_limits<double>::infinity();
  for (const Small& small : triangles) {
    const auto [a, b, c] = corners_of(mesh, static_cast<std::size_t>(small.triangle));
    const Vector3d weights = forward::closest_weights(middle, a, b, c).cwiseMax(inside);
    const Vector3d near = (weights[0] * a + weights[1] * b + weights[2] * c) / weights.sum();
    if ((near - middle).squaredNorm() >= least) continue;
    least = (near - middle).squaredNorm();
    place.triangle = small.triangle;
    place.position = near;
  }
  return place;
}

}  // namespace

std::vector<BeamPlace> beam_places(const WorldObject& object, const BeamSpacing& spacing) {
  const Surface& surface = object.surface;
  std::vector<BeamPlace> places;
  std::vector<Small> small;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const auto triangle = static_cast<int>(t);
    if (!(surface.area[t] > 0.0)) continue;
    const double size = std::sqrt(surface.area[t]);
    if (size < spacing.of_shared) {
      Eigen::Index axis = 0;
      surface.normal[t].cwiseAbs().maxCoeff(&axis);
      const Eigen::Vector3i cube =
          (surface.position[t] / (cube_edge * spacing.of_shared)).array().floor().cast<int>();
      const int facing = 2 * static_cast<int>(axis) + (surface.normal[t][axis] > 0.0 ? 1 : 0);
      small.push_back({{cube[0], cube[1], cube[2], facing}, triangle});
      continue;
    }
    const int rows = std::max(1, static_cast<int>(std::lround(size / spacing.of_parts)));
    add_parts(triangle, corners_of(object.mesh, t), rows, surface.area[t] * surface.normal[t],
              places);
  }
  std::stable_sort(small.begin(), small.end(),
                   [](const Small& a, const Small& b) { return a.where < b.where; });
  for (auto begin = small.begin(); begin != small.end();) {
    const auto end = std::find_if(begin, small.end(),
                                  [&](const Small& each) { return each.where != begin->where; });
    places.push_back(shared_place({begin, end}, object.mesh, surface));
    begin = end;
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const BeamPlace& a, const BeamPlace& b) { return a.triangle < b.triangle; });
  return places;
}

std::vector<BeamPlace> middles_of(const WorldObject& object) {
  const Surface& surface = object.surface;
  std::vector<BeamPlace> places;
  places.reserve(surface.size());
  for (std::size_t t = 0; t < surface.size(); ++t) {
    places.push_back(
        {static_cast<int>(t), surface.position[t], surface.area[t] * surface.normal[t]});
  }
  return places;
}

void add_beams(const World& world, const WorldObject& object, const LightSources& sources,
               const BeamPlace& place, BeamsOfChannels& out) {
  const Vector3d point = object.world_from_object * place.position;
  const Vector3d& normal = object.surface.normal[static_cast<std::size_t>(place.triangle)];
  for (const auto& source : sources) {
    const Arrival arrival = source->at(point);
    const Vector3d direction = object.world_from_object.rotation.transpose() * arrival.direction;
    const double area = -direction.dot(place.area);
    if (!(area > 0.0) || direction.dot(normal) >= 0.0) continue;
    if (arrival.irradiance.maxCoeff() <= 0.0) continue;
    if (world.blocked(point, -arrival.direction, arrival.distance)) continue;
    forward::Beam beam;
    beam.triangle = place.triangle;
    beam.position = place.position;
    beam.direction = direction;
    for (std::size_t c = 0; c < 3; ++c) {
      beam.power = arrival.irradiance[static_cast<Eigen::Index>(c)] * area;
      if (beam.power > 0.0) out[c].push_back(beam);
    }
  }
}

std::array<forward::ObjectLight, 3> beams_at(const World& world, std::size_t object,
                                             const LightSources& sources,
                                             std::span<const BeamPlace> places) {
  std::vector<BeamsOfChannels> beams(pieces(places.size(), places_per_piece));
  for_pieces(places.size(), places_per_piece,
             [&](std::size_t piece, std::size_t begin, std::size_t end) {
               for (const BeamPlace& place : places.subspan(begin, end - begin)) {
                 add_beams(world, world.objects()[object], sources, place, beams[piece]);
               }
             });
  std::array<forward::ObjectLight, 3> light;
  for (std::size_t c = 0; c < 3; ++c) {
    std::size_t count = 0;
    for (const BeamsOfChannels& of_piece : beams) count += of_piece[c].size();
    light[c].beams.reserve(count);
    for (const BeamsOfChannels& of_piece : beams) {
      light[c].beams.insert(light[c].beams.end(), of_piece[c].begin(), of_piece[c].end());
    }
  }
  return light;
}

}  // namespace kappamu::render

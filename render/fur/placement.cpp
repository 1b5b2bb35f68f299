#include "render/fur/placement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "core/error.h"
#include "core/random.h"
#include "render/light/sampling.h"

namespace kappamu::render {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// A patch reaches this many tiles, and normals whose cosine with its own is above this: what is
/// projected from there is stretched by its inverse, 1.5.
constexpr double reach = 0.75, least_cosine = 1.0 / 1.5, full_cosine = 0.85;
/// A vertex with less weight than this from all patches gets its own.
constexpr double least_weight = 0.35;

}  // namespace

std::vector<SkinFrame> skin_frames(const TriangleMesh& mesh, const Fur& fur) {
  std::vector<Vector3d> normal(mesh.vertices.size(), Vector3d::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto corner = [&](int i) { return mesh.vertices[static_cast<std::size_t>(i)]; };
    const Vector3d twice = (corner(b) - corner(a)).cross(corner(c) - corner(a));
    for (const int i : {a, b, c}) normal[static_cast<std::size_t>(i)] += twice;
  }
  const double turn = fur.comb_turn_deg * std::numbers::pi / 180.0;
  std::vector<SkinFrame> frames;
  for (const Vector3d& n : normal) {
    const Vector3d out = n.norm() > 0.0 ? Vector3d(n.normalized()) : Vector3d(Vector3d::UnitZ());
    Vector3d along = fur.comb - fur.comb.dot(out) * out;
    along = along.norm() > 1e-6 ? Vector3d(along.normalized()) : Vector3d(frame_about(out).col(0));
    along = Eigen::AngleAxisd(turn, out) * along;
    SkinFrame frame;
    frame << along, out.cross(along), out;
    frames.push_back(frame);
  }
  return frames;
}

std::vector<SkinFrame> skin_frames(const TriangleMesh& mesh, const Fur& fur, const Coat& coat) {
  std::vector<SkinFrame> frames = skin_frames(mesh, fur);
  for (std::size_t v = 0; v < frames.size(); ++v) {
    if (coat.turn[v] == 0.0F) continue;
    frames[v] = frames[v] * Eigen::AngleAxisd(coat.turn[v], Vector3d::UnitZ()).toRotationMatrix();
  }
  return frames;
}

void require_tile(const TriangleMesh& mesh, double tile_mm) {
  double longest = 0.0;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d edge = mesh.vertices[static_cast<std::size_t>(t[i])] -
                            mesh.vertices[static_cast<std::size_t>(t[(i + 1) % 3])];
      longest = std::max(longest, edge.norm());
    }
  }
  if (tile_mm < 2.0 * longest) {
    throw InputError("fur: tile_mm is " + std::to_string(tile_mm) + " and the mesh's edges are " +
                     std::to_string(longest) + " mm long; write a tile_mm of at least twice that");
  }
}

Placement::Placement(const TriangleMesh& mesh, const std::vector<SkinFrame>& frames, double tile_mm,
                     std::uint64_t seed)
    : mesh_(mesh), frames_(frames), tile_mm_(tile_mm), at_vertex_(mesh.vertices.size()) {
  require_tile(mesh, tile_mm);
  std::vector<std::size_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return key_of({seed, a}) < key_of({seed, b});
  });
  for (const std::size_t v : order) {
    double most = 0.0;
    for (const int k : at_vertex_[v]) {
      most = std::max(
          most, weight(patches_[static_cast<std::size_t>(k)], mesh.vertices[v], frames[v].col(2)));
    }
    if (most < least_weight) add_patch(v, key_of({seed, v, 1}));
  }
}

void Placement::add_patch(std::size_t vertex, std::uint64_t key) {
  const int index = static_cast<int>(patches_.size());
  patches_.push_back({mesh_.vertices[vertex],
                      frames_[vertex],
                      {uniform(key_of({key, 0})), uniform(key_of({key, 1}))}});
  for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) {
    if (weight(patches_.back(), mesh_.vertices[v], frames_[v].col(2)) > 0.0) {
      at_vertex_[v].push_back(index);
    }
  }
}

double Placement::weight(const Patch& patch, const Vector3d& point, const Vector3d& normal) const {
  const double radius = reach * tile_mm_;
  const double near = 1.0 - (point - patch.centre).squaredNorm() / (radius * radius);
  if (near <= 0.0) return 0.0;
  const double facing = normal.dot(patch.frame.col(2));
  if (facing <= least_cosine) return 0.0;
  return near * near * std::min(1.0, (facing - least_cosine) / (full_cosine - least_cosine));
}

Placement::Places Placement::at(std::size_t triangle, double u, double v) const {
  const auto& t = mesh_.triangles[triangle];
  const std::array<double, 3> share{1.0 - u - v, u, v};
  Vector3d point = Vector3d::Zero(), normal = Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto vertex = static_cast<std::size_t>(t[i]);
    point += share[i] * mesh_.vertices[vertex];
    normal += share[i] * frames_[vertex].col(2);
  }
  normal.normalize();
  std::array<std::pair<double, int>, most_places> greatest{};
  const auto offer = [&](int k) {
    if (std::any_of(greatest.begin(), greatest.end(),
                    [&](const auto& m) { return m.first > 0.0 && m.second == k; })) {
      return;
    }
    std::pair<double, int> one{weight(patches_[static_cast<std::size_t>(k)], point, normal), k};
    for (auto& held : greatest) {
      if (one.first > held.first) std::swap(one, held);
    }
  };
  for (const int corner : t) {
    for (const int k : at_vertex_[static_cast<std::size_t>(corner)]) offer(k);
  }
  Places places;
  double sum = 0.0;
  for (const auto& [w, k] : greatest) {
    // The fourth power narrows the blend; from the weakest on, hairs come in gently.
    const double sharp = w * w * w * w;
    if (w <= 0.0 || sharp < 0.02 * sum) continue;
    const Patch& patch = patches_[static_cast<std::size_t>(k)];
    const Vector3d local = patch.frame.transpose() * (point - patch.centre);
    places.place[static_cast<std::size_t>(places.count++)] = {
        local.head<2>() / tile_mm_ + patch.offset, sharp};
    sum += sharp;
  }
  for (int i = 0; i < places.count; ++i) places.place[static_cast<std::size_t>(i)].weight /= sum;
  return places;
}

std::array<Placement::Places, 3> Placement::at_corners(std::size_t triangle) const {
  const auto& t = mesh_.triangles[triangle];
  std::vector<std::pair<double, int>> all;
  for (const int corner : t) {
    for (const int k : at_vertex_[static_cast<std::size_t>(corner)]) {
      if (std::none_of(all.begin(), all.end(), [&](const auto& one) { return one.second == k; })) {
        all.emplace_back(0.0, k);
      }
    }
  }
  const auto weight_at = [&](int corner, int k) {
    const auto vertex = static_cast<std::size_t>(corner);
    return weight(patches_[static_cast<std::size_t>(k)], mesh_.vertices[vertex],
                  frames_[vertex].col(2));
  };
  for (auto& [sum, k] : all) {
    for (const int corner : t) sum += weight_at(corner, k);
  }
  std::sort(all.begin(), all.end(), std::greater<>());
  std::array<Places, 3> places;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < std::min(most_places, all.size()); ++i) {
      const Patch& patch = patches_[static_cast<std::size_t>(all[i].second)];
      const Vector3d local =
          patch.frame.transpose() * (mesh_.vertices[static_cast<std::size_t>(t[c])] - patch.centre);
      places[c].place[i] = {local.head<2>() / tile_mm_ + patch.offset,
                            weight_at(t[c], all[i].second)};
      places[c].count = static_cast<int>(i) + 1;
    }
  }
  return places;
}

double Placement::stretch() const {
  double most = 1.0;
  for (std::size_t v = 0; v < at_vertex_.size(); ++v) {
    for (const int k : at_vertex_[v]) {
      const Patch& patch = patches_[static_cast<std::size_t>(k)];
      if (weight(patch, mesh_.vertices[v], frames_[v].col(2)) < 0.05) continue;
      most = std::max(most, 1.0 / frames_[v].col(2).dot(patch.frame.col(2)));
    }
  }
  return most;
}

}  // namespace kappamu::render

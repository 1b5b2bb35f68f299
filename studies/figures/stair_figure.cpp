#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/mesh/shapes.h"
#include "core/optics.h"
#include "core/random.h"
#include "forward/registry.h"
#include "render/embree_caster.h"
#include "studies/figures/figures_bench.h"

namespace kappamu::studies {

namespace {

using Eigen::Vector3d;
using std::numbers::pi;

constexpr double ball_radius = 10.0, ball_kappa = 0.15, ball_mu = 0.004, ball_eta = 1.3;

/// The ball as voxels, `across` of them along its diameter: the faces between inside and outside.
TriangleMesh stair_ball(int across) {
  const double h = 2.0 * ball_radius / across;
  const auto within = [&](int x, int y, int z) {
    const Vector3d centre =
        (Vector3d(x, y, z) + Vector3d::Constant(0.5)) * h - Vector3d::Constant(ball_radius);
    return centre.norm() < ball_radius;
  };
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> known;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [found, made] = known.emplace(at, static_cast<int>(mesh.vertices.size()));
    if (made) {
      mesh.vertices.push_back(Vector3d(at[0], at[1], at[2]) * h - Vector3d::Constant(ball_radius));
    }
    return found->second;
  };
  const auto add_face = [&](const std::array<int, 3>& cell, int axis, int side) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::array<int, 4> corner{};
    for (int k = 0; k < 4; ++k) {
      std::array<int, 3> at = cell;
      at[static_cast<std::size_t>(axis)] += side;
      at[static_cast<std::size_t>(u)] += k == 1 || k == 2 ? 1 : 0;
      at[static_cast<std::size_t>(v)] += k >= 2 ? 1 : 0;
      corner[static_cast<std::size_t>(k)] = vertex(at);
    }
    if (side == 0) std::swap(corner[1], corner[3]);
    mesh.triangles.push_back({corner[0], corner[1], corner[2]});
    mesh.triangles.push_back({corner[0], corner[2], corner[3]});
  };
  for (int z = 0; z < across; ++z) {
    for (int y = 0; y < across; ++y) {
      for (int x = 0; x < across; ++x) {
        if (!within(x, y, z)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          for (int side = 0; side < 2; ++side) {
            std::array<int, 3> next{x, y, z};
            next[static_cast<std::size_t>(axis)] += side == 0 ? -1 : 1;
            if (!within(next[0], next[1], next[2])) add_face({x, y, z}, axis, side);
          }
        }
      }
    }
  }
  return mesh;
}

/// Of a light in the middle, what leaves by diffusion of its first collisions.
double exact_share() {
  const double alpha = std::sqrt(ball_mu / ball_kappa), sigma_t = 1.0 / (3.0 * ball_kappa);
  const double robin = 2.0 * boundary_constants(ball_eta).A * ball_kappa;
  const double e = std::exp(-alpha * ball_radius), s = std::sinh(alpha * ball_radius),
               c = std::cosh(alpha * ball_radius), k = 1.0 - robin / ball_radius;
  const double b = -e * (k - robin * alpha) / (s * k + robin * alpha * c);
  const double of_centre = ball_radius * (e + b * s) / robin;
  return of_centre * (sigma_t - ball_mu) / (2.0 * alpha) *
         std::log((sigma_t + alpha) / (sigma_t - alpha));
}

struct StairAnswer {
  double share = 0.0, spread = 0.0;
  std::size_t cells = 0;
  Json map = Json::array();  ///< exitance over its mean by height and longitude; null: no facet
};

StairAnswer answer_of(const TriangleMesh& mesh, std::optional<std::uint64_t> most,
                      const Request& request, Progress& progress) {
  constexpr int rings = 16, sectors = 32;
  constexpr std::uint32_t beams = 16'384;
  const Surface surface = surface_of(mesh);
  const auto rays = render::make_embree_caster(mesh);
  const ObjectMedium medium = ObjectMedium(Coefficients{ball_kappa, ball_mu});
  forward::ObjectLight light;
  for (std::uint32_t i = 0; i < beams; ++i) {
    const auto [u, v] = sobol_point(i, request.seed);
    const double z = 1.0 - 2.0 * u, across = std::sqrt(std::max(0.0, 1.0 - z * z));
    const Vector3d direction(across * std::cos(2.0 * pi * v), across * std::sin(2.0 * pi * v), z);
    // From a ball of half a mean free path: about a point first collisions would have no bound.
    const double off = 1.5 * ball_kappa * std::cbrt(uniform(key_of({request.seed, i})));
    const auto [at_u, at_v] = sobol_point(i, mix(request.seed));
    const double at_z = 1.0 - 2.0 * at_u, at_across = std::sqrt(std::max(0.0, 1.0 - at_z * at_z));
    const Vector3d from = off * Vector3d(at_across * std::cos(2.0 * pi * at_v),
                                         at_across * std::sin(2.0 * pi * at_v), at_z);
    const auto hit = rays->first_hit(from, direction);
    if (!hit) continue;
    light.beams.push_back({hit->triangle, from, direction, 1.0 / beams});
  }
  forward::ObjectOptions options;
  options.device = request.device;
  options.max_elements = most;
  const auto model = forward::make_object_model("embedded", forward::ModelError::left_out);
  const std::vector<forward::ObjectLight> lights{light};
  const forward::ObjectResult result =
      model->solve({mesh, surface, *rays, medium, ball_eta, lights}, options, progress);
  std::vector<double> power(rings * sectors, 0.0), facets(rings * sectors, 0.0);
  for (std::size_t t = 0; t < result.exitance.size(); ++t) {
    const Vector3d d = surface.position[t].normalized();
    const int ring = std::min(rings - 1, static_cast<int>((0.5 + 0.5 * d.z()) * rings));
    const double turn = std::atan2(d.y(), d.x()) / (2.0 * pi) + 0.5;
    const int sector = std::min(sectors - 1, static_cast<int>(turn * sectors));
    const auto place = static_cast<std::size_t>(ring * sectors + sector);
    power[place] += result.exitance[t] * surface.area[t];
    facets[place] += surface.area[t];
  }
  StairAnswer answer;
  answer.cells = result.elements;
  answer.share = result.balance[0].exiting;
  double area = 0.0;
  for (std::size_t t = 0; t < surface.size(); ++t) area += surface.area[t];
  for (std::size_t t = 0; t < result.exitance.size(); ++t) {
    answer.spread +=
        surface.area[t] / area * std::pow(result.exitance[t] * area / answer.share - 1.0, 2);
  }
  answer.spread = std::sqrt(answer.spread);
  for (int ring = 0; ring < rings; ++ring) {
    Json row = Json::array();
    for (int s = 0; s < sectors; ++s) {
      const auto place = static_cast<std::size_t>(ring * sectors + s);
      // Coarse steps leave places without a facet's middle.
      row.push_back(facets[place] > 0.0 ? Json(power[place] / facets[place] * area / answer.share)
                                        : Json(nullptr));
    }
    answer.map.push_back(std::move(row));
  }
  return answer;
}

}  // namespace

void figure_stairs(const Request& request, Progress& progress, const Save& save) {
  const double exact = exact_share();
  Json rows = Json::array(), maps = Json::array();
  std::vector<int> across{8, 16};
  if (request.size == Size::quick) across = {8};
  if (request.size == Size::full) across.push_back(32);
  const auto add = [&](const std::string& name, int n, const StairAnswer& answer) {
    rows.push_back({{"boundary", name},
                    {"cells across", n},
                    {"cells", answer.cells},
                    {"leaves", answer.share},
                    {"exact", exact},
                    {"error", answer.share / exact - 1.0},
                    {"spread of exitance", answer.spread}});
    maps.push_back({{"boundary", name}, {"across", n}, {"map", answer.map}});
    save({{"rows", rows}, {"maps", maps}});
  };
  for (const int n : across) {
    const StairAnswer stairs = answer_of(stair_ball(n), std::nullopt, request, progress);
    add("stair steps", n, stairs);
    add("cut cells", n,
        answer_of(sphere_mesh(ball_radius, 2 * n), stairs.cells, request, progress));
  }
}

}  // namespace kappamu::studies

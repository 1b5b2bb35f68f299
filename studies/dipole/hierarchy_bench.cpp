// Section `hierarchy`: [M] Table 3 again. The numbers of triangles are [M]'s, on a torus in a box
// of 25 mm; light from one side, marble of Jensen et al. 2001 in red, green and blue. Section
// `point-sampling`: [M] Table 5, the same torus from 5 to 80 cm.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/processor_time.h"
#include "core/random.h"
#include "forward/dipole/direct/direct_sum.h"
#include "forward/dipole/form_factor/form_factor.h"
#include "forward/dipole/hierarchy/hierarchy.h"
#include "studies/dipole/dipole_bench.h"

namespace kappamu::studies {

namespace {

using namespace forward;
using namespace forward::dipole;

constexpr double hierarchy_size_mm = 25.0;
constexpr double tube_share = 0.209;  // of the outer radius: quads are square
constexpr int checked = 60;           // triangles where the direct sum is taken

}  // namespace

TriangleMesh torus(const Quads& quads, double size_mm) {
  const double minor = 0.5 * size_mm * tube_share, major = 0.5 * size_mm - minor;
  TriangleMesh mesh;
  for (int i = 0; i < quads.tube; ++i) {
    for (int j = 0; j < quads.around; ++j) {
      const double u = 2.0 * std::numbers::pi * i / quads.tube;
      const double v = 2.0 * std::numbers::pi * j / quads.around;
      const double r = major + minor * std::cos(u);
      mesh.vertices.emplace_back(r * std::cos(v), r * std::sin(v), minor * std::sin(u));
    }
  }
  const auto at = [&](int i, int j) { return i % quads.tube * quads.around + j % quads.around; };
  for (int i = 0; i < quads.tube; ++i) {
    for (int j = 0; j < quads.around; ++j) {
      mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
  }
  return mesh;
}

std::vector<Profile> red_green_blue_marble(double scale) {
  std::vector<Profile> profiles;
  for (const auto& [scattering, absorption] :
       {std::pair{2.19, 0.0021}, std::pair{2.62, 0.0041}, std::pair{3.00, 0.0071}}) {
    profiles.push_back(make_profile(
        "dipole", {scale / (3.0 * (scattering + absorption)), absorption / scale}, 1.3));
  }
  return profiles;
}

namespace {

std::vector<Eigen::Array4f> sunlight(const Surface& surface) {
  const Eigen::Vector3d sun = Eigen::Vector3d(1, 1, 1).normalized();
  std::vector<Eigen::Array4f> light;
  for (const Eigen::Vector3d& normal : surface.normal) {
    light.push_back(Eigen::Array4f::Constant(static_cast<float>(std::max(0.0, normal.dot(sun)))));
  }
  return light;
}

/// Relative 2-norm error of the worst channel, at triangles drawn at random.
double error_of(const TriangleMesh& mesh, const std::vector<Profile>& profiles,
                const std::vector<Eigen::Array4f>& light,
                const std::vector<Eigen::Array4f>& exitance, std::uint64_t seed) {
  const Surface surface = surface_of(mesh);
  std::vector<std::size_t> receivers;
  for (std::uint64_t i = 0; i < checked; ++i) {
    receivers.push_back(
        static_cast<std::size_t>(uniform(key_of({seed, i})) * static_cast<double>(surface.size())));
  }
  std::vector<double> irradiance;
  for (const Eigen::Array4f& e : light) irradiance.push_back(static_cast<double>(e[0]));
  double worst = 0.0;
  for (std::size_t c = 0; c < profiles.size(); ++c) {
    const std::vector<double> exact =
        direct_sum(mesh, surface, profiles[c], Placement::rotated, irradiance, receivers);
    double difference = 0.0, size = 0.0;
    for (std::size_t i = 0; i < receivers.size(); ++i) {
      const double area = surface.area[receivers[i]];
      const double found =
          static_cast<double>(exitance[receivers[i]][static_cast<Eigen::Index>(c)]);
      difference += area * (found - exact[i]) * (found - exact[i]);
      size += area * exact[i] * exact[i];
    }
    worst = std::max(worst, std::sqrt(difference / size));
  }
  return worst;
}

struct Times {
  double wall_ms = 0.0, least_wall_ms = 0.0, cpu_ms = 0.0;
};

Times timed(int repetitions, const std::function<void()>& frame) {
  frame();
  std::vector<double> wall, cpu;
  for (int i = 0; i < repetitions; ++i) {
    const Stopwatch watch;
    const double before = processor_seconds();
    frame();
    cpu.push_back(1e3 * (processor_seconds() - before));
    wall.push_back(watch.milliseconds());
  }
  return {median(wall), *std::min_element(wall.begin(), wall.end()), median(cpu)};
}

}  // namespace

HierarchyCost hierarchy_cost(device::Context& context, const Quads& quads, int repetitions,
                             std::uint64_t seed) {
  const std::vector<Profile> profiles = red_green_blue_marble(1.0),
                             other = red_green_blue_marble(1.02);
  const TriangleMesh mesh = torus(quads, hierarchy_size_mm);
  TriangleMesh bent = mesh;
  for (Eigen::Vector3d& v : bent.vertices) v.z() += 0.2 * std::sin(0.3 * v.x());
  const std::vector<Eigen::Array4f> light = sunlight(surface_of(mesh));
  const auto triangles = static_cast<double>(mesh.triangles.size());
  const Stopwatch watch;
  Hierarchy hierarchy(context, mesh, profiles, HierarchyOptions());
  const double build = watch.seconds();
  std::vector<Eigen::Array4f> exitance;
  const double error = error_of(mesh, profiles, light, hierarchy.exitance(light), seed);
  const std::size_t links = hierarchy.links(), near = hierarchy.near_pairs();
  const Times still = timed(repetitions, [&] { exitance = hierarchy.exitance(light); });
  bool turn = false;
  std::size_t moved = 0;
  const Times incremental = timed(repetitions, [&] {
    turn = !turn;
    hierarchy.update(turn ? bent : mesh, turn ? other : profiles);
    moved = hierarchy.changes().demoted + hierarchy.changes().promoted;
    exitance = hierarchy.exitance(light);
  });
  const Times fly = timed(repetitions, [&] {
    turn = !turn;
    hierarchy.renew(turn ? bent : mesh, turn ? other : profiles);
    exitance = hierarchy.exitance(light);
  });
  const std::size_t launches = context
                                   .launches_of([&] {
                                     hierarchy.renew(mesh, profiles);
                                     hierarchy.exitance(light);
                                   })
                                   .size();
  return {{{"triangles", mesh.triangles.size()},
           {"launches", launches},
           {"links_per_triangle", static_cast<double>(links) / triangles},
           {"near_leaf_pairs_per_triangle", static_cast<double>(near) / triangles},
           {"error", error},
           {"static_ms", still.wall_ms},
           {"static_least_ms", still.least_wall_ms},
           {"static_cpu_ms", still.cpu_ms},
           {"incremental_ms", incremental.wall_ms},
           {"incremental_least_ms", incremental.least_wall_ms},
           {"incremental_cpu_ms", incremental.cpu_ms},
           {"links_moved", moved},
           {"on_the_fly_ms", fly.wall_ms},
           {"on_the_fly_least_ms", fly.least_wall_ms},
           {"on_the_fly_cpu_ms", fly.cpu_ms},
           {"first_frame_seconds", build}},
          std::move(exitance)};
}

void dipole_hierarchy(const Request& request, Progress& progress, const Save& save) {
  std::vector<Quads> sizes(hierarchy_quads.begin(), hierarchy_quads.end());
  if (request.size == Size::quick) sizes.resize(1);
  const int repetitions = request.count("repetitions", request.size == Size::quick ? 2 : 15);
  device::Context& context = device::Context::chosen(request.device);
  Json rows = Json::array();
  for (const Quads& quads : sizes) {
    progress.update("bench dipole", 0.5,
                    std::to_string(2 * quads.tube * quads.around) + " triangles");
    rows.push_back(hierarchy_cost(context, quads, repetitions, request.seed).row);
    save({{"repetitions", repetitions},
          {"opening", HierarchyOptions().opening},
          {"device_name", context.info().name},
          {"rows", rows}});
  }
}

namespace {

/// What near triangles send to every triangle, by one rule for a pair.
template <class Pair>
std::vector<double> near_light(const ClusterTree& tree, const Links& links,
                               const std::vector<Eigen::Array4f>& light, const Pair& pair) {
  std::vector<double> exitance(tree.triangles());
  const int depth = tree.depth();
  for (std::size_t leaf = 0; leaf < links.of_leaf.size(); ++leaf) {
    const LinkRange range = links.of_leaf[leaf];
    for (int j = range.first; j < range.first + range.count; ++j) {
      const auto other = static_cast<std::size_t>(links.near[static_cast<std::size_t>(j)]);
      for (std::size_t to = tree.begin(depth, leaf); to < tree.begin(depth, leaf + 1); ++to) {
        for (std::size_t of = tree.begin(depth, other); of < tree.begin(depth, other + 1); ++of) {
          const auto emitter = static_cast<std::size_t>(tree.order()[of]);
          const double e = static_cast<double>(light[emitter][0]);
          const auto receiver = static_cast<std::size_t>(tree.order()[to]);
          if (e > 0.0) exitance[receiver] += e * pair(receiver, emitter);
        }
      }
    }
  }
  return exitance;
}

double area_norm(const Surface& surface, const std::vector<double>& of) {
  double sum = 0.0;
  for (std::size_t t = 0; t < of.size(); ++t) sum += surface.area[t] * of[t] * of[t];
  return std::sqrt(sum);
}

std::vector<double> difference(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t t = 0; t < a.size(); ++t) a[t] -= b[t];
  return a;
}

}  // namespace

void dipole_point_sampling(const Request& request, Progress& progress, const Save& save) {
  const Quads quads = request.size == Size::quick ? Quads{8, 30} : Quads{48, 171};
  std::vector<double> sizes{50.0, 100.0, 200.0, 400.0, 800.0};
  if (request.size == Size::quick) sizes.resize(2);
  const int repetitions = request.count("repetitions", request.size == Size::quick ? 2 : 3);
  const Material marble_green{1.0 / (3.0 * (2.62 + 0.0041)), 0.0041};
  const std::vector<Profile> profiles{make_profile("dipole", marble_green, 1.3)};
  const Profile& profile = profiles.front();
  const double disc = std::numbers::pi * std::pow(3.0 * marble_green.kappa, 2);
  device::Context& context = device::Context::chosen(request.device);
  Json rows = Json::array();
  for (const double size : sizes) {
    progress.update("bench dipole", 0.5, std::to_string(static_cast<int>(size)) + " mm");
    const TriangleMesh mesh = torus(quads, size);
    const Surface surface = surface_of(mesh);
    const std::vector<Eigen::Array4f> light = sunlight(surface);
    Hierarchy hierarchy(context, mesh, profiles);
    std::vector<Eigen::Array4f> exitance;
    const Times fly = timed(repetitions, [&] {
      hierarchy.renew(mesh, profiles);
      exitance = hierarchy.exitance(light);
    });
    std::vector<double> whole;
    for (const Eigen::Array4f& value : exitance) whole.push_back(static_cast<double>(value[0]));

    const ProfileTable table = tabulate(profiles, 1.01 * bounding_box(mesh).diagonal().norm());
    const ClusterTree tree(mesh);
    const Links links =
        link(tree, {HierarchyOptions{}.opening, table.smooth, table.decay, table.least_decay});
    const auto corners = [&](std::size_t t) {
      std::array<Eigen::Vector3d, 3> corner;
      for (std::size_t k = 0; k < 3; ++k)
        corner[k] = mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][k])];
      return corner;
    };
    // A point for each disc of a mean free path (Jensen, Buhler 2002); one wherever that is enough.
    const auto points_of = [&](std::size_t t) {
      return static_cast<std::uint32_t>(std::max(1.0, std::ceil(surface.area[t] / disc)));
    };
    std::size_t evaluations = 0;
    const auto by_points = [&](std::size_t receiver, std::size_t emitter) {
      const std::array<Eigen::Vector3d, 3> corner = corners(emitter);
      const std::uint32_t count = points_of(emitter);
      double sum = 0.0;
      for (std::uint32_t i = 0; i < count; ++i) {
        Eigen::Vector3d point = surface.position[emitter];
        if (count > 1) {
          const auto [u, v] = sobol_point(i, emitter);
          const double root = std::sqrt(u);
          point = (1.0 - root) * corner[0] + root * (1.0 - v) * corner[1] + root * v * corner[2];
        }
        sum += profile.value((point - surface.position[receiver]).norm());
      }
      return sum * surface.area[emitter] / count;
    };
    const auto exactly = [&](std::size_t receiver, std::size_t emitter) {
      return form_factor(profile, corners(emitter), surface.position[receiver]).value;
    };
    const auto by_form_factors = [&](std::size_t receiver, std::size_t emitter) {
      return points_of(emitter) > 1 ? exactly(receiver, emitter) : by_points(receiver, emitter);
    };
    std::vector<double> of_form_factors, of_points;
    const Times form_factors = timed(
        repetitions, [&] { of_form_factors = near_light(tree, links, light, by_form_factors); });
    const Times points =
        timed(repetitions, [&] { of_points = near_light(tree, links, light, by_points); });
    const std::vector<double> exact = near_light(tree, links, light, exactly);
    const double norm = area_norm(surface, whole);
    evaluations = 0;
    std::size_t pairs = 0;
    near_light(tree, links, light, [&](std::size_t, std::size_t emitter) {
      ++pairs;
      evaluations += points_of(emitter);
      return 0.0;
    });
    rows.push_back(
        {{"size_mm", size},
         {"triangles", mesh.triangles.size()},
         {"near pairs a triangle",
          static_cast<double>(pairs) / static_cast<double>(mesh.triangles.size())},
         {"points a pair", static_cast<double>(evaluations) / static_cast<double>(pairs)},
         {"hierarchy on the fly, ms", fly.cpu_ms},
         {"form factors, ms", form_factors.cpu_ms},
         {"points, ms", points.cpu_ms},
         {"error of form factors", area_norm(surface, difference(of_form_factors, exact)) / norm},
         {"error of points", area_norm(surface, difference(of_points, exact)) / norm}});
    save({{"repetitions", repetitions}, {"rows", rows}});
  }
}

}  // namespace kappamu::studies

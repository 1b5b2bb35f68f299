#include "studies/figures/cluster_tile.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/error.h"
#include "core/random.h"
#include "forward/dipole/hierarchy/hierarchy.h"
#include "render/look_at.h"
#include "render/scene/world.h"

namespace kappamu::studies {

namespace {

using namespace forward::dipole;

constexpr int near_level = -1, receiving = -2;

struct ClusterOf {
  int level = near_level;
  std::size_t cluster = 0;
};

/// Per triangle of the mesh, the cluster through which it reaches `receiver`.
std::vector<ClusterOf> clusters_to(const ClusterTree& tree, const Links& links,
                                   std::size_t receiver) {
  const auto& order = tree.order();
  const auto position = static_cast<std::size_t>(
      std::find(order.begin(), order.end(), static_cast<int>(receiver)) - order.begin());
  std::vector<ClusterOf> of(order.size());
  std::size_t k = 0;
  for (int level = 0; level <= tree.depth(); ++level) {
    const std::size_t first = (std::size_t{1} << level) - 1;
    const LinkRange range = links.of_cluster[k];
    for (int j = range.first; j < range.first + range.count; ++j) {
      const auto emitter = static_cast<std::size_t>(links.emitter[static_cast<std::size_t>(j)]);
      const int on = static_cast<int>(std::bit_width(emitter + 1)) - 1;
      const std::size_t i = emitter + 1 - (std::size_t{1} << on);
      for (std::size_t p = tree.begin(on, i); p < tree.begin(on, i + 1); ++p) {
        of[static_cast<std::size_t>(order[p])] = {on, emitter};
      }
    }
    const std::size_t next = 2 * (k - first);
    if (level < tree.depth())
      k = 2 * first + 1 + (position < tree.begin(level + 1, next + 1) ? next : next + 1);
  }
  of[receiver].level = receiving;
  return of;
}

std::array<double, 3> colour_of(const ClusterOf& of) {
  if (of.level == receiving) return {0.0, 0.0, 0.0};
  if (of.level == near_level) return {1.0, 1.0, 1.0};
  constexpr std::array<std::array<double, 3>, 7> levels{{{0.90, 0.62, 0.00},
                                                         {0.34, 0.71, 0.91},
                                                         {0.00, 0.62, 0.45},
                                                         {0.94, 0.89, 0.26},
                                                         {0.00, 0.45, 0.70},
                                                         {0.84, 0.37, 0.00},
                                                         {0.80, 0.47, 0.65}}};
  std::array<double, 3> colour = levels[static_cast<std::size_t>(of.level) % levels.size()];
  const double shade = 0.6 + 0.4 * uniform(key_of({of.cluster}));
  for (double& c : colour) c *= shade;
  return colour;
}

}  // namespace

Image<std::uint8_t> cluster_tile(const render::Scene& scene, const Eigen::Vector2d& at) {
  std::vector<std::string> warnings;
  const render::World world(scene, warnings);
  const render::WorldObject& object = world.objects().front();
  const ObjectMedium& medium = *object.media.channels[1];
  if (!medium.homogeneous()) {
    throw InputError(scene.file.string() +
                     ": clusters are those of a dipole, whose medium is the "
                     "same everywhere; give the first object one material");
  }
  const render::Film& film = scene.film;
  const render::Camera& camera = scene.camera;
  const render::LookAt look(camera.position_mm, camera.target_mm, camera.up, camera.fov_deg,
                            static_cast<double>(film.width) / film.height);
  const auto hit_at = [&](double x, double y) {
    const auto hit = world.first_hit(look.position(), look.direction(x, y), 0.0);
    return hit && hit->object == 0 ? hit : std::nullopt;
  };
  const auto receiver = hit_at(at.x(), at.y());
  if (!receiver) {
    throw InputError(scene.file.string() +
                     ": the first object is not seen at triangle_at; move it");
  }
  const std::vector<Profile> profiles{
      make_profile("dipole", {medium.smallest().kappa, medium.smallest().mu}, object.boundary.eta)};
  const ProfileTable table = tabulate(profiles, 1.01 * bounding_box(object.mesh).diagonal().norm());
  const ClusterTree tree(object.mesh);
  const Oracle oracle{HierarchyOptions{}.opening, table.smooth, table.decay, table.least_decay};
  const std::vector<ClusterOf> of = clusters_to(tree, link(tree, oracle), receiver->triangle);
  Image<std::uint8_t> tile(film.width, film.height, 3);
  constexpr int across = 3;  // rays of a pixel
  for (int y = 0; y < film.height; ++y) {
    for (int x = 0; x < film.width; ++x) {
      std::array<double, 3> sum{};
      for (int ray = 0; ray < across * across; ++ray) {
        const auto hit = hit_at((x + (ray % across + 0.5) / across) / film.width,
                                (y + (ray / across + 0.5) / across) / film.height);
        if (!hit) continue;
        const std::array<double, 3> colour = colour_of(of[hit->triangle]);
        const double facing = (look.position() - hit->position).normalized().dot(hit->normal);
        for (std::size_t c = 0; c < 3; ++c) sum[c] += colour[c] * (0.45 + 0.55 * std::abs(facing));
      }
      for (int c = 0; c < 3; ++c) {
        tile(x, y, c) = static_cast<std::uint8_t>(
            std::lround(255.0 * sum[static_cast<std::size_t>(c)] / (across * across)));
      }
    }
  }
  return tile;
}

}  // namespace kappamu::studies

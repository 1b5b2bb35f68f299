// Section `lists`: how long the hierarchy's lists are. On a processor one work-item walks a list;
// on a GPU the items of a group share it (forward/dipole/hierarchy/together.cl), and its longest
// list is what a level waits for.
#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/mesh/shapes.h"
#include "forward/dipole/hierarchy/hierarchy.h"
#include "io/mesh_file.h"
#include "studies/dipole/dipole_bench.h"

namespace kappamu::studies {

namespace {

using namespace forward::dipole;

/// Steps of lists that follow each other within a level; levels follow each other too.
struct Lengths {
  std::size_t lists = 0, all = 0, longest = 0;
  std::size_t of_level = 0, chain = 0;  ///< the longest so far, and of all levels before added up
  std::vector<std::size_t> histogram;   ///< lists of [2^(i−1), 2^i) steps, from 0 steps on

  void add(std::size_t length) {
    std::size_t bin = 0;
    while (length >> bin != 0) ++bin;
    if (bin >= histogram.size()) histogram.resize(bin + 1);
    ++histogram[bin];
    ++lists;
    all += length;
    longest = std::max(longest, length);
    of_level = std::max(of_level, length);
  }
  void end_level() {
    chain += of_level;
    of_level = 0;
  }
};

/// Of one work-item, and of a group.
struct Steps {
  const char* what;
  Lengths alone, together;
};

constexpr std::size_t sharing = items_together;

std::size_t shared_steps(std::size_t length) {
  return (length + sharing - 1) / sharing;
}

/// What one receiver does with the clusters that its parent has left: clusters met, rounds in which
/// a group meets them, links, and what it leaves.
struct Met {
  std::size_t tests = 0, rounds = 0, links = 0;
  std::vector<std::size_t> left;
};

Met meet_left(const ClusterTree& tree, const Oracle& oracle, std::size_t receiver,
              const std::vector<std::size_t>& candidates) {
  Met met;
  std::vector<std::size_t> waiting, now;
  for (std::size_t next = 0; next < candidates.size() || !waiting.empty(); ++met.rounds) {
    now.clear();
    while (now.size() < sharing && !waiting.empty()) {
      now.push_back(waiting.back());
      waiting.pop_back();
    }
    while (now.size() < sharing && next < candidates.size()) now.push_back(candidates[next++]);
    met.tests += now.size();
    for (const std::size_t e : now) {
      switch (oracle.meet(tree, receiver, e)) {
        case Oracle::Meeting::linked:
          ++met.links;
          break;
        case Oracle::Meeting::emitter_opens:
          waiting.insert(waiting.end(), {2 * e + 1, 2 * e + 2});
          break;
        case Oracle::Meeting::receiver_opens:
          met.left.push_back(e);
      }
    }
  }
  return met;
}

std::array<Steps, 3> count_steps(const ClusterTree& tree, const Oracle& oracle) {
  std::array<Steps, 3> steps{
      {{"clusters met", {}, {}}, {"links summed", {}, {}}, {"near leaves, by triangles", {}, {}}}};
  auto& [tests, links, near] = steps;
  std::vector<std::vector<std::size_t>> left{{0}};
  for (int level = 0; level <= tree.depth(); ++level) {
    std::vector<std::vector<std::size_t>> next(std::size_t{1} << level);
    for (std::size_t i = 0; i < next.size(); ++i) {
      Met met = meet_left(tree, oracle, next.size() - 1 + i, left[i / 2]);
      tests.alone.add(met.tests);
      tests.together.add(met.rounds);
      links.alone.add(met.links);
      links.together.add(shared_steps(met.links));
      if (level == tree.depth()) {
        const std::size_t own = tree.begin(level, i + 1) - tree.begin(level, i);
        near.alone.add(own * met.left.size());
        near.together.add(own * shared_steps(met.left.size()));
      }
      next[i] = std::move(met.left);
    }
    for (Steps& of : steps) {
      of.alone.end_level();
      of.together.end_level();
    }
    left.swap(next);
  }
  return steps;
}

std::string histogram_text(const std::vector<std::size_t>& histogram) {
  std::string all;
  for (const std::size_t n : histogram) all += (all.empty() ? "" : " ") + std::to_string(n);
  return all;
}

}  // namespace

void dipole_lists(const Request& request, Progress& progress, const Save& save) {
  struct Case {
    const char* name;
    TriangleMesh mesh;
  };
  std::vector<Case> cases;
  const bool quick = request.size == Size::quick;
  cases.push_back({"torus of 25 mm", torus(hierarchy_quads[quick ? 0 : 3], 25.0)});
  // Of two triangles a side, and far finer ones above it.
  cases.push_back(
      {"torus on a plate", joined(torus(quick ? hierarchy_quads[0] : Quads{100, 300}, 25.0),
                                  moved(box_mesh({30.0, 30.0, 16.0}, 1), {0.0, 0.0, -12.0}))});
  const std::filesystem::path file = "scenes/meshes/nefertiti.ply";
  if (!quick && std::filesystem::exists(file)) {
    cases.push_back({"nefertiti of 150 mm", fitted(io::read_body(file).mesh, 150.0)});
  }
  const std::vector<Profile> profiles = red_green_blue_marble(1.0);
  Json rows = Json::array();
  for (const Case& of : cases) {
    progress.update("bench dipole", 0.5, of.name);
    const ClusterTree tree(of.mesh);
    const ProfileTable table = tabulate(profiles, 1.01 * bounding_box(of.mesh).diagonal().norm());
    for (const Steps& steps : count_steps(
             tree, {HierarchyOptions{}.opening, table.smooth, table.decay, table.least_decay})) {
      rows.push_back({{"mesh", of.name},
                      {"triangles", of.mesh.triangles.size()},
                      {"steps", steps.what},
                      {"lists", steps.alone.lists},
                      {"all", steps.alone.all},
                      {"longest", steps.alone.longest},
                      {"longest of levels", steps.alone.chain},
                      {"shared, all", steps.together.all},
                      {"shared, longest", steps.together.longest},
                      {"shared, longest of levels", steps.together.chain},
                      {"lists of 0, 1, 2-3, 4-7, ...", histogram_text(steps.alone.histogram)}});
    }
    save({{"items_together", sharing}, {"rows", rows}});
  }
}

}  // namespace kappamu::studies

// What an OpenCL device makes of a mesh, clusters and links, against the references on the host.
// Both ways in which work is divided, a processor's and a GPU's, run on any device.
#include <gtest/gtest.h>

#include <string_view>
#include <tuple>

#include "tests/forward/dipole/marble_hierarchy.h"

namespace kappamu::forward::dipole {
namespace {

constexpr device::Kind forms[]{device::Kind::cpu, device::Kind::gpu};

/// Emitters of a cluster, or the leaves near one.
std::vector<int> of_range(const LinkRange& range, const std::vector<int>& emitters) {
  const auto first = emitters.begin() + range.first;
  return {first, first + range.count};
}

/// 25 mm long, or a torus of that size above the two triangles of a plate's side, which meet all of
/// its triangles: more clusters wait than the stack of a GPU's group may hold at full speed.
TriangleMesh shape(std::string_view name, int tessellation) {
  if (name != "torus on a plate") return make_shape(name, 25.0, tessellation);
  return joined(make_shape("torus", 25.0, tessellation),
                moved(box_mesh({30.0, 30.0, 10.0}, 1), {0.0, 0.0, -10.0}));
}

// The narrow openings make lists longer than the device's queue, and pools that have to grow.
TEST(DeviceLinks, AreThoseOfTheReference) {
  for (const auto& [name, tessellation, opening] :
       {std::tuple{"torus", 40, 0.68F}, std::tuple{"slab", 16, 0.68F},
        std::tuple{"spike", 30, 0.2F}, std::tuple{"cube", 12, 0.02F},
        std::tuple{"sphere", 2, 0.68F}, std::tuple{"torus on a plate", 70, 0.68F}}) {
    const TriangleMesh mesh = shape(name, tessellation);
    ClusterTree tree(mesh);
    for (const device::Kind form : forms) {
      Hierarchy hierarchy(context(), mesh, marble(), {.opening = opening, .form = form});
      tree.set_clusters(hierarchy.clusters());
      const Links reference = link(tree, hierarchy.oracle(opening)), made = hierarchy.links_made();
      EXPECT_EQ(hierarchy.links(), reference.emitter.size()) << name;
      EXPECT_EQ(hierarchy.near_pairs(), reference.near.size()) << name;
      for (std::size_t k = 0; k < tree.clusters(); ++k) {
        ASSERT_EQ(of_range(made.of_cluster[k], made.emitter),
                  of_range(reference.of_cluster[k], reference.emitter))
            << name << " " << k;
      }
      for (std::size_t leaf = 0; leaf < made.of_leaf.size(); ++leaf) {
        ASSERT_EQ(of_range(made.of_leaf[leaf], made.near),
                  of_range(reference.of_leaf[leaf], reference.near))
            << name << " " << leaf;
      }
    }
  }
}

// Of a mesh whose vertices have moved since.
TEST(DeviceClusters, AreThoseOfTheReference) {
  constexpr float rounding = 1e-5F;
  for (const auto& [name, tessellation] :
       {std::pair{"torus", 40}, std::pair{"slab", 16}, std::pair{"sphere", 2}}) {
    const TriangleMesh mesh = make_shape(name, 25.0, tessellation), moved = waved(mesh, 1.0, 5);
    ClusterTree tree(mesh);
    tree.refit(moved);
    for (const device::Kind form : forms) {
      Hierarchy hierarchy(context(), mesh, marble(), {.form = form});
      hierarchy.renew(moved, marble());
      const std::vector<Eigen::Array4f> clusters = hierarchy.clusters();
      for (std::size_t k = 0; k < tree.clusters(); ++k) {
        ASSERT_LT((clusters[k] - tree.cluster()[k]).abs().maxCoeff(), 25.0F * rounding)
            << name << " " << k;
      }
    }
  }
}

TEST(Hierarchy, InTheFormOfGpusGivesTheSameExitance) {
  constexpr float rounding = 1e-5F;  // sums of single precision in another order
  for (const auto& [name, tessellation] :
       {std::pair{"torus", 40}, std::pair{"cube", 8}, std::pair{"sphere", 2},
        std::pair{"torus on a plate", 30}}) {
    const TriangleMesh mesh = shape(name, tessellation);
    const auto light = sunlight(surface_of(mesh));
    const auto exitance = [&](device::Kind form) {
      return Hierarchy(context(), mesh, marble(), {.form = form}).exitance(light);
    };
    const auto one = exitance(device::Kind::cpu), other = exitance(device::Kind::gpu);
    float most = 0.0F, difference = 0.0F;
    for (std::size_t t = 0; t < one.size(); ++t) {
      most = std::max(most, one[t].maxCoeff());
      difference = std::max(difference, (one[t] - other[t]).abs().maxCoeff());
    }
    EXPECT_LT(difference, rounding * most) << name;
  }
}

// Items of a group share a list, and add up what they found in one order.
TEST(Hierarchy, InTheFormOfGpusGivesTheSameBitsAgain) {
  const TriangleMesh mesh = shape("torus on a plate", 30);
  const auto light = sunlight(surface_of(mesh));
  Hierarchy hierarchy(context(), mesh, marble(), {.form = device::Kind::gpu});
  const auto first = hierarchy.exitance(light);
  for (int again = 0; again < 2; ++again) {
    hierarchy.renew(mesh, marble());
    const auto next = hierarchy.exitance(light);
    for (std::size_t t = 0; t < first.size(); ++t) ASSERT_TRUE((first[t] == next[t]).all()) << t;
  }
}

// Pairs of triangles are then summed one by one: the error is that of the table of the profile.
TEST(Hierarchy, AVeryNarrowOpeningIsTheDirectSum) {
  constexpr double of_the_table = 2e-3;
  const TriangleMesh mesh = make_shape("cube", 12.0, 12);
  for (const device::Kind form : forms) {
    Hierarchy hierarchy(context(), mesh, marble(), {.opening = 0.68F, .form = form});
    hierarchy.set_opening(1e-3F);
    EXPECT_EQ(hierarchy.links(), 0U);
    EXPECT_LT(error_of(hierarchy.exitance(sunlight(surface_of(mesh))), mesh, marble(), 97),
              of_the_table);
  }
}

}  // namespace
}  // namespace kappamu::forward::dipole

// Splitting long triangles changes nothing but their number.
#include "core/mesh/mesh_refine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "core/error.h"
#include "core/mesh/shapes.h"

namespace kappamu {
namespace {

double longest_edge(const TriangleMesh& mesh) {
  double longest = 0.0;
  for (const auto& corners : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto a = static_cast<std::size_t>(corners[i]);
      const auto b = static_cast<std::size_t>(corners[(i + 1) % 3]);
      longest = std::max(longest, (mesh.vertices[a] - mesh.vertices[b]).norm());
    }
  }
  return longest;
}

/// Every edge once in each direction.
bool closed(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> uses;
  for (const auto& corners : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++uses[{corners[i], corners[(i + 1) % 3]}];
  }
  return std::all_of(uses.begin(), uses.end(), [&](const auto& edge) {
    return edge.second == 1 && uses.count({edge.first.second, edge.first.first}) == 1;
  });
}

double area(const TriangleMesh& mesh) {
  const Surface surface = surface_of(mesh);
  return std::accumulate(surface.area.begin(), surface.area.end(), 0.0);
}

TEST(MeshRefine, KeepsTheSurfaceAndItsClosure) {
  // Long and short edges beside each other.
  for (const TriangleMesh& mesh :
       {box_mesh({20.0, 3.0, 0.5}, 4), sphere_mesh(5.0, 6), cone_mesh(1.0, 10.0, 8)}) {
    for (const double longest : {3.0, 0.7}) {
      const TriangleMesh fine = refined(mesh, longest, 1'000'000);
      constexpr double rounding = 1e-12;
      EXPECT_LE(longest_edge(fine), longest);
      EXPECT_TRUE(closed(fine));
      EXPECT_NEAR(area(fine) / area(mesh), 1.0, rounding);
      EXPECT_NEAR(enclosed_volume(fine) / enclosed_volume(mesh), 1.0, rounding);
    }
  }
}

TEST(MeshRefine, LeavesShortTrianglesAlone) {
  const TriangleMesh mesh = sphere_mesh(5.0, 6);
  const TriangleMesh same = refined(mesh, longest_edge(mesh), mesh.triangles.size());
  EXPECT_EQ(same.triangles, mesh.triangles);
}

TEST(MeshRefine, RefusesMoreTrianglesThanAllowed) {
  const TriangleMesh mesh = box_mesh({20.0, 20.0, 20.0}, 2);
  EXPECT_THROW(refined(mesh, 0.1, 1'000), InputError);
  EXPECT_GT(refined(mesh, 5.0, 10'000).triangles.size(), mesh.triangles.size());
}

}  // namespace
}  // namespace kappamu

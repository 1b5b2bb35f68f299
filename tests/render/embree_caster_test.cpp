#include "render/embree_caster.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "core/parallel.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;

/// A sphere of `rings` rings with twice as many triangles each way round, vertices shared.
TriangleMesh ball(double radius, int rings, const Vector3d& centre) {
  TriangleMesh mesh;
  const int around = 2 * rings;
  mesh.vertices.push_back(centre - radius * Vector3d::UnitZ());
  for (int i = 1; i < rings; ++i) {
    for (int j = 0; j < around; ++j) {
      const double polar = pi * i / rings, turn = 2.0 * pi * j / around;
      mesh.vertices.push_back(centre + radius * Vector3d(std::sin(polar) * std::cos(turn),
                                                         std::sin(polar) * std::sin(turn),
                                                         -std::cos(polar)));
    }
  }
  mesh.vertices.push_back(centre + radius * Vector3d::UnitZ());
  const int last = static_cast<int>(mesh.vertices.size()) - 1;
  for (int j = 0; j < around; ++j) {
    const int k = (j + 1) % around;
    mesh.triangles.push_back({0, 1 + k, 1 + j});
    for (int i = 0; i + 2 < rings; ++i) {
      const int low = 1 + i * around, high = low + around;
      mesh.triangles.push_back({low + j, low + k, high + k});
      mesh.triangles.push_back({low + j, high + k, high + j});
    }
    mesh.triangles.push_back({last, last - around + j, last - around + k});
  }
  return mesh;
}

TriangleMesh plates(double gap) {
  TriangleMesh mesh;
  for (const double z : {0.0, gap}) {
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  }
  return mesh;
}

const Vector3d& corner(const TriangleMesh& mesh, int triangle, int k) {
  const auto& corners = mesh.triangles[static_cast<std::size_t>(triangle)];
  return mesh.vertices[static_cast<std::size_t>(corners[static_cast<std::size_t>(k)])];
}

Vector3d point_of(const TriangleMesh& mesh, const RayHit& hit) {
  return (1.0 - hit.u - hit.v) * corner(mesh, hit.triangle, 0) +
         hit.u * corner(mesh, hit.triangle, 1) + hit.v * corner(mesh, hit.triangle, 2);
}

class Directions {
 public:
  Vector3d operator()() { return Vector3d(normal_(random_), normal_(random_), normal_(random_)); }

 private:
  std::mt19937_64 random_{1};
  std::normal_distribution<double> normal_;
};

// By every triangle in double precision: the distances of all crossings of a ray that meets no
// edge.
std::vector<double> crossings(const TriangleMesh& mesh, const Vector3d& origin,
                              const Vector3d& direction) {
  std::vector<double> found;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    const Vector3d& a = corner(mesh, t, 0);
    Eigen::Matrix3d edges;
    edges << -direction, corner(mesh, t, 1) - a, corner(mesh, t, 2) - a;
    const Vector3d solved = edges.partialPivLu().solve(origin - a);
    if (solved.y() >= 0.0 && solved.z() >= 0.0 && solved.y() + solved.z() <= 1.0 &&
        solved.x() > 0.0) {
      found.push_back(solved.x());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

// An object of 3 mm, 10 m from the origin of its frame and seen from 100 m: no digit is lost but
// those that its coordinates lack (10^4 mm in double precision, 1e-12).
TEST(EmbreeCaster, DistancesAreOfDoublePrecision) {
  const Vector3d centre(1e4, -1e4, 1e4);
  const TriangleMesh mesh = ball(1.5, 12, centre);
  const auto caster = make_embree_caster(mesh);
  Directions draw;
  int met = 0;
  for (const double from : {0.0, 1.0, 10.0, 1e5}) {
    for (int i = 0; i < 200; ++i) {
      const Vector3d origin = centre + from * draw().normalized();
      const Vector3d direction = (centre + 0.7 * draw() - origin) / 3.0;
      const std::vector<double> expected = crossings(mesh, origin, direction);
      const auto hit = caster->first_hit(origin, direction);
      ASSERT_EQ(hit.has_value(), !expected.empty());
      if (!hit) continue;
      ++met;
      const double bound = 1e-15 * (1e4 + from) * 100.0 / direction.norm();
      EXPECT_NEAR(hit->distance, expected.front(), bound);
      EXPECT_LE((point_of(mesh, *hit) - origin - hit->distance * direction).norm(),
                1e-15 * (1e4 + from) * 1000.0);
    }
  }
  EXPECT_GT(met, 400);
}

TEST(EmbreeCaster, AnyHitIsThereWhereAFirstIs) {
  const TriangleMesh mesh = ball(1.0, 9, {0.3, 0.2, 0.1});
  const auto caster = make_embree_caster(mesh);
  Directions draw;
  int met = 0;
  constexpr int rays = 2000;
  for (int i = 0; i < rays; ++i) {
    const Vector3d origin = 1.5 * draw(), direction = draw();
    const double nearest = std::abs(0.3 * draw().x()), farthest = nearest + std::abs(draw().y());
    const bool first = caster->first_hit(origin, direction, nearest, farthest).has_value();
    ASSERT_EQ(caster->any_hit(origin, direction, nearest, farthest), first);
    met += first ? 1 : 0;
  }
  EXPECT_GT(met, rays / 20);
  EXPECT_LT(met, rays / 2);
}

TEST(EmbreeCaster, NoRayLeaksThroughEdgesAndVertices) {
  const TriangleMesh mesh = ball(1.0, 9, {0.3, 0.2, 0.1});
  const auto caster = make_embree_caster(mesh);
  const Vector3d inside(0.41, 0.02, 0.17);
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d& from = mesh.vertices[static_cast<std::size_t>(triangle[k])];
      const Vector3d& to = mesh.vertices[static_cast<std::size_t>(triangle[(k + 1) % 3])];
      for (const double part : {0.0, 0.1, 0.5, 0.9}) {
        const Vector3d aim = from + part * (to - from) - inside;
        const auto hit = caster->first_hit(inside, aim);
        ASSERT_TRUE(hit);
        EXPECT_NEAR(hit->distance, 1.0, 1e-6);
        EXPECT_GE(hit->u, 0.0);
        EXPECT_GE(hit->v, 0.0);
        EXPECT_LE(hit->u + hit->v, 1.0 + 1e-15);
      }
    }
  }
}

// From wall to wall inside a sphere, a quarter of the time at grazing angles. The few rays that
// slip past an edge beside them are caught as the header advises.
TEST(EmbreeCaster, APathFromWallToWallStaysInside) {
  const TriangleMesh mesh = ball(1.0, 24, Vector3d::Zero());
  const Surface surface = surface_of(mesh);
  const auto caster = make_embree_caster(mesh);
  Directions draw;
  Vector3d position = surface.position.front();
  int last = 0, slipped = 0;
  constexpr int bounces = 50000;
  for (int bounce = 0; bounce < bounces; ++bounce) {
    const auto& normal = surface.normal[static_cast<std::size_t>(last)];
    Vector3d direction = draw().normalized();
    if (bounce % 4 == 0) direction -= 0.99 * direction.dot(normal) * normal;
    if (direction.dot(normal) > 0.0) direction -= 2.0 * direction.dot(normal) * normal;
    const auto wall = [&] {
      auto hit = caster->first_hit(position, direction);
      if (hit && hit->triangle == last) {
        hit = caster->first_hit(position, direction, hit->distance);
      }
      const bool outwards =
          hit && surface.normal[static_cast<std::size_t>(hit->triangle)].dot(direction) > 0.0;
      return outwards ? hit : std::nullopt;
    };
    auto hit = wall();
    for (int step = 0; !hit && step < 3; ++step) {
      ++slipped;
      position -= 1e-6 * normal;
      hit = wall();
    }
    ASSERT_TRUE(hit);
    position += hit->distance * direction;
    last = hit->triangle;
  }
  EXPECT_LT(slipped, bounces / 5000);
}

TEST(EmbreeCaster, NearestLeavesOutWhatLiesBefore) {
  const double gap = 1e-4;
  const auto caster = make_embree_caster(plates(gap));
  const Vector3d origin(0.3, 0.4, -2.0);
  const auto first = caster->first_hit(origin, Vector3d::UnitZ());
  ASSERT_TRUE(first);
  EXPECT_NEAR(first->distance, 2.0, 1e-14);
  const auto second = caster->first_hit(origin, Vector3d::UnitZ(), first->distance);
  ASSERT_TRUE(second);
  EXPECT_NEAR(second->distance - first->distance, gap, 1e-14);
  EXPECT_FALSE(caster->first_hit(origin, Vector3d::UnitZ(), second->distance));
  EXPECT_FALSE(caster->first_hit(origin, Vector3d::UnitZ(), 0.0, 2.0));
  EXPECT_TRUE(caster->first_hit(origin, Vector3d::UnitZ(), 0.0, 2.0 + 1e-12));
}

// In units of the direction, and at scales where single precision would overflow or vanish.
TEST(EmbreeCaster, AllHitsAreThoseOfOneRayAfterTheOther) {
  // Shells within each other; rays through the insides of triangles.
  TriangleMesh shells;
  for (int i = 0; i < 6; ++i) {
    const TriangleMesh one = ball(10.0 + 0.05 * i, 20, Vector3d(1, 2, 3));
    const int first = static_cast<int>(shells.vertices.size());
    shells.vertices.insert(shells.vertices.end(), one.vertices.begin(), one.vertices.end());
    for (const auto& t : one.triangles) {
      shells.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
  }
  const auto caster = make_embree_caster(shells);
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<RayHit> all;
  for (int i = 0; i < 500; ++i) {
    const Vector3d from(30.0 * normal(random), 30.0 * normal(random), 40.0);
    const Vector3d towards = Vector3d(1, 2, 3) + 6.0 * Vector3d(normal(random), normal(random), 0);
    const Vector3d direction = towards - from;
    const double farthest = i % 3 == 0 ? 1.0 : 10.0;
    caster->all_hits(from, direction, 0.0, farthest, all);
    std::size_t met = 0;
    double nearest = 0.0;
    while (const auto hit = caster->first_hit(from, direction, nearest, farthest)) {
      ASSERT_LT(met, all.size());
      EXPECT_EQ(all[met].triangle, hit->triangle);
      EXPECT_EQ(all[met].distance, hit->distance);
      nearest = hit->distance;
      ++met;
    }
    EXPECT_EQ(all.size(), met);
  }
}

TEST(EmbreeCaster, IsIndependentOfUnits) {
  for (const double unit : {1e-30, 1.0, 1e30}) {
    TriangleMesh mesh = plates(1.0);
    for (Vector3d& vertex : mesh.vertices) vertex *= unit;
    const auto caster = make_embree_caster(mesh);
    const auto hit =
        caster->first_hit({0.3 * unit, 0.4 * unit, 0.5 * unit}, {0.0, 0.0, 2.0 * unit});
    ASSERT_TRUE(hit) << unit;
    EXPECT_NEAR(hit->distance, 0.25, 1e-15);
  }
}

TEST(EmbreeCaster, ADirectionThatIsNoneMeetsNothing) {
  const auto caster = make_embree_caster(plates(1.0));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Vector3d origin(0.3, 0.4, 0.5);
  EXPECT_FALSE(caster->first_hit(origin, Vector3d::Zero()));
  EXPECT_FALSE(caster->first_hit(origin, {nan, 0.0, 1.0}));
  EXPECT_FALSE(caster->first_hit({nan, 0.0, 0.0}, Vector3d::UnitZ()));
  EXPECT_FALSE(
      caster->first_hit({0.3, 0.4, -std::numeric_limits<double>::infinity()}, Vector3d::UnitZ()));
}

TEST(EmbreeCaster, ThreadsAgree) {
  const TriangleMesh mesh = ball(1.0, 24, Vector3d::Zero());
  const auto caster = make_embree_caster(mesh);
  const auto distances = [&](unsigned threads) {
    std::vector<double> found(2000);
    for_rows(
        static_cast<int>(found.size()),
        [&](int i) {
          const Vector3d direction(std::cos(0.1 * i), std::sin(0.1 * i), std::sin(0.37 * i));
          found[static_cast<std::size_t>(i)] =
              caster->first_hit({0.1, 0.2, 0.3}, direction).value().distance;
        },
        threads);
    return found;
  };
  EXPECT_EQ(distances(1), distances(4));
}

// However far and often a mesh moves, rays meet it where they meet a caster made of it.
TEST(MovableCaster, MeetsWhatANewCasterMeets) {
  TriangleMesh mesh = ball(1.0, 20, Vector3d::Zero());
  const auto moved = make_embree_caster(mesh);
  Directions draw;
  for (const double stretch : {1.1, 3.0, 0.2}) {
    for (Vector3d& vertex : mesh.vertices) {
      vertex = Vector3d(stretch * vertex.x() + 2.0, vertex.y() + 0.3 * std::sin(3.0 * vertex.z()),
                        vertex.z());
    }
    moved->move(mesh.vertices);
    const auto fresh = make_embree_caster(mesh);
    const Eigen::AlignedBox3d box = bounding_box(mesh);
    int met = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vector3d origin = box.center() + 2.0 * box.sizes().cwiseProduct(draw());
      const Vector3d direction = box.center() + 0.3 * box.sizes().cwiseProduct(draw()) - origin;
      const auto one = moved->first_hit(origin, direction);
      const auto other = fresh->first_hit(origin, direction);
      ASSERT_EQ(one.has_value(), other.has_value());
      if (!one) continue;
      ++met;
      EXPECT_NEAR(one->distance, other->distance, 1e-9);
    }
    EXPECT_GT(met, 200);
  }
}

}  // namespace
}  // namespace kappamu::render

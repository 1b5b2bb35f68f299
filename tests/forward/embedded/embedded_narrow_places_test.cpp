// Which divisor of the stated error applies where, and which parts count as thin. Whether what
// comes of it covers the true error: embedded_population_test, `kappamu-studies objects --section
// estimate`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <set>

#include "embedded_test_tools.h"
#include "forward/embedded/narrow_places.h"
#include "forward/surface_rays.h"

namespace kappamu::forward::embedded {
namespace {

struct Distances {
  double gap, thickness;  ///< [mm]
};

/// A mesh turned by an angle, on even cubes; planes z = constant are named before the turn.
class Placed {
 public:
  Placed(const TriangleMesh& upright, double angle)
      : turn_(Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, 3).normalized())),
        mesh_(transformed(upright, turn_)) {}

  /// Cuts the mesh by cubes of level `level`; their edge [mm].
  double cut(int level) {
    tree_.emplace(mesh_);
    tree_->refine_surface(level);
    cubes_ = cut_mesh(*tree_, mesh_, *rays_);
    return std::ldexp(cubes_.edge_mm, -level);
  }
  /// Divisors on the plane z.
  std::set<double> divisors(double z) const {
    const std::vector<double> errors = NarrowPlaces(problem_).errors_per_difference(cubes_);
    std::set<double> found;
    for (std::size_t t = 0; t < errors.size(); ++t) {
      if (on(t, z)) found.insert(1.0 / errors[t]);
    }
    return found;
  }
  std::vector<Distances> distances(double z) const {
    const SurfaceRays rays(problem_);
    std::vector<Distances> found;
    for (std::size_t t = 0; t < surface_.size(); ++t) {
      if (on(t, z)) found.push_back({rays.gap(t), rays.thickness(t)});
    }
    return found;
  }
  /// Of an upright mesh: where the plane lies between the sides of cubes twice as large, 0 to 1.
  double place_in_parent(double z, double h) const {
    const double cubes = tree_->to_root({0.0, 0.0, z}).z() * tree_->edge_mm() / (2.0 * h);
    return cubes - std::floor(cubes);
  }
  double bridged_area() const { return NarrowPlaces(problem_).bridged_area(cubes_); }
  std::size_t bridging_cubes() const {
    return NarrowPlaces(problem_).bridging_cubes(cubes_).size();
  }
  std::vector<int> thin_leaves() const { return NarrowPlaces(problem_).thin_leaves(cubes_); }
  std::size_t surface_cubes() const { return cubes_.surface.size(); }

 private:
  bool on(std::size_t t, double z) const {
    return std::abs((turn_.inverse() * surface_.position[t]).z() - z) < 1e-9;
  }

  Eigen::Affine3d turn_;
  const TriangleMesh mesh_;
  const Surface surface_ = surface_of(mesh_);
  const std::unique_ptr<RayCaster> rays_ = make_caster(mesh_);
  const ObjectMedium medium_{Coefficients{0.3, 0.01}};
  const std::vector<ObjectLight> lights_;
  const ObjectProblem problem_{mesh_, surface_, *rays_, medium_, 1.3, lights_};
  std::optional<Octree> tree_;
  CutMesh cubes_;
};

constexpr double tilted = 0.7;
constexpr double far = 1e3;  // for what is not there

/// A block, a gap and a plate, one above the other [mm].
constexpr double block = 8.0, gap = 1.0, plate = 2.2;
TriangleMesh block_and_plate() {
  Eigen::Affine3d above = Eigen::Affine3d::Identity();
  above.translate(Eigen::Vector3d(0.0, 0.0, block + gap));
  return joined(box({16.0, 16.0, block}, 4), transformed(box({16.0, 16.0, plate}, 4), above));
}

TEST(EmbeddedNarrowPlaces, RaysMeasureGapsAndThickness) {
  for (const double angle : {0.0, tilted}) {
    const Placed placed(block_and_plate(), angle);
    const auto expect = [&](double z, double ahead, double behind) {
      const std::vector<Distances> found = placed.distances(z);
      EXPECT_EQ(found.size(), 32U) << z;
      for (const Distances& its : found) {
        EXPECT_NEAR(std::min(its.gap, far), ahead, 1e-9) << z;
        EXPECT_NEAR(its.thickness, behind, 1e-9) << z;
      }
    };
    expect(0.0, far, block);
    expect(block, gap, block);
    expect(block + gap, gap, plate);
    expect(block + gap + plate, far, plate);
  }
}

TEST(EmbeddedNarrowPlaces, GapsAndThicknessInCubesChooseTheDivisor) {
  Placed placed(block_and_plate(), tilted);
  std::set<double> all;
  for (const int level : {2, 3, 4, 5, 6}) {
    const double h = placed.cut(level);
    const auto thin = [&](double mm) {
      return mm < 2.0 * h ? difference_per_error_thin : difference_per_error;
    };
    const double bridged = gap < h         ? difference_per_error_bridged
                           : gap < 2.0 * h ? difference_per_error_half_bridged
                                           : difference_per_error;
    const auto expect = [&](double z, double divisor) {
      EXPECT_THAT(placed.divisors(z), testing::ElementsAre(divisor)) << z << ", cubes of " << h;
      all.insert(divisor);
    };
    expect(0.0, thin(block));
    expect(block, std::min(bridged, thin(block)));
    expect(block + gap, std::min(bridged, thin(plate)));
    expect(block + gap + plate, thin(plate));
  }
  EXPECT_THAT(all, testing::ElementsAre(difference_per_error_bridged, difference_per_error_thin,
                                        difference_per_error_half_bridged, difference_per_error));
}

/// Down to difference_per_error_halved where a face halves the cubes of the coarser mesh.
TEST(EmbeddedNarrowPlaces, FacesAlongCubesAreTakenByWhereTheyCutThem) {
  Placed placed(box({16.0, 16.0, block}, 4), 0.0);
  double least = 3.0, most = 0.0;
  for (const int level : {4, 5, 6, 7, 8}) {
    const double h = placed.cut(level);
    for (const double z : {0.0, block}) {
      const double clear = std::min(1.0, std::abs(placed.place_in_parent(z, h) - 0.5) / 0.2);
      const std::set<double> found = placed.divisors(z);
      const double expected = 0.55 + clear * (1.25 - 0.55);
      for (const double divisor : found) EXPECT_NEAR(divisor, expected, 1e-4) << z << ' ' << h;
      least = std::min(least, *found.begin());
      most = std::max(most, *found.rbegin());
    }
  }
  EXPECT_LT(least, 1.0);
  EXPECT_NEAR(most, 1.25, 1e-9);
}

TEST(EmbeddedNarrowPlaces, SlitsThatCubesBridgeAreMeasuredAndSplitWhereThatHelps) {
  for (const double angle : {0.0, tilted}) {
    Placed placed(block_and_plate(), angle);
    for (const int level : {2, 3, 4, 5, 6}) {
      const double h = placed.cut(level);
      const bool bridged = gap < h;
      EXPECT_NEAR(placed.bridged_area(), bridged ? 2.0 * 16.0 * 16.0 : 0.0, 1e-9) << h;
      EXPECT_EQ(placed.bridging_cubes() > 0, bridged && gap >= 0.125 * h) << h;
    }
  }
}

TEST(EmbeddedNarrowPlaces, TheNarrowerTheSmallerIsTheDivisor) {
  const std::vector<double> divisors{
      difference_per_error_bridged,      difference_per_error_halved, difference_per_error_thin,
      difference_per_error_half_bridged, difference_per_error_along,  difference_per_error};
  EXPECT_TRUE(std::is_sorted(divisors.begin(), divisors.end()));
  EXPECT_LT(divisors.back(), 3.0) << "what an error that falls with h² would have";
}

TEST(EmbeddedNarrowPlaces, APlateIsThinWhereCubesAreLarger) {
  Placed placed(box({16.0, 16.0, plate}, 8), tilted);
  for (const int level : {2, 3, 4, 5}) {
    const double h = placed.cut(level);
    const std::size_t thin = placed.thin_leaves().size();
    if (h > plate) {
      EXPECT_GT(thin, placed.surface_cubes() / 2) << h;
    } else {
      // Rays from the rim end in faces nearby.
      EXPECT_EQ(thin, 0U) << h;
    }
  }
}

}  // namespace
}  // namespace kappamu::forward::embedded

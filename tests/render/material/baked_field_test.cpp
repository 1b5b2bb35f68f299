// A field made voxels: those that are not asked for their depth must not need it. What shells and
// mixtures are made of: their own tests.
#include "render/material/baked_field.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/mesh/shapes.h"
#include "render/material/surface_places.h"

namespace kappamu::render {
namespace {

/// Depth down to 2 mm, the place alone below.
class Rind : public MaterialField {
 public:
  ColourCoefficients at(const Place& place) const override {
    const double kappa =
        place.depth < 2.0 ? 0.1 + 0.05 * place.depth : 1.0 + 0.01 * place.point.x();
    ColourCoefficients result;
    result.fill({kappa, 0.01});
    return result;
  }
  double detail_mm() const override { return 0.4; }
  double deepest_mm() const override { return 2.0; }
};

TEST(BakedField, IsTheFieldInEveryVoxelOfTheBody) {
  const TriangleMesh mesh = make_shape("torus", 24.0, 24);
  std::vector<std::string> warnings;
  const Rind rind;
  const Baked made = baked(rind, mesh, warnings);
  const SurfacePlaces places(mesh);
  const GridShape& shape = made.set.shape();
  int deep = 0, within = 0;
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const Eigen::Vector3d point =
            made.corner_mm + shape.voxel_mm * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
        double outside = 0.0;
        const Place place = places.at(point, 0, outside);
        if (outside > 0.0) continue;
        ++within;
        deep += place.depth > 2.0 ? 1 : 0;
        ASSERT_NEAR(made.set.media[0].kappa(x, y, z), rind.at(place)[0].kappa, 1e-9)
            << point.transpose();
      }
    }
  }
  EXPECT_GT(deep, 100);
  EXPECT_GT(within, 3 * deep / 2);
}

}  // namespace
}  // namespace kappamu::render

// A field made voxels: those that are not asked for their depth must not need it. What shells and
// mixtures are made of: their own tests.
#include "render/material/baked_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "core/mesh/shapes.h"
#include "render/material/surface_places.h"
#include "render/scene/composed_field.h"

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
  bool of_point_alone(double shallow, double /*deep*/) const override { return shallow >= 2.0; }
};

/// How many voxels of the body lie deeper than 2 mm, and how many there are.
std::pair<int, int> expect_field_in_voxels(const MaterialField& field, const TriangleMesh& mesh) {
  std::vector<std::string> warnings;
  const Baked made = baked(field, mesh, warnings);
  const SurfacePlaces places(mesh);
  const GridShape& shape = made.set.shape();
  int deep = 0, within = 0, others = 0;
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
        const double kappa = made.set.media[0].kappa(x, y, z);
        others += std::abs(kappa - field.at(place)[0].kappa) > 1e-9 ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(others, 0);
  return {deep, within};
}

TEST(BakedField, IsTheFieldInEveryVoxelOfTheBody) {
  const auto [deep, within] = expect_field_in_voxels(Rind(), make_shape("torus", 24.0, 24));
  EXPECT_GT(deep, 100);
  EXPECT_GT(within, 3 * deep / 2);
}

/// Layers of a thin sheet, the innermost with veins.
TEST(BakedField, HasThinLayersAtTheirDepths) {
  const auto material = [](double kappa) {
    HomogeneousMaterial made;
    made.kappa_mm.setConstant(kappa);
    made.mu_per_mm.setConstant(0.01);
    return made;
  };
  auto veins = std::make_shared<ComposedMaterial>();
  veins->materials = {material(0.3), material(0.4)};
  veins->by = Pattern{.kind = Pattern::Kind::veins, .size_mm = 6.0};
  auto layers = std::make_shared<ComposedMaterial>();
  layers->materials = {material(0.1), material(0.2), veins};
  layers->by = ComposedMaterial::Layers{{0.3, 0.2}};
  const TriangleMesh mesh = make_shape("slab", 12.0, 24, 0.15);
  expect_field_in_voxels(*make_field(Material(layers), mesh).field, mesh);
}

}  // namespace
}  // namespace kappamu::render

// Index order, faces and validation of volumes and surface measurements.
#include "core/grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "core/surface_measurements.h"
#include "tests/sentence.h"

namespace kappamu {
namespace {

using ::testing::HasSubstr;

TEST(GridShape, VariesXFastest) {
  const GridShape grid{7, 5, 3, 0.5};
  EXPECT_EQ(grid.index(1, 0, 0), 1U);
  EXPECT_EQ(grid.index(0, 1, 0), 7U);
  EXPECT_EQ(grid.index(0, 0, 1), 35U);
  EXPECT_EQ(grid.cells(), 105U);
}

TEST(GridShape, RefinementKeepsTheBlock) {
  const GridShape fine = GridShape{7, 5, 3, 0.5}.refined(2);
  EXPECT_EQ(fine, (GridShape{14, 10, 6, 0.25}));
}

TEST(Face, NamesRoundTrip) {
  for (const Face face : all_faces) {
    EXPECT_EQ(face_from_string(to_string(face)), face);
    EXPECT_EQ(axis_of(opposite(face)), axis_of(face));
    EXPECT_NE(is_plus(opposite(face)), is_plus(face));
  }
  EXPECT_THAT(sentence_of([] { face_from_string("top"); }), HasSubstr("'top' is not one of"));
}

// Each face's cells are distinct, and depth walks straight into the block until the opposite face.
TEST(Face, CellsLieOnTheFace) {
  const GridShape grid{7, 5, 3, 1.0};
  for (const Face face : all_faces) {
    const FaceShape shape = face_shape(grid, face);
    const int last = grid.extent(axis_of(face)) - 1;
    std::set<std::size_t> cells;
    for (int v = 0; v < shape.nv; ++v) {
      for (int u = 0; u < shape.nu; ++u) {
        cells.insert(face_cell(grid, face, u, v));
        EXPECT_EQ(face_cell(grid, face, u, v, last), face_cell(grid, opposite(face), u, v));
      }
    }
    EXPECT_EQ(cells.size(), shape.cells());
  }
}

TEST(Medium, NamesTheFirstBadVoxel) {
  const GridShape grid{3, 2, 2, 1.0};
  Medium medium{Volume<double>(grid, 0.2), Volume<double>(grid, 0.0)};
  validate(medium, "k.npy");
  medium.kappa(2, 1, 1) = 0.0;
  EXPECT_EQ(
      sentence_of([&] { validate(medium, "k.npy"); }),
      "k.npy: kappa is 0 at voxel x=2 y=1 z=1; every kappa must be positive, from 1e-9 to 1e9 "
      "mm");
  medium.kappa(2, 1, 1) = 1e-45;
  EXPECT_THAT(sentence_of([&] { validate(medium, "k.npy"); }), HasSubstr("from 1e-9 to 1e9 mm"));
  medium.kappa(2, 1, 1) = 0.2;
  medium.mu(0, 0, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(sentence_of([&] { validate(medium, "m.npy"); }),
              HasSubstr("mu is nan at voxel x=0 y=0 z=1"));
  const GridShape tiny{3, 2, 2, 1e-30};
  const Medium of_tiny{Volume<double>(tiny, 0.2), Volume<double>(tiny, 0.0)};
  EXPECT_EQ(sentence_of([&] { validate(of_tiny, "k.npy"); }),
            "k.npy: the voxels' edge is 1e-30 mm; it must lie between 1e-06 and 1e+06");
}

SurfaceMeasurements small_measurements() {
  SurfaceMeasurements m;
  m.grid = {4, 3, 2, 1.0};
  m.channels = {"R", "G"};
  m.patterns = 2;
  m.irradiance.assign(2 * 12, 1.0F);
  m.value.assign(2 * 2 * 12, 0.1F);
  m.variance.assign(2 * 2 * 12, 1e-4F);
  return m;
}

TEST(SurfaceMeasurements, ValidatesShapesAndNumbers) {
  validate(small_measurements(), "folder");
  auto wrong = small_measurements();
  wrong.value.pop_back();
  EXPECT_THAT(sentence_of([&] { validate(wrong, "folder"); }),
              HasSubstr("folder: value does not have shape"));
  wrong = small_measurements();
  wrong.variance[5] = 0.0F;
  EXPECT_THAT(sentence_of([&] { validate(wrong, "folder"); }),
              HasSubstr("variance must be positive"));
  wrong.mask.assign(wrong.value.size(), 1);
  wrong.mask[5] = 0;
  validate(wrong, "folder");
  wrong.mask.assign(wrong.value.size(), 0);
  EXPECT_THAT(sentence_of([&] { validate(wrong, "folder"); }), HasSubstr("mask leaves nothing"));
  wrong = small_measurements();
  wrong.irradiance.assign(wrong.irradiance.size(), 0.0F);
  EXPECT_THAT(sentence_of([&] { validate(wrong, "folder"); }),
              HasSubstr("irradiance is zero everywhere"));
  // The least and nearly the largest float: light that no float could follow.
  for (const float light : {1e-45F, 3e38F}) {
    wrong.irradiance.back() = light;
    EXPECT_THAT(sentence_of([&] { validate(wrong, "folder"); }),
                HasSubstr("beyond 1e-20 to 1e20; state it in another unit"));
  }
  wrong = small_measurements();
  wrong.grid.voxel_mm = 1e-40;
  EXPECT_THAT(sentence_of([&] { validate(wrong, "folder"); }),
              HasSubstr("the voxels' edge is 1e-40 mm; it must lie between 1e-06 and 1e+06"));
}

}  // namespace
}  // namespace kappamu

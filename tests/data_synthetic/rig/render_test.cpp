// Pictures agree with the lens and with the radiometry they claim.
#include "data_synthetic/rig/render.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "data_synthetic/rig/targets.h"

namespace kappamu::synthetic {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int rays_per_side = 3;
/// Where a rendered feature may lie off its projection through the lens.
constexpr double feature_px = 0.02;

calib::Lens bent_lens() {
  calib::Lens lens;
  lens.width = 320;
  lens.height = 240;
  lens.fx = 700.0;
  lens.fy = 705.0;
  lens.cx = 163.0;
  lens.cy = 117.0;
  lens.distortion = {-0.3, 0.4, 0.002, -0.001, 0.0};
  return lens;
}

Rigid tilted_pose(double x, double y, double z) {
  Rigid pose;
  pose.rotation = (Eigen::AngleAxisd(0.4, Vector3d(1.0, 0.6, 0.2).normalized())).toRotationMatrix();
  pose.translation = {x, y, z};
  return pose;
}

struct Area {
  double area = 0.0;
  Vector2d centroid = Vector2d::Zero();
};

/// Area [px²] and centroid [px] of a quad's picture: its outline through the lens, finely divided.
Area projected_area(const calib::Lens& lens, const Quad& quad) {
  std::vector<Vector2d> outline;
  const std::array<Vector2d, 4> corners{quad.low, Vector2d(quad.high.x(), quad.low.y()), quad.high,
                                        Vector2d(quad.low.x(), quad.high.y())};
  for (std::size_t side = 0; side < 4; ++side) {
    for (int i = 0; i < 200; ++i) {
      const Vector2d at = corners[side] + i / 200.0 * (corners[(side + 1) % 4] - corners[side]);
      outline.push_back(lens.project(quad.world_from_quad * Vector3d(at.x(), at.y(), 0.0)));
    }
  }
  Area sum;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d& a = outline[i];
    const Vector2d& b = outline[(i + 1) % outline.size()];
    const double cross = a.x() * b.y() - b.x() * a.y();
    sum.area += 0.5 * cross;
    sum.centroid += cross / 6.0 * (a + b);
  }
  sum.centroid /= sum.area;
  return sum;
}

TEST(Render, AQuadFillsItsProjectionThroughTheLens) {
  const calib::Lens lens = bent_lens();
  const RayTable rays(lens, rays_per_side);
  constexpr double reflectance = 0.5;
  const Quad quad = plain_quad({21.3, 17.7}, reflectance, tilted_pose(9.0, -6.0, 110.0));
  Illumination light;
  light.ambient = 2.0;
  const Image<float> image = render_quads(rays, Rigid{}, {quad}, light);
  const Area expected = projected_area(lens, quad);
  Area found;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double part = image(x, y, 1) / (reflectance * light.ambient / std::numbers::pi);
      found.area += part;
      found.centroid += part * Vector2d(x, y);
    }
  }
  found.centroid /= found.area;
  // The outline may be off by feature_px on average.
  const double perimeter = 4.0 * std::sqrt(expected.area);
  EXPECT_NEAR(found.area, expected.area, feature_px * perimeter);
  EXPECT_NEAR(found.centroid.x(), expected.centroid.x(), feature_px);
  EXPECT_NEAR(found.centroid.y(), expected.centroid.y(), feature_px);
}

/// Gaussian blur by 1.2 px: the gradients of an edge one pixel sharp would not be centred on it.
Image<float> blurred(const Image<float>& image) {
  constexpr int radius = 4;
  Image<float> out(image.width(), image.height(), 1);
  for (int y = radius; y < image.height() - radius; ++y) {
    for (int x = radius; x < image.width() - radius; ++x) {
      double sum = 0.0;
      double weights = 0.0;
      for (int j = -radius; j <= radius; ++j) {
        for (int i = -radius; i <= radius; ++i) {
          const double weight = std::exp(-(i * i + j * j) / (2.0 * 1.2 * 1.2));
          sum += weight * image(x + i, y + j, 0);
          weights += weight;
        }
      }
      out(x, y) = static_cast<float>(sum / weights);
    }
  }
  return out;
}

/// Refines a saddle corner: gradients near it are perpendicular to the line to it (Förstner 1987).
Vector2d refine_corner(const Image<float>& image, Vector2d corner) {
  constexpr int radius = 4;
  for (int iteration = 0; iteration < 20; ++iteration) {
    Matrix2d normal = Matrix2d::Zero();
    Vector2d right = Vector2d::Zero();
    const int cx = static_cast<int>(std::lround(corner.x()));
    const int cy = static_cast<int>(std::lround(corner.y()));
    for (int y = cy - radius; y <= cy + radius; ++y) {
      for (int x = cx - radius; x <= cx + radius; ++x) {
        const Vector2d gradient(0.5 * (image(x + 1, y, 0) - image(x - 1, y, 0)),
                                0.5 * (image(x, y + 1, 0) - image(x, y - 1, 0)));
        const double weight = std::exp(-(Vector2d(x, y) - corner).squaredNorm() / 8.0);
        const Matrix2d tensor = weight * gradient * gradient.transpose();
        normal += tensor;
        right += tensor * Vector2d(x, y);
      }
    }
    corner = normal.inverse() * right;
  }
  return corner;
}

TEST(Render, BoardCornersLieWhereTheLensPutsThem) {
  const calib::Lens lens = bent_lens();
  const RayTable rays(lens, rays_per_side);
  const capture::Board board{9, 6, 4.0};
  Rigid pose = tilted_pose(-18.0, -7.0, 140.0);
  const Quad quad = board_quad(board, pose);
  Illumination light;
  light.ambient = 1.0;
  const Image<float> image = blurred(render_quads(rays, Rigid{}, {quad}, light));
  double squares = 0.0;
  for (int j = 0; j < board.rows; ++j) {
    for (int i = 0; i < board.columns; ++i) {
      const Vector2d expected =
          lens.project(pose * Vector3d(i * board.square_mm, j * board.square_mm, 0.0));
      ASSERT_TRUE(lens.contains(expected, 8.0));
      squares += (refine_corner(image, expected) - expected).squaredNorm();
    }
  }
  EXPECT_LT(std::sqrt(squares / (board.columns * board.rows)), feature_px);
}

TEST(Render, ProjectedLightFollowsTheProjectorAndItsBlackLevel) {
  ProjectorModel projector;
  projector.lens = bent_lens();
  projector.projector_from_world.translation = {0.0, 0.0, 200.0};
  const Vector3d normal(0.0, 0.0, -1.0);
  set_white_reference(projector, Vector3d::Zero(), normal);
  Image<float> shown(320, 240, 1, 1.0F);
  const Image<float> white = thrown_image(projector, shown);
  std::fill(shown.values().begin(), shown.values().end(), 0.0F);
  const Image<float> black = thrown_image(projector, shown);
  const ProjectorSample centre = sample_projector(projector, Vector3d::Zero(), normal);
  constexpr double float_rounding = 1e-6;
  EXPECT_NEAR(centre.white * thrown_value(white, centre.pixel), 1.0, float_rounding);
  EXPECT_NEAR(centre.white * thrown_value(black, centre.pixel), 1.0 / 4500.0, float_rounding);
  // Twice as far along the axis: a quarter of the light.
  const Vector3d further = Vector3d(0.0, 0.0, 200.0);
  EXPECT_NEAR(sample_projector(projector, further, normal).white, 0.25, float_rounding);
  // A corner of the picture gets less than cos⁴ alone would leave it; behind the projector nothing.
  const Vector3d ray = projector.lens.unproject(Vector2d(5.0, 5.0));
  const Vector3d corner = projector.projector_from_world.inverse() * Vector3d(200.0 * ray);
  const double cosine = 1.0 / ray.norm();
  EXPECT_LT(sample_projector(projector, corner, normal).white, 0.95 * std::pow(cosine, 4));
  EXPECT_EQ(sample_projector(projector, Vector3d(0, 0, -300.0), normal).white, 0.0);
}

TEST(Render, DefocusKeepsTheLightOfASpot) {
  ProjectorModel projector;
  projector.lens = bent_lens();
  projector.black_level = 0.0;
  Image<float> shown(320, 240, 1);
  shown(100, 90) = 1.0F;
  const Image<float> thrown = thrown_image(projector, shown);
  double sum = 0.0;
  double spread = 0.0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      sum += thrown(x, y);
      spread += thrown(x, y) * (x - 100.0) * (x - 100.0);
    }
  }
  constexpr double truncated_tail = 1e-3;
  EXPECT_NEAR(sum, 1.0, 1e-5);
  EXPECT_NEAR(std::sqrt(spread), projector.defocus_px, truncated_tail + 0.01);
}

TEST(Render, ChartNeutralsHaveTheirPublishedLuminance) {
  // Y = 100 ((L* + 16)/116)³ for L* 95.19 and 20.64.
  EXPECT_NEAR(chart_reflectances()[18][0], 0.8811, 5e-4);
  EXPECT_NEAR(chart_reflectances()[23][2], 0.0315, 5e-4);
  for (std::size_t p = 18; p < 24; ++p) {
    EXPECT_EQ(chart_reflectances()[p][0], chart_reflectances()[p][1]);
    EXPECT_EQ(chart_reflectances()[p][0], chart_reflectances()[p][2]);
    if (p > 18) {
      EXPECT_LT(chart_reflectances()[p][0], chart_reflectances()[p - 1][0]);
    }
  }
  // Red is red, blue is blue.
  EXPECT_GT(chart_reflectances()[14][0], 3.0 * chart_reflectances()[14][2]);
  EXPECT_GT(chart_reflectances()[12][2], 3.0 * chart_reflectances()[12][0]);
}

TEST(Render, ChartAndBoardShowTheirFirstPatchAtTheLeastCorner) {
  const Vector2d fine = Vector2d::Constant(0.1);
  const Quad chart = chart_quad(65.0, Rigid{});
  const double pitch = 10.0;
  const Vector2d first = chart.low + Vector2d::Constant(0.75 * pitch);
  EXPECT_NEAR(chart.albedo(first, fine)[0], chart_reflectances()[0][0], 1e-12);
  const Vector2d black = chart.high - Vector2d::Constant(0.75 * pitch);
  EXPECT_NEAR(chart.albedo(black, fine)[1], chart_reflectances()[23][1], 1e-12);
  const Quad board = board_quad({9, 6, 4.0}, Rigid{});
  EXPECT_NEAR(board.albedo(Vector2d(-2.0, -2.0), fine)[0], ink_reflectance, 1e-12);
  EXPECT_NEAR(board.albedo(Vector2d(2.0, -2.0), fine)[0], paper_reflectance, 1e-12);
  EXPECT_NEAR(board.albedo(Vector2d(-5.0, -5.0), fine)[0], paper_reflectance, 1e-12);
}

/// The face's power, seen from far away along its normal, comes back from the picture:
/// Σ L · (pixel's area on the face) / (L/M) = Σ M · cell area. And either face is seen the right
/// way round: docs/conventions.md.
TEST(FaceView, RadianceIntegratesToExitance) {
  const GridShape surface{23, 17, 5, 0.7};
  const BoundaryConstants constants = boundary_constants(1.3);
  calib::Lens lens;
  lens.width = 200;
  lens.height = 160;
  lens.fx = lens.fy = 80000.0;
  lens.cx = 99.5;
  lens.cy = 79.5;
  const double distance = 10000.0;
  const RayTable rays(lens, rays_per_side);
  std::vector<double> map(static_cast<std::size_t>(23) * 17, 0.01);
  map[2 * 23 + 3] = 1.0;  // u = 3, v = 2
  double power = 0.0;
  for (const double exitance : map) power += exitance * surface.voxel_mm * surface.voxel_mm;
  for (const Face face : {Face::z_minus, Face::z_plus}) {
    Rigid world_from_camera;
    world_from_camera.translation = {0.5 * 23 * 0.7, 0.5 * 17 * 0.7, -distance};
    if (face == Face::z_plus) {
      world_from_camera.rotation.diagonal() << -1.0, 1.0, -1.0;
      world_from_camera.translation.z() = distance + 5 * 0.7;
    }
    const FaceView view(rays, world_from_camera, Rigid{}, surface, face, constants);
    const Image<float> image = view.radiance({map, map});
    double sum = 0.0;
    float brightest = 0.0F;
    int bright_x = 0;
    int bright_y = 0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        sum += image(x, y, 1);
        if (image(x, y, 0) > brightest) {
          brightest = image(x, y, 0);
          bright_x = x;
          bright_y = y;
        }
      }
    }
    const double pixel_mm = distance / lens.fx;
    const double found = sum * pixel_mm * pixel_mm / radiance_per_exitance(constants, 1.0);
    // Bilinear interpolation keeps the sum; the ray lattice cuts the face's edge to a third of a
    // pixel of its 16 mm.
    constexpr double lattice = 0.005;
    EXPECT_NEAR(found / power, 1.0, lattice);
    EXPECT_LT(bright_y, 80);
    EXPECT_EQ(bright_x < 100, face == Face::z_minus);
    EXPECT_TRUE(view.covers(100, 80));
    EXPECT_FALSE(view.covers(1, 1));
  }
}

}  // namespace
}  // namespace kappamu::synthetic

// A block's face laid out by a mesh's texture coordinates.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.h"
#include "core/numbers/at.h"
#include "core/random.h"
#include "render/material/face_chart.h"

namespace kappamu::render {

namespace {

using Eigen::Vector2d;

/// Edge of the lattice's triangles over the face's shorter edge: a piece reaches one edge from its
/// corner, so that its place on the face is free by a third of it.
constexpr double edge_of_face = 1.0 / 3.0;

class TextureChart : public FaceChart {
 public:
  TextureChart(const TriangleMesh& mesh, const GridShape& shape, const Vector2d& size_mm,
               const ChartOptions& options)
      : mesh_(mesh), size_(size_mm), seed_(options.seed) {
    if (mesh.texture.empty()) {
      throw InputError(
          "has no texture coordinates; export the mesh with them, or leave texture_size_mm out: "
          "pieces of the volume are then laid over the surface");
    }
    face_ = options.voxel_mm * Vector2d(shape.nx, shape.ny);
    edge_ = edge_of_face * face_.minCoeff();
    whole_ = true;
    for (const CornerTexture& corners : mesh.texture) {
      for (const Eigen::Vector2f& uv : corners) {
        const Vector2d at = uv.cast<double>().cwiseProduct(size_);
        whole_ = whole_ && at.minCoeff() >= 0.0 && (face_ - at).minCoeff() >= 0.0;
      }
    }
    const Surface surface = surface_of(mesh);
    const std::size_t step = mesh.triangles.size() / most_anchors + 1;
    for (std::size_t t = 0; t < mesh.triangles.size(); t += step) {
      Place place;
      place.triangle = static_cast<int>(t);
      place.weights.setConstant(1.0 / 3.0);
      anchors_.push_back(
          {surface.position[t], surface.normal[t], places(place).all().front().at_mm});
    }
  }

  FacePlaces places(const Place& place) const override {
    const CornerTexture& corners = mesh_.texture[at(place.triangle)];
    Vector2d uv = Vector2d::Zero();
    for (int k = 0; k < 3; ++k) uv += place.weights[k] * corners[at(k)].cast<double>();
    const Vector2d point = uv.cwiseProduct(size_);
    FacePlaces found;
    if (whole_) {
      found.add({1.0, point});
      return found;
    }
    // In the lattice's axes, 60 degrees apart, the triangle that holds the point.
    const double height = std::sqrt(0.75);
    const Vector2d skewed(point.x() / edge_ - 0.5 * point.y() / (height * edge_),
                          point.y() / (height * edge_));
    const Vector2d base = skewed.array().floor(), rest = skewed - base;
    const bool upper = rest.sum() > 1.0;
    const Vector2d corner0 = upper ? Vector2d(base + Vector2d::Ones()) : base;
    const Vector2d weights = upper ? Vector2d(1.0 - rest.y(), 1.0 - rest.x()) : rest;
    const double sign = upper ? -1.0 : 1.0;
    // Across the upper triangle the corners along x and y change places.
    const std::array<Vector2d, 3> corner{
        corner0, corner0 + sign * (upper ? Vector2d::UnitY() : Vector2d::UnitX()),
        corner0 + sign * (upper ? Vector2d::UnitX() : Vector2d::UnitY())};
    const std::array<double, 3> weight{1.0 - weights.sum(), weights.x(), weights.y()};
    for (std::size_t k = 0; k < 3; ++k) {
      if (weight[k] <= 0.0) continue;
      const Vector2d there(edge_ * (corner[k].x() + 0.5 * corner[k].y()),
                           edge_ * height * corner[k].y());
      found.add({std::pow(weight[k], piece_sharpness), drawn(corner[k]) + point - there});
    }
    return found;
  }

  std::span<const Anchor> anchors() const override { return anchors_; }

 private:
  /// Where a corner of the lattice lies on the face.
  Vector2d drawn(const Vector2d& corner) const {
    const auto number = [](double value) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(value));
    };
    const std::uint64_t key = key_of({seed_, number(corner.x()), number(corner.y())});
    return Vector2d::Constant(edge_) + Vector2d(uniform(key), uniform(mix(key)))
                                           .cwiseProduct(face_ - Vector2d::Constant(2.0 * edge_));
  }

  const TriangleMesh& mesh_;
  Vector2d size_, face_{0.0, 0.0};  ///< [mm]
  std::uint64_t seed_;
  double edge_ = 0.0;   ///< of the lattice [mm]
  bool whole_ = false;  ///< the surface fits on the face
  std::vector<Anchor> anchors_;
};

}  // namespace

std::unique_ptr<FaceChart> make_texture_chart(const TriangleMesh& mesh, const NormalScores& scores,
                                              const Vector2d& size_mm,
                                              const ChartOptions& options) {
  return std::make_unique<TextureChart>(mesh, scores.shape(), size_mm, options);
}

}  // namespace kappamu::render

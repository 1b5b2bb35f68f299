// Where places of an object's surface lie on a block's face z+. A face is smaller than most
// surfaces, so that several pieces of it overlap at a place, each with a weight.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "core/mesh/triangle_mesh.h"
#include "render/material/material_field.h"
#include "render/material/normal_scores.h"

namespace kappamu::render {

struct FacePlace {
  double weight = 0.0;              ///< positive, not normalised
  Eigen::Vector2d at_mm{0.0, 0.0};  ///< along the block's x and y, within its face
};

/// The pieces that overlap at one place.
class FacePlaces {
 public:
  void add(const FacePlace& place) {
    if (count_ < list_.size()) list_[count_++] = place;
  }
  std::span<const FacePlace> all() const { return {list_.data(), count_}; }

 private:
  std::array<FacePlace, 48> list_{};
  std::size_t count_ = 0;
};

class FaceChart {
 public:
  virtual ~FaceChart() = default;
  virtual FacePlaces places(const Place& place) const = 0;
  /// Points of the surface that share it out evenly, each with a voxel of the block's lowest layer,
  /// from which an interior is interpolated; at least one.
  struct Anchor {
    Eigen::Vector3d point, normal;  ///< [mm]; outward, of unit length
    Eigen::Vector2d at_mm{0.0, 0.0};
  };
  virtual std::span<const Anchor> anchors() const = 0;
};

/// Weights are this power of how central a place is in a piece, so that pieces mix in narrow rims.
inline constexpr double piece_sharpness = 4.0;
/// Of a chart.
inline constexpr std::size_t most_anchors = 1500;

struct ChartOptions {
  double voxel_mm = 1.0;              ///< of the block as it lies on the object
  Eigen::Vector3d up{0.0, 1.0, 0.0};  ///< what the block's y follows along the surface
  std::uint64_t seed = 1;
};

/// Round pieces of the block laid over the surface, as lapped textures (E. Praun, A. Finkelstein,
/// H. Hoppe 2000): centres at least 5/8 of a radius apart, charts that keep distance and direction
/// from the centre (an exponential map to first order), y along `up`. Of 24 pieces drawn at random
/// each takes the one that fits those laid before best (A. Efros, W. Freeman, Image quilting,
/// 2001). No parameterisation of the whole surface is needed, and there is no seam. Throws
/// InputError where the block's face is too small for a piece.
std::unique_ptr<FaceChart> make_surface_chart(const TriangleMesh& mesh, const NormalScores& scores,
                                              const ChartOptions& options);

/// The mesh's texture coordinates times `size_mm`: the block's face once, from its corner, where
/// they fit on it; otherwise pieces of it on a triangle lattice (T. Deliot, E. Heitz, Procedural
/// stochastic textures by tiling and blending, GPU Zen 2, 2019). Throws InputError where the mesh
/// has none.
std::unique_ptr<FaceChart> make_texture_chart(const TriangleMesh& mesh, const NormalScores& scores,
                                              const Eigen::Vector2d& size_mm,
                                              const ChartOptions& options);

}  // namespace kappamu::render

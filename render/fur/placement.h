// A tile of hair laid over a mesh: overlapping patches, each the tile projected from the tangent
// plane of its centre, turned along the comb and moved at random, so that the tile's repetition is
// not seen (after lapped textures, Praun et al. 2000). Where patches overlap their hair is blended;
// no patch reaches where it would stretch by more than 1.5.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "render/fur/coat.h"
#include "render/scene/scene.h"

namespace kappamu::render {

/// Columns: along the comb, across it, outward normal; of a vertex, in the object's frame.
using SkinFrame = Eigen::Matrix3d;

/// Frames at the vertices of a mesh. Normals are the triangles' mean by area; where the comb's
/// direction is the normal, another one is taken.
std::vector<SkinFrame> skin_frames(const TriangleMesh& mesh, const Fur& fur);
/// The same turned by the coat about the normals.
std::vector<SkinFrame> skin_frames(const TriangleMesh& mesh, const Fur& fur, const Coat& coat);

/// Throws InputError where a tile is smaller than two of the mesh's edges.
void require_tile(const TriangleMesh& mesh, double tile_mm);

class Placement {
 public:
  /// Keeps references to mesh and frames. Throws InputError as require_tile().
  Placement(const TriangleMesh& mesh, const std::vector<SkinFrame>& frames, double tile_mm,
            std::uint64_t seed);

  struct Place {
    Eigen::Vector2d tile;  ///< in the tile, in units of its width; not wrapped
    double weight = 0.0;   ///< of all, sum 1
  };
  /// How many patches count at a place: those that count most.
  static constexpr std::size_t most_places = 4;
  struct Places {
    std::array<Place, most_places> place;
    int count = 0;
  };
  /// At barycentric weights of a triangle's second and third corner.
  Places at(std::size_t triangle, double u, double v) const;

  /// The patches that count most on a triangle: at its corners, unblended. Between corners
  /// places are linear; at() blends the fourth powers of the weights.
  std::array<Places, 3> at_corners(std::size_t triangle) const;

  std::size_t patches() const { return patches_.size(); }
  /// Largest stretch at vertices, of patches that count there by a twentieth or more.
  double stretch() const;

 private:
  struct Patch {
    Eigen::Vector3d centre;
    SkinFrame frame;
    Eigen::Vector2d offset;
  };
  double weight(const Patch& patch, const Eigen::Vector3d& point,
                const Eigen::Vector3d& normal) const;
  void add_patch(std::size_t vertex, std::uint64_t key);

  const TriangleMesh& mesh_;
  const std::vector<SkinFrame>& frames_;
  double tile_mm_;
  std::vector<Patch> patches_;
  std::vector<std::vector<int>> at_vertex_;  ///< patches whose weight there is above zero
};

}  // namespace kappamu::render

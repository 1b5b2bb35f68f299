// Where an object is narrow beside its cubes: slits and thin parts. There the difference of two
// meshes says less about their error than elsewhere (embedded.md, Stated error).
#pragma once

#include <optional>
#include <vector>

#include "forward/embedded/geometry/cut_mesh.h"
#include "forward/object_model.h"

namespace kappamu::forward::embedded {

/// Exitance on a mesh and on the same with every cube split differ by so many times the finer's
/// error, at least: by 3 where it falls with h², by less at edges of object and light.
inline constexpr double difference_per_error = 1.65;
/// A face along the cubes' own cuts all of them alike. Where it halves those of the coarser mesh
/// the finer one has no thinner parts at it: the errors of both go together there, less so away
/// from the half, by this share of a cube.
inline constexpr double difference_per_error_halved = 0.55, difference_per_error_along = 1.25,
                        clear_of_half = 0.2;
/// Across a part thinner than two cubes neither mesh resolves how light varies.
inline constexpr double difference_per_error_thin = 0.6;
/// Where the surface faces itself across a gap narrower than a cube, both meshes bridge it: they
/// differ by a quarter of the error. Narrower than two, the coarser alone does.
inline constexpr double difference_per_error_bridged = 0.25,
                        difference_per_error_half_bridged = 1.0;

class NarrowPlaces {
 public:
  explicit NarrowPlaces(const ObjectProblem& problem);
  /// Per triangle, of the difference of a mesh from the same before its cubes were split.
  std::vector<double> errors_per_difference(const CutMesh& mesh) const;
  /// The leaves at the surface of parts thinner than they are.
  std::vector<int> thin_leaves(const CutMesh& mesh) const;
  /// Area of the surface that a wall faces across less than a cube [mm²].
  double bridged_area(const CutMesh& mesh) const;
  /// Cubes of the mesh about such triangles that three splits at most make smaller than the gap.
  std::vector<int> bridging_cubes(const CutMesh& mesh) const;

 private:
  /// In the largest cube about each triangle; nullptr: none.
  std::vector<const CutMesh::Piece*> largest_pieces(const CutMesh& mesh) const;
  /// Of the largest cube about each triangle [mm].
  std::vector<double> edges(const CutMesh& mesh) const;

  std::vector<double> area_;             ///< per triangle [mm²]
  std::vector<double> gap_, thickness_;  ///< per triangle [mm]
  std::vector<double> slit_;             ///< the gap where a wall faces the triangle, else infinite
  std::vector<std::optional<int>> axis_;  ///< of the normal, where it runs along the cubes' edges
};

}  // namespace kappamu::forward::embedded

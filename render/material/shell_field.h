// A measured block wrapped round an object ([W] 5: a shell map, Porumbescu et al. 2005): its face
// z+ or z- lies on the surface, its layers below it along the inward normal, at its scale in mm.
// Below its last layer the core is a solid texture of pieces of it, or interpolated from that layer
// by mean-value coordinates (Ju et al. 2005), positive ones alone.
#pragma once

#include <memory>

#include "core/mesh/triangle_mesh.h"
#include "io/volume/volume_set.h"
#include "render/material/face_chart.h"
#include "render/material/material_field.h"
#include "render/material/shell.h"

namespace kappamu::render {

class ShellField : public MaterialField {
 public:
  /// `mesh` outlives it. The block has one channel, or R, G and B in this order. Throws InputError.
  ShellField(const io::VolumeSet& block, const Shell& shell, const TriangleMesh& mesh);

  ColourCoefficients at(const Place& place) const override;
  double detail_mm() const override { return voxel_; }
  bool of_point_alone(double shallow, double deep) const override;
  /// Where a place of the surface lies on the block's face that is outside, and the pieces'
  /// weights.
  FacePlaces on_face(const Place& place) const { return chart_->places(place); }
  /// Of the block as it lies on the object [mm].
  double voxel_mm() const { return voxel_; }

 private:
  class Mixture;
  ColourCoefficients mixed(const Mixture& mixture) const;
  void add_shell(const Place& place, double share, Mixture& mixture) const;
  void add_core(const Eigen::Vector3d& point, double share, Mixture& mixture) const;
  std::size_t face_voxel(const Eigen::Vector2d& at_mm, int z) const;
  ColourCoefficients interpolated(const Eigen::Vector3d& point) const;

  NormalScores scores_;
  Shell shell_;
  double voxel_ = 1.0, thickness_ = 0.0;  ///< of the block as it lies on the object [mm]
  std::unique_ptr<FaceChart> chart_;
  std::vector<ColourCoefficients> below_;  ///< [anchor] of the block's last layer
};

}  // namespace kappamu::render

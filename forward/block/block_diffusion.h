// Grid diffusion in a box that lies in a scene: light on triangles in, exitance on triangles out.
// Keeps equations and fluence, so that another light or a changed medium is solved from the last
// answer.
#pragma once

#include <memory>
#include <string>

#include "forward/block/block_grid.h"
#include "forward/grid/grid_solver.h"
#include "forward/object_model.h"

namespace kappamu::forward::block {

struct BlockAnswer {
  std::vector<double> exitance;        ///< [light][triangle]
  std::vector<ObjectBalance> balance;  ///< one per light; exiting by the faces' pixels
  SolveReport report;
};

/// How exactly the equations are made and solved.
struct BlockAccuracy {
  double linear_tolerance = 1e-6;  ///< as SolveOptions::tolerance
  /// When no more than this share of a beam is left, the rest collides in the voxel that it has
  /// reached.
  double beam_remainder = 1e-9;
};

class BlockDiffusion {
 public:
  /// Of one colour channel. `device` as make_grid_solver() takes it. Keeps a reference to the map,
  /// which is of the same grid.
  BlockDiffusion(const BlockGrid& grid, const FaceMap& map, double eta, const std::string& device);
  ~BlockDiffusion();

  void set_medium(const ObjectMedium& medium);
  /// After set_medium(), with the problem's own mesh; its medium is not looked at.
  BlockAnswer solve(const ObjectProblem& problem, const BlockAccuracy& accuracy);

  const std::string& warning() const { return warning_; }  ///< of the device; mostly empty

 private:
  /// What a light's beams scatter first in each voxel, added to `load` [z][y][x].
  void enter_beams(const ObjectProblem& problem, const ObjectLight& light, double remainder,
                   std::span<double> load, ObjectBalance& balance) const;

  BlockGrid grid_;
  const FaceMap& map_;
  std::unique_ptr<GridSolver> solver_;
  std::string warning_;
  Medium medium_;
  std::unique_ptr<BatchField> source_, fluence_;
};

}  // namespace kappamu::forward::block

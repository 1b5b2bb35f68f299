// Diffusion in an object that has a polygrid: light on triangles in, exitance on triangles out, for
// all colour channels at once. Keeps equations and fluence, so that another light or a changed
// medium is solved from the last answer.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/optics.h"
#include "forward/object_model.h"
#include "forward/polygrid/linear_solver.h"
#include "forward/polygrid/surface_map.h"

namespace kappamu::forward::polygrid {

/// One channel's answer.
struct PolygridAnswer {
  std::vector<double> exitance;        ///< [light][triangle]
  std::vector<ObjectBalance> balance;  ///< one per light; exiting over the polygrid's boundary
};

/// How exactly the equations are made and solved.
struct PolygridAccuracy {
  double linear_tolerance = 1e-5;  ///< ‖residual‖/‖load‖ of every light
  double beam_remainder = 1e-6;    ///< add_beams()
  int most_iterations = 300;
};

class PolygridDiffusion {
 public:
  /// `device` as make_linear_solver() takes it. Throws InputError where a cell is inverted.
  PolygridDiffusion(Polygrid grid, const TriangleMesh& mesh, const Surface& surface, double eta,
                    const std::string& device);
  ~PolygridDiffusion();

  const Polygrid& grid() const { return grid_; }

  /// One medium per channel.
  void set_media(std::span<const ObjectMedium* const> media);
  /// After set_media(): one problem per channel, each with the same number of lights and with the
  /// object's own mesh; their media are not looked at.
  std::vector<PolygridAnswer> solve(std::span<const ObjectProblem> problems,
                                    const PolygridAccuracy& accuracy);

  const CgReport& report() const { return report_; }  ///< of the last solve()

 private:
  std::vector<double> load_of(const ObjectProblem& problem, const ObjectLight& light,
                              std::size_t channel, double remainder, ObjectBalance& balance) const;

  Polygrid grid_;
  BoundaryConstants constants_;
  Equations equations_;
  Hierarchy hierarchy_;
  SurfaceMap map_;
  std::unique_ptr<LinearSolver> solver_;
  std::vector<std::vector<Coefficients>> of_cell_;  ///< [channel][cell]
  std::vector<std::vector<double>> absorption_;     ///< [channel][corner] [mm²]
  std::vector<std::vector<double>> fluence_;        ///< [channel and light][corner], the last
  CgReport report_;
};

/// κ and μ in every cell: the medium's means over points not farther apart than its voxels, up to
/// four along each of the cell's edges.
std::vector<Coefficients> coefficients_of_cells(const Polygrid& grid, const ObjectMedium& medium);

}  // namespace kappamu::forward::polygrid

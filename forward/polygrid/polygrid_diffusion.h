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
#include "forward/polygrid/beams.h"
#include "forward/polygrid/linear_solver.h"
#include "forward/polygrid/surface_map.h"

namespace kappamu::forward::polygrid {

/// One channel's answer.
struct PolygridAnswer {
  std::vector<double> exitance;            ///< [light][triangle]
  std::vector<ObjectBalance> balance;      ///< one per light; exiting over the polygrid's boundary
  std::vector<std::vector<Beam>> leaving;  ///< [light], unscattered; none where lights move
};

/// Processor time of the last answer and of the last media, by what it went to, and how long
/// solving took by the clock [s].
struct PolygridSeconds {
  double media = 0.0, beams = 0.0, solving = 0.0, exitance = 0.0, solving_elapsed = 0.0;
};

/// How exactly the equations are made and solved.
struct PolygridAccuracy {
  double linear_tolerance = 1e-5;  ///< of every light, as LinearSolver::solve takes it
  double beam_remainder = 1e-6;    ///< BeamWalks::add()
  int most_iterations = 300;
};

class PolygridDiffusion {
 public:
  /// `device` as make_linear_solver() takes it. Where lights are `moving`, beams that come again
  /// are not walked again, which takes memory. Throws InputError where a cell is inverted.
  PolygridDiffusion(Polygrid grid, const TriangleMesh& mesh, const Surface& surface, double eta,
                    const std::string& device, Lights lights = Lights::others);
  ~PolygridDiffusion();

  const Polygrid& grid() const { return grid_; }
  const SurfaceMap& surface_map() const { return map_; }

  /// One medium per channel. Media that differ from the last ones in a part of the object alone
  /// change the equations there alone.
  void set_media(std::span<const ObjectMedium* const> media);
  /// After set_media(): one problem per channel, each with the same number of lights and with the
  /// object's own mesh; their media are not looked at.
  std::vector<PolygridAnswer> solve(std::span<const ObjectProblem> problems,
                                    const PolygridAccuracy& accuracy);

  /// The next answer starts from the last one of `former`, whose cells are the same ones elsewhere.
  void start_from(const PolygridDiffusion& former) { fluence_ = former.fluence_; }

  const CgReport& report() const { return report_; }  ///< of the last solve()
  const PolygridSeconds& seconds() const { return seconds_; }

 private:
  /// Coefficients of the cells that meet `region`; marks the rows of those that have changed.
  void renew_cells(std::span<const ObjectMedium* const> media, const Eigen::AlignedBox3d& region,
                   std::vector<char>& row_changed);
  void add_light(std::span<const ObjectProblem> problems, std::size_t light, double remainder,
                 std::vector<PolygridAnswer>& answers);
  /// q of E_t = 1, and E_t less what q sends out.
  double entering_less_q() const {
    return 1.0 - constants_.q_per_entering() / (2.0 * constants_.A);
  }

  Polygrid grid_;
  BoundaryConstants constants_;
  Equations equations_;
  Hierarchy hierarchy_;
  SurfaceMap map_;
  std::unique_ptr<LinearSolver> solver_;
  Lights lights_;
  double longest_cell_ = 0.0;        ///< along an axis [mm]
  std::vector<BeamWalks> walks_;     ///< [light]; one for all where beams are not kept
  std::vector<ObjectMedium> media_;  ///< [channel]
  std::vector<std::vector<Coefficients>> of_cell_;  ///< [channel][cell]
  std::vector<Load> loads_;                         ///< [channel and light], of the last light
  std::vector<std::vector<double>> fluence_;        ///< [channel and light][corner], the last
  CgReport report_;
  PolygridSeconds seconds_;
};

/// [medium][cell] κ and μ: the medium's means over points not farther apart than its voxels, up to
/// four along each of the cell's edges.
std::vector<std::vector<Coefficients>> coefficients_of_cells(
    const Polygrid& grid, std::span<const ObjectMedium* const> media);

}  // namespace kappamu::forward::polygrid

// A capture plan: what to photograph, how often and how long, before anything is photographed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/rig/shoot.h"

namespace kappamu::capture {

/// What the operator knows of sample and rig. Lengths in mm, times in s.
struct PlanRequest {
  Sample sample;  ///< grid, voxel edge, faces
  Setup setup = Setup::back_lit;
  Camera camera;
  Projector projector;
  double projector_px_per_mm = 0.0;  ///< of the projector's picture in the plane of the lit face
  double period_s = 1.0 / 60.0;      ///< of the projector's refresh or colour wheel
  double longest_s = 4.0;            ///< longest exposure
  int exposures = 5;                 ///< per pattern
  int repeats = 1;                   ///< photographs of each exposure, which are averaged
  FitLight light;                    ///< patterns for the fit
  int validate_patches = 2;          ///< n × n patches kept out of the fit; 0 = none
  Board board{9, 6, 4.0};
  int boards = 15;
  int planes = 6;
  PlaneLight plane_light = PlaneLight::chessboard;
  int projector_levels = 0;  ///< values between black and white on the white target
  bool ambient = false;      ///< also photograph with the projector off
  double white_reflectance = 0.99;
  bool colour_chart = true;
};

/// Exposure times evenly spaced in ln t, each a multiple of `period_s`, from the shortest multiple
/// of at least 1/30 s up to `longest_s`; fewer than `count` where multiples coincide. Throws
/// InputError if longest_s allows none.
std::vector<double> exposure_times(double period_s, double longest_s, int count);

/// The session is as it will be once every photograph is there.
struct Plan : Rehearsal {
  CapturePlan capture;
  double disk_bytes = 0.0;  ///< 16-bit files uncompressed: an upper bound
  double exposing_s = 0.0;  ///< sum of exposure times
  double working_s = 0.0;   ///< with 2 s per frame and 30 s per new arrangement of things
};

/// Throws InputError naming what contradicts what: a lit face larger than the projector's picture,
/// a longest exposure below 1/30 s, a grid finer than the projector's pixels.
Plan make_plan(const PlanRequest& request, const std::filesystem::path& folder);

/// Writes session.json, what the projector shows (patterns/, calibration/projected_board.png or
/// gray_code_NN.png ...), board.pdf, rig.svg (printables.h), shots.csv, shots.json and shots.txt
/// into the plan's folder. `kappamu run` accepts it once the photographs are there.
void write_plan(const Plan& plan);

}  // namespace kappamu::capture

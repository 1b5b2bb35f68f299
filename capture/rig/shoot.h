// Shoots a capture plan through a RigDevice and leaves a session folder (docs/formats.md).
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/rig/device.h"
#include "capture/session/session.h"
#include "core/image.h"
#include "core/names.h"
#include "core/progress.h"

namespace kappamu::capture {

/// A light pattern still to be photographed.
struct PlannedPattern {
  std::string id;             ///< letters, digits, '_', '-', '.'; unique
  Image<std::uint8_t> image;  ///< one channel, the projector's size, 0 dark, 255 full white
  PatternRole role = PatternRole::fit;
};

/// What the projector throws on the planes that calibrate it.
enum class PlaneLight {
  chessboard,  ///< one picture a plane
  gray_code,   ///< two pictures a plane for each bit of column and row, white and black
  both,        ///< the Gray code calibrates, the chessboard checks it
  phase_shift  ///< sinusoids of three periods in both directions, six steps each
};
bool gray_codes(PlaneLight light);  ///< whether it has a Gray code
inline constexpr Names<PlaneLight, 4> plane_light_names{{{"chessboard", PlaneLight::chessboard},
                                                         {"gray-code", PlaneLight::gray_code},
                                                         {"both", PlaneLight::both},
                                                         {"phase-shift", PlaneLight::phase_shift}}};
/// Throws InputError for another text.
PlaneLight plane_light_from_string(const std::string& text);

/// Everything a session needs that the rig cannot know by itself. Empty or zero parts are left out
/// of the session where its format allows that.
struct CapturePlan {
  std::string description;  ///< of the rig, for the report; may be empty
  Setup setup = Setup::back_lit;
  Sample sample;
  std::string calibration_station = "front";
  std::string pattern_station = "back";  ///< the same as calibration_station when front-lit
  std::vector<PlannedPattern> patterns;
  std::vector<double> exposures_s;         ///< of each pattern's stack [s]; may repeat
  std::vector<double> target_exposures_s;  ///< of white target and chart [s]; empty = exposures_s
  Board board;
  int camera_board_views = 15;
  ProjectedBoard projected_board;
  int projector_plane_poses = 6;
  PlaneLight plane_light = PlaneLight::chessboard;
  std::optional<double> white_reflectance;  ///< in (0, 1]; absent = no white target
  /// Projector values between black and white that the white target is shot under as well.
  std::vector<std::uint8_t> projector_levels;
  /// Shoot white target and sample with the projector off too, the sample before and after the
  /// patterns: for rooms that are not dark.
  bool ambient = false;
  /// Back-lit: the camera sees the patterns for the fit from the calibration station too, on the
  /// lit face.
  bool both_faces = false;
  bool colour_chart = true;
  int dark_repeats = 2;  ///< dark frames at the shortest and at the longest exposure, each
};

/// Shoots everything and writes folder/session.json last, so that a folder with one is complete.
/// Single frames (boards, planes, sample views) are metered: the longest time among the plan's that
/// saturates fewer than 0.2 % of the code values. Throws InputError for a plan that contradicts
/// itself or the rig, before the first exposure.
Session shoot_session(RigDevice& device, const CapturePlan& plan,
                      const std::filesystem::path& folder, Progress& progress);

/// One photograph to take, in the order to take them.
struct Shot {
  std::string file;         ///< relative to the session folder
  std::string subject;      ///< what stands before the rig, in words
  std::string station;      ///< camera station
  std::string show;         ///< what the projector shows: an image of the folder, black, off
  double exposure_s = 0.0;  ///< [s]; for metered shots a beginning
  bool metered = false;     ///< choose the longest of the plan's times that does not saturate
};

/// What shoot_session() would do, without a device and without a file: what a plan lists.
struct Rehearsal {
  Session session;  ///< as it would be left; metered frames have the plan's first exposure time
  std::vector<Shot> shots;
  std::map<std::string, Image<std::uint8_t>> pictures;  ///< by the names of Shot::show
};
Rehearsal rehearse_session(const Camera& camera, const Projector& projector,
                           const CapturePlan& plan, const std::filesystem::path& folder);

/// The lit face's outline in projector pixels, corners in the order of docs/conventions.md:
/// (u, v) = (0,0), (max,0), (max,max), (0,max).
using ProjectorQuad = std::array<std::array<double, 2>, 4>;

enum class LightShape { bars, patches, sinusoids };

/// Sinusoids over the projector's whole picture, 1/2 + 1/2 cos(2π f s + φ), s the way along the
/// direction on the lit face: each frequency in each direction in each phase.
struct Sinusoids {
  std::vector<double> per_mm;                   ///< spatial frequencies on the lit face [1/mm], > 0
  std::vector<double> directions_degrees{0.0};  ///< from u towards v
  int phases = 3;                               ///< evenly over 360 degrees, 3 or more
};

/// What the projector shows for the fit: n bars across either axis of the lit face, 2 n patterns,
/// or n * n patches; sixteen patterns unless chosen (docs/benchmarks.md, "Which light"). Or
/// sinusoids, for maps.
struct FitLight {
  LightShape shape = LightShape::bars;
  int n = 8;
  Sinusoids sinusoids{};
};

/// The patterns of `light` with the role fit: bars across u first, then across v; ids and overhang
/// as those of make_patch_patterns(). Sinusoids need the lit face's extents along u and v [mm];
/// their ids are "fit_sine_FF_DD_P" with the numbers of frequency, direction and phase. Throws
/// InputError for a frequency of less than four projector pixels a period.
std::vector<PlannedPattern> make_fit_patterns(const Projector& projector, const ProjectorQuad& quad,
                                              const FitLight& light, double overhang,
                                              const std::array<double, 2>& face_mm = {});

/// n * n patterns, each lighting one cell of the n * n division of the quad (by its homography),
/// cells in rows of u; ids are prefix + two or more digits from 00. The outer cells reach beyond
/// the quad by `overhang` of its width: a quad aimed by eye leaves a strip of the face dark
/// otherwise, below which nothing is measured.
std::vector<PlannedPattern> make_patch_patterns(const Projector& projector,
                                                const ProjectorQuad& quad, int n, double overhang,
                                                PatternRole role, const std::string& prefix);

/// What the projector shows for a projected board: squares exact by area coverage, black top left
/// square, one square of white around, black beyond.
Image<std::uint8_t> make_chessboard_image(const Projector& projector, const ProjectedBoard& board);

/// The sets of phase-shifted sinusoids that PlaneLight::phase_shift projects, without frames: a
/// period over the frame, an eighth and a sixty-fourth of it, along columns, then along rows.
std::vector<PhaseShift> usual_phase_shift(const Projector& projector);
inline constexpr int usual_phase_steps = 6;  ///< harmonics two to four of the light drop out

/// Which of the sets has the shortest period.
std::size_t finest_set(const std::vector<PhaseShift>& sets);

/// The `steps` pictures of a set.
std::vector<Image<std::uint8_t>> make_phase_shift_images(const Projector& projector,
                                                         const PhaseShift& set, int steps);

/// The Gray code of ProjectorPlane::gray_code, in its order.
std::vector<Image<std::uint8_t>> make_gray_code_images(const Projector& projector);

/// `count` values evenly between 0 and 255, without these two.
std::vector<std::uint8_t> projector_levels(int count);

/// An image of the projector's size in one grey value.
Image<std::uint8_t> make_uniform_image(const Projector& projector, std::uint8_t value);

}  // namespace kappamu::capture

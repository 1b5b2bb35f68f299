// The capture session: what a rig (or the simulator) leaves behind, and all the pipeline ever
// reads. Format: docs/formats.md and docs/session.schema.json.
#pragma once

#include <array>
#include <bit>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/grid.h"
#include "core/names.h"
#include "core/surface_measurements.h"
#include "io/image/raw_file.h"

namespace kappamu::capture {

/// One photograph. `file` is relative to the session folder.
struct Frame {
  std::string file;
  double exposure_s = 0.0;  ///< exposure time [s], > 0
};

/// Photographs of one unchanging scene at several exposure times; those of one time are averaged.
using Stack = std::vector<Frame>;

enum class Setup {
  back_lit,  ///< camera and projector on opposite sides: lit face and seen face are opposite
  front_lit  ///< camera beside the projector: one face is lit and seen, lit pixels are left out
};
inline constexpr Names<Setup, 2> setup_names{
    {{"back-lit", Setup::back_lit}, {"front-lit", Setup::front_lit}}};

enum class PatternRole {
  fit,      ///< used by the fit
  validate  ///< kept out of the fit; the report shows how well it is predicted
};

/// A light pattern and the frames that show the sample under it.
struct Pattern {
  std::string id;  ///< unique; names the HDR file
  std::string
      image;  ///< what the projector showed: grey PNG of the projector's size, 0 dark, full white
  PatternRole role = PatternRole::fit;
  Stack frames;
  /// Back-lit: the calibration station where the camera saw the lit face under this light; empty:
  /// Session::pattern_station.
  std::string station{};
};

/// How the sample's radiance towards the camera follows from its light.
enum class Radiance {
  transport,  ///< as light leaves a smooth surface, scattered last within a mean free path
  p1          ///< by the exitance and the P1 law alone: rough surfaces nearly, simulated sessions
};
inline constexpr Names<Radiance, 2> radiance_names{
    {{"transport", Radiance::transport}, {"p1", Radiance::p1}}};

struct Sample {
  std::string name;
  std::array<int, 3> grid{};  ///< voxels to fit along x, y, z of the sample frame
  double voxel_mm = 0.0;      ///< voxel edge [mm]; the block measures grid * voxel_mm
  double eta = 1.3;           ///< refractive index relative to air [dimensionless]
  Sides sides = Sides::open;
  Face lit_face = Face::z_minus;
  Face seen_face = Face::z_plus;
  Radiance radiance = Radiance::transport;

  GridShape shape() const { return {grid[0], grid[1], grid[2], voxel_mm}; }
};

enum class Encoding {
  linear,   ///< code value proportional to light above the black level (RAW)
  response  ///< an unknown monotone response curve, recovered from the stacks
};
inline constexpr Names<Encoding, 2> encoding_names{
    {{"linear", Encoding::linear}, {"response", Encoding::response}}};

struct Camera {
  int width = 0;      ///< [px]
  int height = 0;     ///< [px]
  int bit_depth = 8;  ///< significant bits of a code value, 8 to 16; codes run from 0 to 2^bits - 1
  Encoding encoding = Encoding::response;
  /// Code at which the sensor saturates, where that is below 2^bits - 1 (RAW); full scale then is
  /// this code. Linear encoding only.
  std::optional<int> white_level;
  std::optional<double> electrons_full_scale;  ///< photo-electrons at full scale, for shot noise
  std::optional<double> read_noise_electrons;  ///< standard deviation [electrons]
  /// Of frames named *.raw, which then have no header: width x height codes of bit_depth bits.
  std::optional<io::RawLayout> raw_layout{};
  /// EXIF tag by which every frame is turned when it is read, 1 to 8 (io/image/orientation.h);
  /// width and height are those of the upright picture. Nothing: frames are taken as stored.
  std::optional<int> orientation{};
};

struct Projector {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
};

enum class BoardKind {
  chessboard,
  charuco,            ///< chessboard with ArUco markers in its light squares; may be seen in part
  circles,            ///< dark dots on a square lattice
  asymmetric_circles  ///< dark dots, every other row moved by half a spacing, as OpenCV's
};
inline constexpr Names<BoardKind, 4> board_kind_names{
    {{"chessboard", BoardKind::chessboard},
     {"charuco", BoardKind::charuco},
     {"circles", BoardKind::circles},
     {"asymmetric-circles", BoardKind::asymmetric_circles}}};
inline std::string to_string(BoardKind kind) {
  return name_of(board_kind_names, kind);
}

/// A printed board by its inner corners or dots, (i, j) at square_mm (i, j) in its plane;
/// asymmetric circles at square_mm (2 i + j mod 2, j).
struct Board {
  int columns = 0;         ///< inner corners or dots along x
  int rows = 0;            ///< the same along y
  double square_mm = 0.0;  ///< spacing of the lattice: a square's edge [mm]
  BoardKind kind = BoardKind::chessboard;
  double marker_mm = 0.0;    ///< ChArUco: edge of a marker [mm], below square_mm
  std::string dictionary{};  ///< ChArUco: one of marker_dictionaries
};

struct MarkerDictionary {
  std::string_view name;
  int markers;
};
/// OpenCV's predefined ArUco dictionaries, in the order of its numbers.
inline constexpr std::array<MarkerDictionary, 21> marker_dictionaries{{
    {"DICT_4X4_50", 50},        {"DICT_4X4_100", 100},         {"DICT_4X4_250", 250},
    {"DICT_4X4_1000", 1000},    {"DICT_5X5_50", 50},           {"DICT_5X5_100", 100},
    {"DICT_5X5_250", 250},      {"DICT_5X5_1000", 1000},       {"DICT_6X6_50", 50},
    {"DICT_6X6_100", 100},      {"DICT_6X6_250", 250},         {"DICT_6X6_1000", 1000},
    {"DICT_7X7_50", 50},        {"DICT_7X7_100", 100},         {"DICT_7X7_250", 250},
    {"DICT_7X7_1000", 1000},    {"DICT_ARUCO_ORIGINAL", 1024}, {"DICT_APRILTAG_16h5", 30},
    {"DICT_APRILTAG_25h9", 35}, {"DICT_APRILTAG_36h10", 2320}, {"DICT_APRILTAG_36h11", 587},
}};

/// The chessboard image the projector shows: inner corner (i, j) lies at origin_px + square_px *
/// (i, j) in projector pixels (pixel centres at integers).
struct ProjectedBoard {
  int columns = 0;
  int rows = 0;
  double square_px = 0.0;
  std::array<double, 2> origin_px{};
};

/// A sinusoid over the projector's frame, moved on by a part of its period from frame to frame:
/// frame n of N shows 1/2 + 1/2 cos 2π(u/period_px - n/N) at column or row u.
struct PhaseShift {
  enum class Along { columns, rows };
  Along along = Along::columns;
  double period_px = 0.0;
  std::vector<Frame> frames;  ///< N >= 3, at one exposure time
};

/// A plane held before camera and projector: the printed board on it as the camera sees it, and on
/// the same, unmoved plane what the projector throws: a chessboard on the blank part, a code over
/// its whole frame, or one after the other. All planes of a session have the one, or all the other.
struct ProjectorPlane {
  Frame board;
  std::optional<Frame> projected;
  /// Gray code over the projector's whole frame, or empty: bits of the
  /// column, most significant first, each followed by its inverse, the row's likewise, white, black
  /// (OpenCV's structured_light order).
  std::vector<Frame> gray_code{};
  /// In both directions. The longest period of each spans the frame, unless a Gray code tells the
  /// periods apart.
  std::vector<PhaseShift> phase_shift{};
  /// File with the projector pixel that each camera pixel sees, from any other code
  /// (calib/projector/correspondences.h); relative to the session folder, or empty.
  std::string correspondences{};

  bool coded() const {
    return !gray_code.empty() || !phase_shift.empty() || !correspondences.empty();
  }
};

/// Frames of a Gray code of `projector`: two for each bit of its columns and rows, white, black.
inline int gray_code_frames(const Projector& projector) {
  const auto bits = [](int extent) {
    return static_cast<int>(std::bit_width(static_cast<unsigned>(extent - 1)));
  };
  return 2 * (bits(projector.width) + bits(projector.height)) + 2;
}

/// The sample itself, evenly lit before a dark background, from one camera station.
struct SampleView {
  std::string station;
  Face face = Face::z_minus;  ///< the face that looks at the camera
  Frame frame;
  /// Corner pixels of the face's outline in the order of docs/conventions.md; found in the picture
  /// when absent.
  std::optional<std::array<std::array<double, 2>, 4>> corners_px;
};

/// The white target under one projector value.
struct ProjectorLevel {
  int value = 0;  ///< 1 to 254
  Stack frames;
};

/// Diffuse white target in the plane of the sample's lit face, lit by the projector's full white.
struct WhiteTarget {
  double reflectance = 0.0;  ///< in (0, 1]
  Stack frames;
  Stack black_frames{};  ///< the same while the projector shows black; may be empty
  Stack off_frames{};    ///< projector off or capped, the room's light; may be empty
  std::vector<ProjectorLevel> levels{};  ///< values rising; may be empty
};

/// ColorChecker Classic in the plane of the sample's lit face, lit by the projector's full white.
struct ColourChart {
  Stack frames;
  /// Centres of dark skin, bluish green, black and white patches (the four corner patches, in this
  /// order).
  std::optional<std::array<std::array<double, 2>, 4>> corners_px;
};

/// The camera's lens, known from elsewhere.
struct LensFile {
  std::string file;  ///< as `kappamu calibrate --lens` reads it, relative to the session folder
  bool held = true;  ///< false: a start, all of its numbers are estimated anew
};

/// Camera stations are camera poses relative to the rig. Projector planes, white target and chart
/// are shot from `calibration_station`, patterns from `pattern_station`; a sample view is needed
/// from each of the two. Lens, focus and aperture stay the same throughout.
struct Calibration {
  std::optional<LensFile> lens{};
  std::vector<Frame> camera_boards;  ///< printed board in many poses
  Board board;
  std::optional<ProjectedBoard> projected_board;  ///< of the planes' `projected`
  std::vector<ProjectorPlane> projector_planes;
  std::vector<SampleView> sample_views;
  std::vector<Frame> dark;  ///< lens covered
  std::optional<WhiteTarget> white_target;
  /// The sample from the pattern station with the projector off or capped, the room as under the
  /// patterns; taken several times it tells how the room's light changed. May be empty.
  std::vector<Stack> ambient{};
  std::optional<ColourChart> colour_chart;
};

struct Session {
  std::filesystem::path folder;  ///< where its files lie; not part of session.json
  /// The session.json that was read, of a plan where import filled it; empty: made otherwise.
  std::filesystem::path source;
  /// Where the pictures come from, in words; the report prints it. A simulator says here how it
  /// made them.
  std::string description;
  Setup setup = Setup::back_lit;
  std::vector<std::string> channels{"R", "G", "B"};
  Sample sample;
  Camera camera;
  Projector projector;
  std::string calibration_station = "front";
  std::string pattern_station = "front";
  std::vector<Pattern> patterns;
  Calibration calibration;
  /// What the instrument's errors are known to be; absent: measured from the session.
  std::optional<SmoothError> smooth_error{};
};

/// The face that the camera sees under a pattern.
Face pattern_face(const Session& session, const Pattern& pattern);

/// Reads and checks folder/session.json. Throws InputError with one sentence naming file, field and
/// fix for an unreadable file, a missing or unknown field, a wrong unit, non-positive
/// exposure times, one file twice in a stack, a pattern without frames. Does not open the images.
Session read_session(const std::filesystem::path& folder);

/// The checks of read_session on a session made otherwise.
void validate(const Session& session);

/// Writes session.folder/session.json (atomically) after validate().
void write_session(const Session& session);

}  // namespace kappamu::capture

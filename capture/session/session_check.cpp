// What the values of a session must fulfil, alone and together; used on reading and on writing.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "capture/session/session.h"
#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"

namespace kappamu::capture {
namespace {

// Times closer than this carry no information about the response and are a typing mistake.
constexpr double equal_exposure_tolerance = 1e-6;
constexpr int largest_image_extent = 65535;  // [px], of the file formats
constexpr int largest_grid_extent = 8192;    // [voxels]

std::string shown(double value) {
  return shown_number(value, "%.9g");
}

class Checker {
 public:
  explicit Checker(const Session& session)
      : session_(session), file_((session.folder / "session.json").string()) {}

  void run() const {
    channels();
    sample();
    camera_and_projector();
    stations();
    patterns();
    boards();
    sample_views();
    targets();
  }

 private:
  [[noreturn]] void fail(const std::string& field, const std::string& what) const {
    throw InputError(file_ + ": " + field + " " + what + ".");
  }
  void require(bool holds, const std::string& field, const std::string& what) const {
    if (!holds) fail(field, what);
  }
  void whole(int value, int low, int high, const std::string& field) const {
    require(value >= low && value <= high, field,
            "is " + std::to_string(value) + "; it must lie between " + std::to_string(low) +
                " and " + std::to_string(high));
  }
  void positive(double value, const std::string& field, const std::string& unit) const {
    require(std::isfinite(value) && value > 0.0, field,
            "is " + shown(value) + "; it must be a positive number" + unit);
  }

  void relative_path(const std::string& path, const std::string& field) const {
    require(!path.empty(), field, "is empty; name a file inside the session folder");
    require(stays_inside(path), field,
            "is '" + shown_name(path) +
                "'; file names are relative to the session folder and stay inside it");
  }

  void frame(const Frame& frame, const std::string& field) const {
    relative_path(frame.file, field + ".file");
    positive(frame.exposure_s, field + ".exposure_s", " of seconds");
  }
  void frames(const std::vector<Frame>& list, const std::string& field) const {
    require(!list.empty(), field, "has no frames; list at least one");
    for (std::size_t i = 0; i < list.size(); ++i) frame(list[i], indexed(field, i));
  }
  // Frames of one unchanging scene: times must differ, files too.
  void stack(const Stack& list, const std::string& field) const {
    frames(list, field);
    for (std::size_t i = 0; i < list.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const double a = list[i].exposure_s;
        const double b = list[j].exposure_s;
        require(std::abs(a - b) > equal_exposure_tolerance * std::max(a, b),
                indexed(field, i) + ".exposure_s",
                "equals that of " + indexed(field, j) + " (" + shown(a) +
                    " s); the exposure times of a stack must differ");
        require(list[i].file != list[j].file, indexed(field, i) + ".file",
                "is the same file as " + indexed(field, j) + " ('" + list[i].file +
                    "'); each exposure has its own file");
      }
    }
  }
  void stack_if_any(const Stack& list, const std::string& field) const {
    if (!list.empty()) stack(list, field);
  }
  static std::string indexed(const std::string& field, std::size_t i) {
    return field + "[" + std::to_string(i) + "]";
  }

  void name(const std::string& text, const std::string& field) const {
    require_plain_name(text, file_ + ": " + field);
  }

  void channels() const {
    const std::vector<std::string> rgb{"R", "G", "B"};
    require(session_.channels == rgb || session_.channels.size() == 1, "channels",
            "must be [\"R\", \"G\", \"B\"] or the name of one channel");
    for (std::size_t i = 0; i < session_.channels.size(); ++i) {
      name(session_.channels[i], indexed("channels", i));
    }
  }

  void sample() const {
    const Sample& sample = session_.sample;
    require(!sample.name.empty(), "sample.name", "is empty; give the sample a name");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      whole(sample.grid[axis], 1, largest_grid_extent, indexed("sample.grid", axis));
    }
    positive(sample.voxel_mm, "sample.voxel_mm", " of millimetres");
    require(sample.eta >= 1.0 && sample.eta <= 4.0, "sample.eta",
            "is " + shown(sample.eta) + "; a refractive index must lie between 1 and 4");
    const bool opposite_faces = sample.seen_face == opposite(sample.lit_face);
    if (session_.setup == Setup::back_lit) {
      require(opposite_faces, "sample.seen_face",
              "is '" + to_string(sample.seen_face) + "'; in a back-lit setup it is opposite to " +
                  "the lit face: write '" + to_string(opposite(sample.lit_face)) + "'");
    } else {
      require(sample.seen_face == sample.lit_face, "sample.seen_face",
              "is '" + to_string(sample.seen_face) +
                  "'; in a front-lit setup it is the lit face: " + "write '" +
                  to_string(sample.lit_face) + "'");
    }
  }

  void raw_layout(const Camera& camera, const io::RawLayout& layout) const {
    const std::string field = "camera.raw_layout";
    require(
        layout.bits == 8 || layout.bits == 16, field + ".bits",
        "is " + std::to_string(layout.bits) + "; a stored code has 8 or 16 bits: unpack the files");
    require(camera.bit_depth <= layout.bits, "camera.bit_depth",
            "is " + std::to_string(camera.bit_depth) + ", more than the " +
                std::to_string(layout.bits) + " bits of " + field);
    require(layout.offset >= 0, field + ".offset",
            "is " + std::to_string(layout.offset) + "; it must not be negative");
    require(session_.channels.size() == (layout.mosaic ? 3 : 1), "channels",
            layout.mosaic ? "must be [\"R\", \"G\", \"B\"] where " + field + " has a mosaic"
                          : "must be one where " + field + ".mosaic is 'none'");
    require(!layout.mosaic || (camera.width % 2 == 0 && camera.height % 2 == 0),
            "camera.width and height", "must be even where " + field + " has a mosaic");
  }

  void camera_and_projector() const {
    const Camera& camera = session_.camera;
    whole(camera.width, 1, largest_image_extent, "camera.width");
    whole(camera.height, 1, largest_image_extent, "camera.height");
    whole(camera.bit_depth, 8, 16, "camera.bit_depth");
    if (camera.white_level) {
      const int top = (1 << camera.bit_depth) - 1;
      whole(*camera.white_level, top / 4, top, "camera.white_level");
      require(camera.encoding == Encoding::linear, "camera.white_level",
              "is told although encoding is 'response'; it belongs to linear frames: leave it out");
    }
    if (camera.raw_layout) raw_layout(camera, *camera.raw_layout);
    if (camera.electrons_full_scale) {
      positive(*camera.electrons_full_scale, "camera.electrons_full_scale", " of electrons");
    }
    if (camera.read_noise_electrons) {
      const double noise = *camera.read_noise_electrons;
      require(std::isfinite(noise) && noise >= 0.0, "camera.read_noise_electrons",
              "is " + shown(noise) + "; it must not be negative");
    }
    whole(session_.projector.width, 1, largest_image_extent, "projector.width");
    whole(session_.projector.height, 1, largest_image_extent, "projector.height");
  }

  void stations() const {
    name(session_.calibration_station, "stations.calibration");
    name(session_.pattern_station, "stations.patterns");
    require(session_.setup == Setup::front_lit ||
                session_.calibration_station != session_.pattern_station,
            "stations.patterns",
            "is '" + session_.pattern_station +
                "' like stations.calibration; in a back-lit setup the camera sees the lit face " +
                "from one station and the patterns from another: give them two names");
  }

  void patterns() const {
    require(!session_.patterns.empty(), "patterns", "is empty; list at least one pattern");
    std::map<std::string, std::size_t> seen;
    bool any_fit = false;
    for (std::size_t i = 0; i < session_.patterns.size(); ++i) {
      const Pattern& pattern = session_.patterns[i];
      const std::string field = indexed("patterns", i);
      name(pattern.id, field + ".id");
      const auto [first, is_new] = seen.emplace(pattern.id, i);
      require(is_new, field + ".id",
              "is '" + pattern.id + "' like that of " + indexed("patterns", first->second) +
                  "; give every pattern its own id");
      relative_path(pattern.image, field + ".image");
      stack(pattern.frames, field + ".frames");
      any_fit |= pattern.role == PatternRole::fit;
    }
    require(any_fit, "patterns", "has no pattern of role 'fit'; the fit needs at least one");
  }

  void boards() const {
    const Calibration& calibration = session_.calibration;
    // Fewer than 3 × 3 inner corners leave the board's orientation to chance.
    whole(calibration.board.columns, 3, 1000, "calibration.board.columns");
    whole(calibration.board.rows, 3, 1000, "calibration.board.rows");
    positive(calibration.board.square_mm, "calibration.board.square_mm", " of millimetres");
    if (calibration.board.kind == BoardKind::charuco) markers(calibration.board);
    frames(calibration.camera_boards, "calibration.camera_boards");

    if (calibration.projected_board) projected_board(*calibration.projected_board);
    projector_planes();
  }

  void projected_board(const ProjectedBoard& projected) const {
    const std::string field = "calibration.projected_board";
    whole(projected.columns, 3, 1000, field + ".columns");
    whole(projected.rows, 3, 1000, field + ".rows");
    positive(projected.square_px, field + ".square_px", " of projector pixels");
    const std::array<int, 2> corners{projected.columns, projected.rows};
    const std::array<int, 2> extent{session_.projector.width, session_.projector.height};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double first = projected.origin_px[axis];
      const double last = first + projected.square_px * (corners[axis] - 1);
      require(first >= 0.0 && last <= extent[axis] - 1.0, indexed(field + ".origin_px", axis),
              "puts the inner corners from pixel " + shown(first) + " to " + shown(last) +
                  "; they must lie in the projector's " + std::to_string(extent[axis]) + " pixels");
    }
  }

  void projector_planes() const {
    const Calibration& calibration = session_.calibration;
    const std::string field = "calibration.projector_planes";
    require(!calibration.projector_planes.empty(), field, "is empty; list at least one plane");
    std::optional<std::size_t> without_board;
    std::optional<std::size_t> without_code;
    for (std::size_t i = 0; i < calibration.projector_planes.size(); ++i) {
      const std::string plane = indexed(field, i);
      frame(calibration.projector_planes[i].board, plane + ".board");
      if (const auto& projected = calibration.projector_planes[i].projected) {
        frame(*projected, plane + ".projected");
        require(calibration.projected_board.has_value(), "calibration.projected_board",
                "is missing although " + plane + ".projected shows one; tell its corners");
      } else {
        without_board = i;
      }
      if (!calibration.projector_planes[i].coded()) without_code = i;
      code_of(calibration.projector_planes[i], plane);
    }
    if (without_board && without_code) {
      fail(indexed(field, *without_board),
           "has no projected chessboard and " + indexed(field, *without_code) +
               " no code; all planes need 'projected', or all 'gray_code', 'phase_shift' or "
               "'correspondences'");
    }
  }

  void one_exposure(const std::vector<Frame>& code, const std::string& field) const {
    frames(code, field);
    for (const Frame& one : code) {
      require(one.exposure_s == code.front().exposure_s, field,
              "has exposure times of " + shown(code.front().exposure_s) + " s and " +
                  shown(one.exposure_s) + " s (" + one.file +
                  "); its frames are compared: take all at one exposure time");
    }
  }

  void code_of(const ProjectorPlane& plane, const std::string& field) const {
    if (const std::vector<Frame>& code = plane.gray_code; !code.empty()) {
      one_exposure(code, field + ".gray_code");
      const int needed = gray_code_frames(session_.projector);
      require(code.size() == static_cast<std::size_t>(needed), field + ".gray_code",
              "has " + std::to_string(code.size()) + " entries; the Gray code of a " +
                  std::to_string(session_.projector.width) + " x " +
                  std::to_string(session_.projector.height) + " projector has " +
                  std::to_string(needed) +
                  ": two for each bit of columns and rows, white and black");
    }
    if (!plane.correspondences.empty()) {
      relative_path(plane.correspondences, field + ".correspondences");
    }
    if (!plane.phase_shift.empty()) phase_shift(plane, field + ".phase_shift");
  }

  void phase_shift(const ProjectorPlane& plane, const std::string& field) const {
    std::array<double, 2> longest{};
    for (std::size_t i = 0; i < plane.phase_shift.size(); ++i) {
      const PhaseShift& set = plane.phase_shift[i];
      one_exposure(set.frames, indexed(field, i) + ".frames");
      require(
          set.frames.size() >= 3, indexed(field, i) + ".frames",
          "has " + std::to_string(set.frames.size()) + " entries; a phase takes at least three");
      positive(set.period_px, indexed(field, i) + ".period_px", " of pixels");
      double& so_far = longest[set.along == PhaseShift::Along::columns ? 0 : 1];
      so_far = std::max(so_far, set.period_px);
    }
    const std::array<int, 2> extent{session_.projector.width, session_.projector.height};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const std::string along = axis == 0 ? "columns" : "rows";
      require(longest[axis] > 0.0, field, "has no set along the " + along);
      require(longest[axis] >= extent[axis] || !plane.gray_code.empty(), field,
              "has no period along the " + along + " that spans the projector's " +
                  std::to_string(extent[axis]) +
                  " pixels, so that its periods cannot be told apart; add one, or a gray_code");
    }
  }

  void markers(const Board& board) const {
    positive(board.marker_mm, "calibration.board.marker_mm", " of millimetres");
    require(board.marker_mm < board.square_mm, "calibration.board.marker_mm",
            "is " + shown(board.marker_mm) + "; a marker must be smaller than its square of " +
                shown(board.square_mm) + " mm");
    const std::string field = "calibration.board.dictionary";
    std::string known;
    for (const MarkerDictionary& one : marker_dictionaries) {
      known += (known.empty() ? "" : ", ") + std::string(one.name);
    }
    const auto found =
        std::find_if(marker_dictionaries.begin(), marker_dictionaries.end(),
                     [&](const MarkerDictionary& one) { return one.name == board.dictionary; });
    require(found != marker_dictionaries.end(), field,
            "is '" + shown_name(board.dictionary) + "'; write one of " + known);
    const int needed = (board.columns + 1) * (board.rows + 1) / 2;
    require(needed <= found->markers, field,
            "is '" + shown_name(board.dictionary) + "', which has fewer than the " +
                std::to_string(needed) +
                " markers of this board; write the dictionary it was printed with");
  }

  void corners(const std::array<std::array<double, 2>, 4>& points, const std::string& field) const {
    const std::array<int, 2> extent{session_.camera.width, session_.camera.height};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        require(points[i][axis] >= -0.5 && points[i][axis] <= extent[axis] - 0.5,
                indexed(indexed(field, i), axis),
                "is " + shown(points[i][axis]) + "; it must lie in the camera's " +
                    std::to_string(extent[axis]) + " pixels");
      }
    }
  }

  void sample_views() const {
    std::set<std::string> seen;
    const auto& views = session_.calibration.sample_views;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const SampleView& view = views[i];
      const std::string field = indexed("calibration.sample_views", i);
      require(
          view.station == session_.calibration_station || view.station == session_.pattern_station,
          field + ".station",
          "is '" + view.station + "'; it must be one of those in stations ('" +
              session_.calibration_station + "', '" + session_.pattern_station + "')");
      require(seen.insert(view.station).second, field + ".station",
              "is '" + view.station + "' a second time; keep one view per station");
      const Face expected = view.station == session_.calibration_station
                                ? session_.sample.lit_face
                                : session_.sample.seen_face;
      require(view.face == expected, field + ".face",
              "is '" + to_string(view.face) + "'; station '" + view.station + "' sees '" +
                  to_string(expected) + "'");
      frame(view.frame, field + ".frame");
      if (view.corners_px) corners(*view.corners_px, field + ".corners_px");
    }
    for (const std::string& station : {session_.calibration_station, session_.pattern_station}) {
      require(seen.count(station) == 1, "calibration.sample_views",
              "has no view from station '" + station + "'; add a photograph of the sample from it");
    }
  }

  void targets() const {
    const Calibration& calibration = session_.calibration;
    frames(calibration.dark, "calibration.dark");
    if (calibration.white_target) white_target(*calibration.white_target);
    for (std::size_t i = 0; i < calibration.ambient.size(); ++i) {
      stack(calibration.ambient[i], indexed("calibration.ambient", i) + ".frames");
    }
    if (calibration.colour_chart) {
      stack(calibration.colour_chart->frames, "calibration.colour_chart.frames");
      if (calibration.colour_chart->corners_px) {
        corners(*calibration.colour_chart->corners_px, "calibration.colour_chart.corners_px");
      }
    }
  }

  void white_target(const WhiteTarget& target) const {
    const std::string field = "calibration.white_target";
    require(target.reflectance > 0.0 && target.reflectance <= 1.0, field + ".reflectance",
            "is " + shown(target.reflectance) + "; a reflectance must be above 0 and at most 1");
    stack(target.frames, field + ".frames");
    stack_if_any(target.off_frames, field + ".off_frames");
    levels(target.levels, field + ".levels");
    const bool ambient = !session_.calibration.ambient.empty();
    require(target.off_frames.empty() || ambient, "calibration.ambient",
            "is missing although white_target.off_frames tell of room light; photograph the sample "
            "with the projector off too");
    require(!target.off_frames.empty() || !ambient || target.black_frames.empty(),
            field + ".off_frames",
            "is missing although there is calibration.ambient; without it room light would count "
            "as the projector's black");
    stack_if_any(target.black_frames, field + ".black_frames");
  }

  void levels(const std::vector<ProjectorLevel>& list, const std::string& field) const {
    int previous = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string value = indexed(field, i) + ".value";
      whole(list[i].value, 1, 254, value);
      require(list[i].value > previous, value,
              "is " + std::to_string(list[i].value) + " after " + std::to_string(previous) +
                  "; list the values once each, rising");
      previous = list[i].value;
      stack(list[i].frames, indexed(field, i) + ".frames");
    }
  }

  const Session& session_;
  std::string file_;
};

}  // namespace

void validate(const Session& session) {
  Checker(session).run();
}

}  // namespace kappamu::capture

// What the photographs for calibration must fulfil, alone and together.
#include <algorithm>
#include <optional>
#include <set>

#include "capture/session/field_check.h"

namespace kappamu::capture {
namespace {

class CalibrationCheck : FieldCheck {
 public:
  explicit CalibrationCheck(const Session& session) : FieldCheck(session) {}

  void run() const {
    boards();
    sample_views();
    targets();
  }

 private:
  void boards() const {
    const Calibration& calibration = session_.calibration;
    // Fewer than 3 × 3 inner corners leave the board's orientation to chance.
    whole(calibration.board.columns, 3, 1000, "calibration.board.columns");
    whole(calibration.board.rows, 3, 1000, "calibration.board.rows");
    positive(calibration.board.square_mm, "calibration.board.square_mm", " of millimetres");
    if (calibration.board.kind == BoardKind::charuco) markers(calibration.board);
    frames(calibration.camera_boards, "calibration.camera_boards");
    if (calibration.lens) relative_path(calibration.lens->file, "calibration.lens.file");

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
                "is missing although " + plane + ".projected shows one; state its corners");
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
                  " pixels, so that its periods cannot be distinguished; add one, or a gray_code");
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
            "is missing although white_target.off_frames show room light; photograph the sample "
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
};

}  // namespace

void check_calibration(const Session& session) {
  CalibrationCheck(session).run();
}

}  // namespace kappamu::capture

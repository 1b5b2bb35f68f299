#include "calib/calibrate_lenses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <iterator>
#include <map>
#include <string>
#include <thread>

#include "calib/linear_frame.h"
#include "calib/projector/correspondences.h"
#include "calib/projector/gray_code.h"
#include "calib/projector/phase_shift.h"
#include "calib/projector/view_checks.h"
#include "calib/targets/chessboard.h"
#include "calib/targets/find_board.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/shown_text.h"

namespace kappamu::calib {
namespace {

/// What the photographs of boards show. A view without its board is left out, a plane without
/// either of its boards too; `without` names them.
struct SeenBoards {
  std::vector<BoardView> views;  ///< the last ones are the printed boards of `planes`
  std::vector<PlaneView> planes;
  std::vector<const capture::ProjectorPlane*> used;  ///< one per plane
  std::vector<std::string> without;
};

/// Whether photographs show a chessboard of another size than the stated one, told from the first
/// few. The detector takes parts of a board for boards, so that a larger one counts even where the
/// stated one was found.
class OtherSize {
 public:
  explicit OtherSize(const capture::Board& stated) : stated_(stated) {}

  /// Throws InputError where a second photograph shows the same other board.
  void look(const Image<float>& grey, const std::string& file, bool found) {
    constexpr int most_looks = 3;
    found_ = found_ || found;
    if (stated_.kind != capture::BoardKind::chessboard || ++(found ? with_ : without_) > most_looks)
      return;
    const auto size =
        other_chessboard(grey, stated_.columns, stated_.rows, found ? Sizes::larger : Sizes::all);
    if (!size) return;
    const auto [columns, rows] = *size;
    const auto [first, is_new] = first_with_.try_emplace(*size, file);
    if (is_new || (found_ && !contains(*size, {stated_.columns, stated_.rows}))) return;
    const auto extent = [](int wide, int high) {
      return std::to_string(wide) + " x " + std::to_string(high);
    };
    const bool squares =
        std::minmax({columns + 1, rows + 1}) == std::minmax({stated_.columns, stated_.rows});
    throw InputError(first->second + ", " + file + ": no chessboard of " +
                     extent(stated_.columns, stated_.rows) + " inner corners, but one of " +
                     extent(columns, rows) + (squares ? ", which has so many squares" : "") +
                     ": correct the board's columns and rows; they count the points where four "
                     "squares meet");
  }

 private:
  const capture::Board& stated_;
  std::map<std::array<int, 2>, std::string> first_with_;
  bool found_ = false;
  int with_ = 0;
  int without_ = 0;
};

/// What one place of the board shows: in its own photograph and, on a projector plane, in that of
/// the projected board.
struct FoundBoards {
  std::optional<BoardCorners> printed, projected;
  std::vector<std::string> without;  ///< sentences of those not found

  template <class Find>
  std::optional<BoardCorners> found(const Find& find) {
    try {
      return find();
    } catch (const InputError& error) {
      without.emplace_back(error.what());
      return std::nullopt;
    }
  }
};

/// work(k) for every k in [0, count), several at a time. What is thrown is the failure of the least
/// k, whichever came first.
template <class Work>
void for_photographs(int count, unsigned at_once, const Work& work) {
  std::vector<std::exception_ptr> failures(static_cast<std::size_t>(count));
  const auto caught = [&](int k) {
    try {
      work(k);
    } catch (...) {
      failures[static_cast<std::size_t>(k)] = std::current_exception();
    }
  };
  for_rows(count, caught, at_once);
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

/// The boards of all photographs, several photographs at a time: those of the camera's views, then
/// those of the planes.
std::vector<FoundBoards> search_boards(const capture::Session& session,
                                       const capture::Radiometry& radiometry,
                                       bool projected_boards) {
  const capture::Calibration& shots = session.calibration;
  const auto views = static_cast<int>(shots.camera_boards.size());
  const int count = views + static_cast<int>(shots.projector_planes.size());
  // A photograph takes 30 bytes a pixel while its board is found.
  constexpr double most_bytes = 1.5e9, bytes_a_pixel = 30.0;
  const double pixels = 1.0 * session.camera.width * session.camera.height;
  const auto at_once = static_cast<unsigned>(std::clamp(most_bytes / (bytes_a_pixel * pixels), 1.0,
                                                        std::thread::hardware_concurrency() + 1.0));
  const auto frame = [&](int n) -> const capture::Frame& {
    return n < views ? shots.camera_boards[static_cast<std::size_t>(n)]
                     : shots.projector_planes[static_cast<std::size_t>(n - views)].board;
  };
  std::vector<FoundBoards> all(static_cast<std::size_t>(count));
  OtherSize other(shots.board);
  const int batch = static_cast<int>(at_once);
  for (int first = 0; first < count; first += batch) {
    std::vector<Image<float>> greys(static_cast<std::size_t>(std::min(batch, count - first)));
    for_photographs(static_cast<int>(greys.size()), at_once, [&](int k) {
      Image<float>& grey = greys[static_cast<std::size_t>(k)];
      FoundBoards& found = all[static_cast<std::size_t>(first + k)];
      grey = load_linear(session, frame(first + k), radiometry);
      found.printed =
          found.found([&] { return find_board(grey, shots.board, frame(first + k).file); });
    });
    // In order: what is said of another size does not depend on the threads.
    for (std::size_t k = 0; k < greys.size(); ++k) {
      const int n = first + static_cast<int>(k);
      other.look(greys[k], frame(n).file, all[static_cast<std::size_t>(n)].printed.has_value());
    }
  }
  if (!projected_boards) return all;
  for_photographs(count - views, at_once, [&](int p) {
    const capture::Frame& projected =
        *shots.projector_planes[static_cast<std::size_t>(p)].projected;
    FoundBoards& found = all[static_cast<std::size_t>(views + p)];
    if (!found.printed) return;
    const Image<float> grey = load_linear(session, projected, radiometry);
    found.projected = found.found([&] {
      return find_projected_chessboard(grey, shots.projected_board->columns,
                                       shots.projected_board->rows, *found.printed, projected.file);
    });
  });
  return all;
}

SeenBoards find_boards(const capture::Session& session, const capture::Radiometry& radiometry,
                       bool projected_boards, std::size_t least) {
  const capture::Calibration& shots = session.calibration;
  const std::size_t from_planes = shots.camera_boards.size();
  SeenBoards seen;
  std::vector<FoundBoards> all = search_boards(session, radiometry, projected_boards);
  for (std::size_t n = 0; n < from_planes; ++n) {
    if (all[n].printed)
      seen.views.push_back({shots.camera_boards[n].file, std::move(*all[n].printed)});
  }
  // The planes' printed boards are seen through the same lens: they help it, too.
  std::vector<BoardView> of_planes;
  for (std::size_t p = 0; p < shots.projector_planes.size(); ++p) {
    const capture::ProjectorPlane& plane = shots.projector_planes[p];
    FoundBoards& found = all[from_planes + p];
    if (!found.printed) continue;
    PlaneView view{"", *found.printed, {}};
    BoardView board{plane.board.file, std::move(*found.printed)};
    if (projected_boards) {
      view.name = plane.projected->file;
      if (!found.projected) {
        seen.views.push_back(std::move(board));
        continue;
      }
      view.projected = std::move(*found.projected);
    }
    of_planes.push_back(std::move(board));
    seen.planes.push_back(std::move(view));
    seen.used.push_back(&plane);
  }
  for (FoundBoards& found : all) {
    std::move(found.without.begin(), found.without.end(), std::back_inserter(seen.without));
  }
  seen.views.insert(seen.views.end(), of_planes.begin(), of_planes.end());
  const std::size_t least_planes = std::min(least_views, shots.projector_planes.size());
  if (!seen.without.empty() && (seen.views.size() < least || seen.planes.size() < least_planes)) {
    const std::size_t more = seen.without.size() - 1;
    throw InputError(seen.without.front() +
                     (more > 0 ? " (" + std::to_string(more) + " more like it)" : ""));
  }
  return seen;
}

/// What a plane's code tells, by whatever code it has.
ProjectorMap read_code(const capture::Session& session, const capture::ProjectorPlane& plane,
                       const capture::Radiometry& radiometry) {
  if (!plane.correspondences.empty()) {
    return read_correspondences(session.folder / plane.correspondences, session.camera,
                                session.projector);
  }
  std::optional<ProjectorMap> map;
  if (!plane.gray_code.empty()) {
    map =
        decode_gray_code([&](std::size_t n) { return load_codes(session, plane.gray_code.at(n)); },
                         session.projector);
  }
  if (plane.phase_shift.empty()) return std::move(*map);
  std::vector<PhaseFrames> sets;
  for (const capture::PhaseShift& set : plane.phase_shift) {
    sets.push_back({set.along, set.period_px, set.frames.size(),
                    [&session, &radiometry, &frames = set.frames](std::size_t n) {
                      return load_linear(session, frames.at(n), radiometry);
                    }});
  }
  return decode_phase_shift(std::move(sets), session.projector, map);
}

std::string name_of_code(const capture::ProjectorPlane& plane) {
  if (!plane.correspondences.empty()) return plane.correspondences;
  return plane.gray_code.empty() ? plane.phase_shift.front().frames.front().file
                                 : plane.gray_code.front().file;
}

/// The planes with the points that their codes locate for projected corners.
std::vector<PlaneView> read_codes(const capture::Session& session,
                                  const capture::ProjectedBoard& lattice, const SeenBoards& boards,
                                  CalibrationResult& result) {
  constexpr int shown_px = 160;  // longest side of the quality map that is kept
  std::vector<PlaneView> planes = boards.planes;
  for (std::size_t p = 0; p < planes.size(); ++p) {
    const capture::ProjectorPlane& plane = *boards.used[p];
    const ProjectorMap map = read_code(session, plane, result.radiometry);
    planes[p].name = name_of_code(plane);
    planes[p].projected = points_on_plane(mapped_corners(map, lattice, planes[p].name),
                                          planes[p].printed, session.camera.width, planes[p].name);
    result.gray_code.push_back({planes[p].name, map.legible_share(),
                                static_cast<int>(planes[p].projected.pixels.size()),
                                block_means(map.quality, shown_px)});
  }
  return planes;
}

/// Warns where the views themselves ask for another lens.
void check_held(const KnownLens& known, const std::vector<BoardView>& views,
                const capture::Board& board, const CameraCalibration& camera, Stages& stages) {
  if (views.size() < least_views) return;
  const CameraCalibration own =
      calibrate_camera(views, board.square_mm, camera.lens.width, camera.lens.height);
  constexpr double suspicious = 1.5;
  constexpr double margin_px = 0.05;
  // Boards that are seen nearly from the front hide a wrong focal length in their distance.
  constexpr double significant = 5.0;
  constexpr double least_share = 0.01;
  const double off = std::abs(own.lens.fx - camera.lens.fx);
  const bool other_focus =
      off > significant * own.standard_deviation(0) && off > least_share * own.lens.fx;
  if (!other_focus && camera.rms_px <= suspicious * own.rms_px + margin_px) return;
  stages.warn(known.file.string() + ": the lens held leaves " +
              shown_number(camera.rms_px, "%.2f") + " px of the boards' corners, one fitted to " +
              "them (fx " + shown_number(own.lens.fx, "%.1f") + " for " +
              shown_number(camera.lens.fx, "%.1f") + ") " + shown_number(own.rms_px, "%.2f") +
              " px: was it found at another focus, zoom or picture size?");
}

}  // namespace

JointCalibration calibrate_lenses(const capture::Session& session, Stages& stages,
                                  CalibrationResult& result,
                                  const std::optional<KnownLens>& known) {
  JointCalibration joint;
  const capture::Calibration& shots = session.calibration;
  const auto all_planes = [&](const auto& have) {
    return std::all_of(shots.projector_planes.begin(), shots.projector_planes.end(), have);
  };
  const bool coded = all_planes([](const capture::ProjectorPlane& plane) { return plane.coded(); });
  const bool projected =
      all_planes([](const capture::ProjectorPlane& plane) { return plane.projected.has_value(); });
  SeenBoards boards;
  stages.run("camera", 0.3, [&] {
    const bool held = known && known->use == LensUse::held;
    if (known) require_size(*known, session.camera.width, session.camera.height);
    boards = find_boards(session, result.radiometry, projected, held ? 1 : least_views);
    for (const std::string& sentence : boards.without) {
      stages.warn(sentence + "; this view is left out.");
    }
    const std::vector<BoardView>& views = boards.views;
    if (std::any_of(views.begin(), views.end(),
                    [](const BoardView& view) { return view.corners.light_first; })) {
      stages.warn(
          "the ChArUco board begins with a light square, as OpenCV before 4.6 made them (legacy); "
          "its markers tell, and its corners are counted from marker 0 all the same.");
    }
    result.camera = calibrate_camera(views, shots.board.square_mm, session.camera.width,
                                     session.camera.height, std::nullopt, known);
    if (held) return check_held(*known, views, shots.board, result.camera, stages);
    for (const std::string& sentence : check_camera_views(views, result.camera)) {
      stages.warn(sentence);
    }
  });
  if (shots.projector_planes.empty()) return joint;
  stages.run("projector", 0.5, [&] {
    const std::vector<BoardView>& views = boards.views;
    const std::vector<PlaneView>& planes = boards.planes;
    for (const std::string& sentence : check_planes(planes)) stages.warn(sentence);
    const capture::ProjectedBoard shown =
        coded ? map_lattice(session.projector) : *shots.projected_board;
    const std::vector<PlaneView> seen = coded ? read_codes(session, shown, boards, result) : planes;
    result.projector = calibrate_projector(result.camera.lens, shots.board, shown, seen,
                                           session.projector.width, session.projector.height);
    joint = adjust_jointly({views, shots.board, shown, seen}, result.camera, result.projector);
    if (agrees(joint, result.camera)) {
      result.camera = joint.camera;
      result.projector = joint.projector;
    } else {
      stages.warn(
          "the projected corners contradict the printed boards, whose residual would rise "
          "from " +
          shown_number(result.camera.rms_px, "%.3f") + " to " +
          shown_number(joint.camera.rms_px, "%.3f") +
          " px: camera and projector are calibrated one after the other; check that the "
          "planes are flat beyond the printed board and did not move between their "
          "pictures.");
    }
    if (coded && projected) {
      result.gray_code_check_px =
          projected_board_rms(result.camera.lens, result.projector, *shots.projected_board, planes);
    }
  });
  constexpr double suspicious_rms_px = 1.0;
  if (result.camera.rms_px > suspicious_rms_px) {
    stages.warn("the camera's reprojection error is " + shown_number(result.camera.rms_px, "%.2f") +
                " px: look for a bent board or a blurred picture among the views with the largest "
                "error in calibration.json.");
  }
  if (result.gray_code_check_px.value_or(0.0) > suspicious_rms_px) {
    stages.warn("the projected chessboards lie " +
                shown_number(*result.gray_code_check_px, "%.2f") +
                " px (of the projector) from where the codes put them: check projected_board "
                "in session.json and that no plane moved between its pictures.");
  }
  if (result.projector.rms_px > suspicious_rms_px) {
    stages.warn("the projector's reprojection error is " +
                shown_number(result.projector.rms_px, "%.2f") +
                " px: check projected_board in session.json and that no plane moved between its "
                "pictures.");
  }
  return joint;
}

}  // namespace kappamu::calib

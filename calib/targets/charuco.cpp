#include "calib/targets/charuco.h"

#include <algorithm>
#include <cmath>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <set>
#include <utility>

#include "calib/targets/board_picture.h"
#include "calib/targets/corner_fit.h"
#include "core/error.h"
#include "core/numbers/median.h"

namespace kappamu::calib {
namespace {

constexpr std::size_t least_corners = 8;
constexpr std::size_t chance_markers = 3;  // seen where there are none, or of another dictionary

cv::Ptr<cv::aruco::Dictionary> dictionary_named(const std::string& name) {
  for (std::size_t k = 0; k < capture::marker_dictionaries.size(); ++k) {
    if (capture::marker_dictionaries[k].name == name) {
      return cv::aruco::getPredefinedDictionary(static_cast<int>(k));
    }
  }
  throw InputError("session.json: calibration.board.dictionary is '" + name +
                   "'; write one of OpenCV's, as DICT_4X4_50");
}

struct Markers {
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
};

Markers detect(const cv::Mat& bytes, const cv::Ptr<cv::aruco::Dictionary>& dictionary) {
  Markers markers;
  cv::aruco::detectMarkers(bytes, dictionary, markers.corners, markers.ids);
  return markers;
}

/// What the board's detection goes by.
struct SeenMarkers {
  ScaledPicture picture;  ///< of bytes
  Markers markers;        ///< in its pixels
};

/// On a reduced picture, and on the whole one where that does not show every marker: those of
/// 24 megapixels take a second each.
SeenMarkers search_markers(const Image<float>& grey, const capture::Board& board) {
  constexpr int searched_px = 1600;
  const auto dictionary = dictionary_named(board.dictionary);
  const auto search = [&](double factor) {
    ScaledPicture picture = scaled_bytes(grey, factor);
    Markers markers = detect(picture.pixels, dictionary);
    return SeenMarkers{std::move(picture), std::move(markers)};
  };
  const double factor = reduction(view_of(grey), searched_px);
  SeenMarkers seen = search(factor);
  const auto all = static_cast<std::size_t>((board.columns + 1) * (board.rows + 1) / 2);
  if (factor == 1.0 || seen.markers.ids.size() >= all) return seen;
  SeenMarkers whole = search(1.0);
  return whole.markers.ids.size() > seen.markers.ids.size() ? std::move(whole) : std::move(seen);
}

/// Whether the square at the top left is dark (OpenCV since 4.6) or, on boards of an even number of
/// rows of squares, light (before, and since 4.7 by setLegacyPattern).
enum class Layout { dark_first, light_first };

/// OpenCV's board for the layout. One whose first square is light is one of dark first square
/// without its first row: that row's markers and corners are counted and never seen.
struct Board {
  cv::Ptr<cv::aruco::CharucoBoard> board;
  int unseen_markers = 0;
  int unseen_rows = 0;

  Board(const capture::Board& stated, int columns, int rows, Layout layout)
      : unseen_markers(layout == Layout::light_first ? (columns + 1) / 2 : 0),
        unseen_rows(layout == Layout::light_first ? 1 : 0) {
    board = cv::aruco::CharucoBoard::create(
        columns + 1, rows + 1 + unseen_rows, static_cast<float>(stated.square_mm),
        static_cast<float>(stated.marker_mm), dictionary_named(stated.dictionary));
  }
};

/// Of the markers seen, how many lie where the board has them: within half a marker of one plane's
/// perspective view (lens distortion stays far below that).
std::size_t fitting(const Markers& markers, const Board& charuco) {
  std::vector<cv::Point2f> on_board;
  std::vector<cv::Point2f> seen;
  double side_px = 0.0;
  for (std::size_t k = 0; k < markers.ids.size(); ++k) {
    const auto id = static_cast<std::size_t>(markers.ids[k] + charuco.unseen_markers);
    if (id >= charuco.board->objPoints.size()) continue;
    side_px += cv::norm(markers.corners[k][0] - markers.corners[k][1]);
    for (std::size_t c = 0; c < 4; ++c) {
      const cv::Point3f& corner = charuco.board->objPoints[id][c];
      on_board.emplace_back(corner.x, corner.y);
      seen.push_back(markers.corners[k][c]);
    }
  }
  if (seen.empty()) return 0;
  const double tolerance = 0.5 * side_px / (static_cast<double>(seen.size()) / 4.0);
  std::vector<std::uint8_t> inliers;
  const cv::Mat found = cv::findHomography(on_board, seen, cv::RANSAC, tolerance, inliers);
  if (found.empty()) return 0;
  std::size_t count = 0;
  for (std::size_t k = 0; k + 4 <= inliers.size(); k += 4) {
    count += inliers[k] + inliers[k + 1] + inliers[k + 2] + inliers[k + 3] == 4 ? 1 : 0;
  }
  return count;
}

[[noreturn]] void explain_no_markers(const cv::Mat& bytes, const capture::Board& board,
                                     const std::string& name) {
  // Dictionaries of a thousand see markers in anything.
  const auto on_board = static_cast<std::size_t>((board.columns + 1) * (board.rows + 1) / 2);
  std::size_t most = std::max(chance_markers, on_board / 4);
  std::string other;
  for (const capture::MarkerDictionary& candidate : capture::marker_dictionaries) {
    const std::string dictionary(candidate.name);
    if (dictionary == board.dictionary) continue;
    // Of dictionaries that contain each other the smallest comes first and wins.
    const std::size_t count = detect(bytes, dictionary_named(dictionary)).ids.size();
    if (count > most) {
      most = count;
      other = dictionary;
    }
  }
  if (!other.empty()) {
    throw InputError(name + ": no marker of " + board.dictionary + " but " + std::to_string(most) +
                     " of " + other + ": correct the board's dictionary");
  }
  throw InputError(name +
                   ": no ArUco marker found; take the picture again with most of the ChArUco "
                   "board in view, sharp, evenly lit and not mirrored, or correct "
                   "what is stated of the board");
}

/// The layout that puts the markers right. Throws where none does, and says which number of columns
/// does.
Layout layout_of(const Markers& markers, const capture::Board& board, const std::string& name) {
  constexpr double most = 0.8;
  const auto needed = static_cast<std::size_t>(std::ceil(most * markers.ids.size()));
  const auto best = [&](int columns, int rows) {
    const std::size_t dark = fitting(markers, {board, columns, rows, Layout::dark_first});
    const bool even = (rows + 1) % 2 == 0;
    const std::size_t light =
        even ? fitting(markers, {board, columns, rows, Layout::light_first}) : 0;
    return std::pair(std::max(dark, light),
                     light > dark ? Layout::light_first : Layout::dark_first);
  };
  const auto [fits, layout] = best(board.columns, board.rows);
  if (fits >= needed) return layout;
  constexpr int widest = 30;
  for (int columns = 2; columns <= widest; ++columns) {
    // Rows enough for every number seen; markers per two rows of squares: columns + 1.
    const int last = *std::max_element(markers.ids.begin(), markers.ids.end());
    const int rows = std::max(2, 2 * (last / (columns + 1) + 1));
    for (const int tried : {rows, rows + 1}) {
      if (best(columns, tried).first < std::max<std::size_t>(needed, 3)) continue;
      throw InputError(name + ": its markers lie as on a board of " + std::to_string(columns) +
                       " inner corners per row" +
                       (columns == board.columns
                            ? " and more than " + std::to_string(board.rows) + " rows"
                            : ", not " + std::to_string(board.columns)) +
                       ": correct what is stated of the board");
    }
  }
  throw InputError(name + ": its " + std::to_string(markers.ids.size()) +
                   " markers do not lie as on a ChArUco board of " + std::to_string(board.columns) +
                   " x " + std::to_string(board.rows) +
                   " inner corners; correct what is stated of the board");
}

}  // namespace

BoardCorners find_charuco(const Image<float>& grey, const capture::Board& board,
                          const std::string& name) {
  check(grey.channels() == 1, "find_charuco wants a grey image");
  auto [picture, markers] = search_markers(grey, board);
  const cv::Mat& bytes = picture.pixels;
  if (markers.ids.size() <= chance_markers) explain_no_markers(bytes, board, name);
  const Layout layout = layout_of(markers, board, name);
  const Board charuco(board, board.columns, board.rows, layout);
  for (int& id : markers.ids) id += charuco.unseen_markers;
  cv::Mat points;
  cv::Mat ids;
  cv::aruco::interpolateCornersCharuco(markers.corners, markers.ids, bytes, charuco.board, points,
                                       ids);
  ids -= charuco.unseen_rows * board.columns;
  BoardCorners corners{board.columns, board.rows, {}};
  corners.light_first = layout == Layout::light_first;
  std::set<int> columns;
  std::set<int> rows;
  for (int k = 0; k < points.rows; ++k) {
    const auto& point = points.at<cv::Point2f>(k);
    corners.pixels.push_back(picture.in_original(point));
    corners.lattice.push_back(ids.at<int>(k));
    columns.insert(ids.at<int>(k) % board.columns);
    rows.insert(ids.at<int>(k) / board.columns);
  }
  if (corners.pixels.size() < least_corners || columns.size() < 2 || rows.size() < 2) {
    throw InputError(name + ": " + std::to_string(corners.pixels.size()) +
                     " corners of the ChArUco board are seen between its markers and at least " +
                     std::to_string(least_corners) +
                     " in two rows and columns are needed; take the picture again with more of the "
                     "board in view");
  }
  const double spacing = smallest_spacing(corners);
  // Up to the markers, whose edges would pull.
  const double margin = 0.5 * (1.0 - board.marker_mm / board.square_mm) * spacing;
  constexpr double blur_px = 1.0;
  refine_corners_from(picture.factor, grey, corners, (margin - blur_px) / spacing);
  std::vector<double> blurs;
  for (std::size_t k = 1; k < corners.pixels.size(); ++k) {
    const auto [i, j] = corners.place(k);
    if (corners.place(k - 1) != std::array<int, 2>{i - 1, j}) continue;
    const Eigen::Vector2d along = corners.pixels[k] - corners.pixels[k - 1];
    const Eigen::Vector2d middle = corners.pixels[k] - 0.5 * along;
    const Eigen::Vector2d across = margin * Eigen::Vector2d(along.y(), -along.x()).normalized();
    blurs.push_back(profile_blur(grey, middle - across, middle + across));
  }
  corners.blur_px = blurs.empty() ? 0.0 : upper_median(std::move(blurs));
  return corners;
}

MarkerCells marker_cells(const std::string& dictionary, int id) {
  const auto markers = dictionary_named(dictionary);
  MarkerCells cells;
  cells.side = markers->markerSize + 2;
  cv::Mat drawn;
  markers->drawMarker(id, cells.side, drawn, 1);
  for (int row = 0; row < cells.side; ++row) {
    for (int column = 0; column < cells.side; ++column) {
      cells.light.push_back(drawn.at<std::uint8_t>(row, column) > 127 ? 1 : 0);
    }
  }
  return cells;
}

}  // namespace kappamu::calib

#include "capture/import/photograph_session.h"

#include <algorithm>
#include <map>
#include <string>

#include "capture/session/frames.h"
#include "core/error.h"
#include "io/image/image_file.h"

namespace kappamu::capture {
namespace {

namespace fs = std::filesystem;

std::string inside(const Session& session, const Photograph& photograph) {
  return photograph.path.lexically_relative(session.folder).generic_string();
}

/// Camera and channels as the photograph that holds the largest codes has them.
void describe_camera(const fs::path& photograph, Session& session) {
  Camera& camera = session.camera;
  if (read_camera(photograph, camera) == 1) session.channels = {"Y"};
  const Frame frame{photograph.filename().string(), 1.0};
  if (is_raw_frame(session, frame) || is_float_frame(session, frame)) return;
  const Image<std::uint16_t> codes = io::read_code_image(photograph);
  const int largest = *std::max_element(codes.values().begin(), codes.values().end());
  camera.bit_depth = 8;
  while (largest > largest_code(camera)) ++camera.bit_depth;
}

/// By the number of their plane; shots of no plane are left.
struct PlanePhotographs {
  std::optional<Frame> board;
  std::map<int, Frame> gray_code;
};

bool is_plane_shot(const std::string& shot, int& plane, std::string& what) {
  int used = 0;
  if (std::sscanf(shot.c_str(), "plane_%d_%n", &plane, &used) != 1 || used == 0) return false;
  what = shot.substr(static_cast<std::size_t>(used));
  return true;
}

/// plane_<n>_correspondences.npy or .csv where the folder has it.
std::string correspondences_of(int number, const fs::path& folder) {
  for (const char* ending : {".npy", ".csv"}) {
    const std::string name = "plane_" + std::to_string(number) + "_correspondences" + ending;
    std::error_code ignored;
    if (fs::exists(folder / name, ignored)) return name;
  }
  return {};
}

std::vector<Frame> gray_code_of(const PlanePhotographs& plane, int number,
                                const Projector& projector, const fs::path& folder) {
  const int needed = gray_code_frames(projector);
  std::vector<Frame> code;
  for (int k = 0; k < needed; ++k) {
    const auto found = plane.gray_code.find(k);
    if (found == plane.gray_code.end()) {
      throw InputError(folder.string() + ": there is no photograph plane_" +
                       std::to_string(number) + "_gray_" + std::to_string(k) +
                       "; the Gray code of " + std::to_string(projector.width) + " x " +
                       std::to_string(projector.height) + " pixels has " + std::to_string(needed) +
                       " frames, from 0: add it, or correct the projector's size.");
    }
    code.push_back(found->second);
  }
  return code;
}

}  // namespace

Session bracket_session(const PhotographSource& source, Encoding encoding, Progress& progress) {
  std::vector<Photograph> photographs = find_photographs(source, progress);
  const auto is_dark = [](const Photograph& photograph) { return photograph.shot == "dark"; };
  Session session;
  session.folder = source.folder;
  session.camera.encoding = encoding;
  Pattern bracket;
  bracket.id = "bracket";
  std::vector<Photograph> lit;
  for (const Photograph& photograph : photographs) {
    if (is_dark(photograph)) {
      session.calibration.dark.push_back({inside(session, photograph), photograph.exposure_s});
    } else {
      lit.push_back(photograph);
    }
  }
  require_exposure_times(lit);
  check_settings(photographs);
  std::sort(lit.begin(), lit.end(), [](const Photograph& a, const Photograph& b) {
    return std::tie(a.exposure_s, a.path) < std::tie(b.exposure_s, b.path);
  });
  for (const Photograph& photograph : lit) {
    bracket.frames.push_back({inside(session, photograph), photograph.exposure_s});
  }
  if (bracket.frames.size() < 2) {
    throw InputError(source.folder.string() + ": holds " + std::to_string(bracket.frames.size()) +
                     " photographs of a scene; a bracket has at least two exposure times.");
  }
  const bool floats = is_float_frame(session, bracket.frames.back());
  for (const Frame& frame : bracket.frames) {
    if (is_float_frame(session, frame) == floats) continue;
    throw InputError((session.folder / frame.file).string() + ": holds " +
                     (floats ? "codes, and others of the bracket hold floats"
                             : "floats, and others of the bracket hold codes") +
                     "; save all photographs in one format.");
  }
  describe_camera(lit.back().path, session);
  settle_orientation(photographs, source.orientation, session.camera, progress);
  session.patterns.push_back(std::move(bracket));
  return session;
}

Session photograph_session(const fs::path& photograph, Encoding encoding) {
  Session session;
  session.folder = photograph.parent_path();
  session.camera.encoding = encoding;
  Pattern pattern;
  pattern.id = "photograph";
  pattern.frames = {{photograph.filename().string(), 1.0}};
  describe_camera(photograph, session);
  session.patterns.push_back(std::move(pattern));
  return session;
}

Session board_session(const PhotographSource& source, const Board& board,
                      const std::optional<Projector>& projector, Progress& progress) {
  std::vector<Photograph> photographs = find_photographs(source, progress);
  Session session;
  session.folder = source.folder;
  session.calibration.board = board;
  if (projector) session.projector = *projector;
  std::map<int, PlanePhotographs> planes;
  for (const Photograph& photograph : photographs) {
    const Frame frame{inside(session, photograph), photograph.exposure_s};
    int number = 0, k = 0;
    std::string what;
    if (!is_plane_shot(photograph.shot, number, what)) {
      session.calibration.camera_boards.push_back(frame);
    } else if (what == "board") {
      planes[number].board = frame;
    } else if (std::sscanf(what.c_str(), "gray_%d", &k) == 1) {
      planes[number].gray_code[k] = frame;
    } else {
      throw InputError(
          photograph.path.string() + ": '" + photograph.shot +
              "' is neither plane_<n>_board nor plane_<n>_gray_<k>; rename it, or list "
              "the right shot in a table",
          {{"table"}});
    }
  }
  for (const auto& [number, plane] : planes) {
    if (!projector) {
      throw InputError(source.folder.string() + ": holds photographs of projector plane " +
                           std::to_string(number) + "; give the projector's size",
                       {{"projector"}});
    }
    if (!plane.board) {
      throw InputError(source.folder.string() + ": there is no photograph plane_" +
                       std::to_string(number) + "_board of the printed board on that plane.");
    }
    ProjectorPlane& found = session.calibration.projector_planes.emplace_back();
    found.board = *plane.board;
    found.correspondences = correspondences_of(number, source.folder);
    if (found.correspondences.empty()) {
      found.gray_code = gray_code_of(plane, number, *projector, source.folder);
    }
  }
  describe_camera(photographs.front().path, session);
  settle_orientation(photographs, source.orientation, session.camera, progress);
  return session;
}

}  // namespace kappamu::capture

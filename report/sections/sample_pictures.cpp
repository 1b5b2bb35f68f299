// The sample in its photograph, with the grid drawn over it.
#include <algorithm>
#include <cmath>

#include "calib/sample/face.h"
#include "calib/targets/chessboard.h"
#include "capture/radiance/merge.h"
#include "capture/session/frames.h"
#include "core/error.h"
#include "core/numbers/region.h"
#include "report/drawing/picture.h"
#include "report/read/run_data.h"

namespace kappamu::report {

namespace {

using Colour = std::array<double, 3>;
constexpr Colour grid_colour{20, 100, 210};
constexpr Colour outline_colour{255, 140, 40};
constexpr Colour point_colour{220, 30, 60};

/// The part of the photograph around the face, enlarged.
struct Window {
  double left = 0.0, top = 0.0;  ///< [px of the photograph], of the window's first pixel's edge
  double scale = 1.0;            ///< pixels per pixel of the photograph
  int width = 0, height = 0;

  Eigen::Vector2d place(const Eigen::Vector2d& pixel) const {
    return {(pixel.x() + 0.5 - left) * scale - 0.5, (pixel.y() + 0.5 - top) * scale - 0.5};
  }
};

Window around(const std::array<Eigen::Vector2d, 4>& corners, int width, int height) {
  Eigen::Vector2d low = corners[0], high = corners[0];
  for (const Eigen::Vector2d& corner : corners) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  constexpr double margin = 0.12;
  constexpr double wanted_width = 560.0;  // shown pixel by pixel, so that no line is lost
  const Eigen::Vector2d extra = margin * (high - low);
  low = (low - extra).cwiseMax(Eigen::Vector2d::Zero());
  high = (high + extra).cwiseMin(Eigen::Vector2d(width, height));
  Window window;
  window.left = low.x();
  window.top = low.y();
  window.scale = std::clamp(wanted_width / (high.x() - low.x()), 0.25, 6.0);
  window.width = std::max(1, static_cast<int>((high.x() - low.x()) * window.scale));
  window.height = std::max(1, static_cast<int>((high.y() - low.y()) * window.scale));
  return window;
}

/// Part of the photograph in grey, as shown; code values of a response are near what a screen
/// wants.
Image<float> photograph(const capture::Session& session, const capture::Frame& frame,
                        const Region& part) {
  Image<float> image;
  if (capture::is_float_frame(session, frame)) {
    image = capture::load_float_frame(session, frame, part);
  } else {
    const Image<std::uint16_t> codes = capture::load_frame(session, frame, part);
    image = Image<float>(codes.width(), codes.height(), codes.channels());
    std::transform(codes.values().begin(), codes.values().end(), image.values().begin(),
                   [](std::uint16_t code) { return static_cast<float>(code); });
  }
  image = calib::to_grey(image);
  const auto white = static_cast<float>(std::max(1e-12, quantile(image.values(), 0.998)));
  const bool linear = session.camera.encoding == capture::Encoding::linear;
  for (float& value : image.values()) {
    value = std::clamp(value / white, 0.0F, 1.0F);
    if (linear) value = std::sqrt(value);
  }
  return image;
}

void blend(Image<std::uint8_t>& image, const Eigen::Vector2d& at, const Colour& colour,
           double amount) {
  const int x = static_cast<int>(std::lround(at.x()));
  const int y = static_cast<int>(std::lround(at.y()));
  if (x < 0 || y < 0 || x >= image.width() || y >= image.height()) return;
  for (int c = 0; c < 3; ++c) {
    image(x, y, c) = static_cast<std::uint8_t>(std::lround(
        (1.0 - amount) * image(x, y, c) + amount * colour[static_cast<std::size_t>(c)]));
  }
}

Image<std::uint8_t> enlarged(const Image<float>& photo, const Region& part, const Window& window) {
  Image<std::uint8_t> image(window.width, window.height, 3);
  for (int y = 0; y < window.height; ++y) {
    for (int x = 0; x < window.width; ++x) {
      const int px =
          std::clamp(static_cast<int>(window.left + (x + 0.5) / window.scale) - part.left, 0,
                     photo.width() - 1);
      const int py = std::clamp(static_cast<int>(window.top + (y + 0.5) / window.scale) - part.top,
                                0, photo.height() - 1);
      for (int c = 0; c < 3; ++c) {
        image(x, y, c) = static_cast<std::uint8_t>(std::lround(255.0F * photo(px, py)));
      }
    }
  }
  return image;
}

Image<std::uint8_t> with_grid(const capture::Session& session, const capture::Frame& frame,
                              const calib::Lens& lens, const calib::SamplePose& pose) {
  const Window window = around(pose.corners_px, lens.width, lens.height);
  Surrounding shown;
  shown.add(window.left, window.top);
  shown.add(window.left + window.width / window.scale, window.top + window.height / window.scale);
  const Region part = shown.region(0.0, 1.0, capture::merged_grid_px, lens.width, lens.height);
  Image<std::uint8_t> image = enlarged(photograph(session, frame, part), part, window);
  const GridShape grid = session.sample.shape();
  const FaceShape face = face_shape(grid, pose.face);
  const auto draw = [&](double u0, double v0, double u1, double v1, const Colour& colour,
                        double amount, int thick) {
    const auto at = [&](double t) {
      return window.place(
          lens.project(pose.camera_from_sample *
                       calib::face_point(grid, pose.face, u0 + t * (u1 - u0), v0 + t * (v1 - v0))));
    };
    const int steps = std::max(2, static_cast<int>((at(1.0) - at(0.0)).norm()));
    for (int k = 0; k <= steps; ++k) {
      for (int d = 0; d < thick; ++d) {
        blend(image, at(static_cast<double>(k) / steps) + Eigen::Vector2d(d, d), colour, amount);
      }
    }
  };
  // Lines no closer than this would hide the photograph.
  constexpr double closest = 12.0;
  const double pitch =
      (window.place(pose.corners_px[1]) - window.place(pose.corners_px[0])).norm() / face.nu;
  const int stride = std::max(1, static_cast<int>(std::ceil(closest / std::max(pitch, 1e-6))));
  for (int u = stride; u < face.nu; u += stride) draw(u, 0, u, face.nv, grid_colour, 0.55, 1);
  for (int v = stride; v < face.nv; v += stride) draw(0, v, face.nu, v, grid_colour, 0.55, 1);
  draw(0, 0, face.nu, 0, outline_colour, 0.9, 2);
  draw(0, face.nv, face.nu, face.nv, outline_colour, 0.9, 2);
  draw(0, 0, 0, face.nv, outline_colour, 0.9, 2);
  draw(face.nu, 0, face.nu, face.nv, outline_colour, 0.9, 2);
  for (std::size_t k = 0; k < pose.edge_px.size(); k += 4) {
    const Eigen::Vector2d at = window.place(pose.edge_px[k]);
    for (int d = -1; d <= 1; ++d) {
      blend(image, at + Eigen::Vector2d(d, 0), point_colour, 0.9);
      blend(image, at + Eigen::Vector2d(0, d), point_colour, 0.9);
    }
  }
  return image;
}

}  // namespace

std::vector<SamplePicture> sample_pictures(const capture::Session& session,
                                           const calib::CalibrationResult& calibration) {
  std::vector<SamplePicture> pictures;
  for (const calib::SamplePose& pose : {calibration.calibration_pose, calibration.pattern_pose}) {
    for (const capture::SampleView& view : session.calibration.sample_views) {
      if (view.station != pose.station || view.face != pose.face) continue;
      const bool shown = std::any_of(pictures.begin(), pictures.end(), [&](const SamplePicture& p) {
        return p.station == view.station && p.face == to_string(view.face);
      });
      if (shown) continue;
      try {
        pictures.push_back({view.station, to_string(view.face),
                            with_grid(session, view.frame, calibration.camera.lens, pose)});
      } catch (const InputError&) {
        // The photograph may have been moved away since; the page does without.
        continue;
      }
    }
  }
  return pictures;
}

}  // namespace kappamu::report

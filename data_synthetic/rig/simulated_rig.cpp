#include "data_synthetic/rig/simulated_rig.h"

#include <algorithm>
#include <numbers>
#include <tuple>

#include "core/error.h"
#include "core/parallel.h"
#include "data_synthetic/rig/targets.h"

namespace kappamu::synthetic {

using capture::Subject;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double sample_reflectance = 0.8;      // of the sample's faces in even room light
constexpr double paper_signal = 0.7;            // full scales of white paper in room light
constexpr double brightest_signal = 2.0 / 3.0;  // full scales of the brightest scattered light
/// Cells that get more than this irradiance count as lit when the gain is chosen.
constexpr double lit_threshold = 0.02;
constexpr int irradiance_samples = 4;  // per side of a transport cell
/// Of the surface's reflectance: amplitude over mean, and the channels' shares.
constexpr double reflectance_wave = 0.6;
constexpr std::array<double, 3> reflectance_colour{1.0, 0.8, 0.6};

Image<float> as_float(const Image<std::uint8_t>& image) {
  Image<float> out(image.width(), image.height(), 1);
  for (std::size_t i = 0; i < image.size(); ++i) {
    out.values()[i] = static_cast<float>(image.values()[i] / 255.0);
  }
  return out;
}

/// Images that light up the same pixels are the same light.
std::string key_of_image(const Image<std::uint8_t>& image) {
  return {image.values().begin(), image.values().end()};
}

}  // namespace

SimulatedRig::SimulatedRig(const SimulationOptions& options, const std::string& device)
    : options_(options) {
  validate(options);
  rig_ = make_rig(options);
  const GridShape fine = rig_.sample.grid.refined(options.refinement);
  transport_ = std::make_unique<Transport>(
      Block{.shape = fine, .eta = rig_.sample.eta, .lit_face = rig_.sample.lit_face()}, device,
      TransportChoice{options.transport, options.photons, options.seed, options.anisotropy});
  media_ = sample_medium(rig_.sample, fine);
}

capture::Camera SimulatedRig::camera() const {
  capture::Camera camera;
  camera.width = rig_.camera_lens.width;
  camera.height = rig_.camera_lens.height;
  camera.bit_depth = rig_.sensor.bit_depth;
  camera.encoding = rig_.sensor.encoding;
  camera.electrons_full_scale = rig_.sensor.effective_electrons();
  camera.read_noise_electrons = rig_.sensor.effective_read_noise();
  return camera;
}

capture::Projector SimulatedRig::projector() const {
  return rig_.projector_size;
}

void SimulatedRig::place(const capture::Scene& scene) {
  if (rig_.world_from_camera.count(scene.station) == 0) {
    throw InputError("the simulated rig has no camera station \"" + scene.station +
                     "\": use \"front\", \"side\" or \"back\"");
  }
  scene_ = scene;
  shown_ = Image<std::uint8_t>(rig_.projector_size.width, rig_.projector_size.height, 1);
  picture_.reset();
}

void SimulatedRig::show(const Image<std::uint8_t>& image) {
  if (image.width() != rig_.projector_size.width || image.height() != rig_.projector_size.height ||
      image.channels() != 1) {
    throw InputError("the simulated projector shows grey images of " +
                     std::to_string(rig_.projector_size.width) + " x " +
                     std::to_string(rig_.projector_size.height) + " pixels");
  }
  shown_ = image;
  if (scene_.subject == Subject::sample && scene_.lighting != capture::Lighting::room)
    ++patterns_shown_;
  picture_.reset();
}

Image<std::uint16_t> SimulatedRig::expose(double exposure_s) {
  if (!picture_) picture_ = picture();
  return synthetic::expose(rig_.sensor, *picture_, exposure_s, frames_++);
}

std::vector<double> SimulatedRig::lit_face_irradiance(const Image<std::uint8_t>& image) const {
  const Image<float> thrown = thrown_image(rig_.projector, as_float(image));
  const GridShape& fine = transport_->block().shape;
  const FaceShape face = face_shape(fine, rig_.sample.lit_face());
  const Vector3d normal = -rig_.world_from_sample.rotation.col(2);
  std::vector<double> irradiance(face.cells());
  for_rows(face.nv, [&](int v) {
    for (int u = 0; u < face.nu; ++u) {
      double sum = 0.0;
      for (int n = 0; n < irradiance_samples * irradiance_samples; ++n) {
        const int row = n / irradiance_samples;
        const int column = n % irradiance_samples;
        const double x = u + (column + 0.5) / irradiance_samples;
        const double y = v + (row + 0.5) / irradiance_samples;
        const ProjectorSample sample = sample_projector(
            rig_.projector, rig_.world_from_sample * (fine.voxel_mm * Vector3d(x, y, 0.0)), normal);
        if (sample.white > 0.0) sum += sample.white * thrown_value(thrown, sample.pixel);
      }
      irradiance[static_cast<std::size_t>(v) * face.nu + u] =
          sum / (irradiance_samples * irradiance_samples);
    }
  });
  return irradiance;
}

void SimulatedRig::solve(const std::vector<Image<std::uint8_t>>& images, Progress& progress) {
  std::vector<double> irradiance;
  for (const Image<std::uint8_t>& image : images) {
    const std::vector<double> one = lit_face_irradiance(image);
    irradiance.insert(irradiance.end(), one.begin(), one.end());
  }
  const std::size_t cells = face_shape(transport_->block().shape, rig_.sample.seen_face()).cells();
  for (const Face face : photographed()) {
    for (const Image<std::uint8_t>& image : images)
      solved_[{key_of_image(image), face}].resize(media_.size());
    for (std::size_t c = 0; c < media_.size(); ++c) {
      transport_->set_medium(media_[c]);
      const std::vector<double> maps = transport_->exitance(irradiance, face, [&](double fraction) {
        progress.update("light transport", (c + fraction) / static_cast<double>(media_.size()),
                        std::to_string(images.size()) + " patterns");
      });
      for (std::size_t m = 0; m < images.size(); ++m) {
        const auto first = maps.begin() + static_cast<std::ptrdiff_t>(m * cells);
        solved_[{key_of_image(images[m]), face}][c].assign(
            first, first + static_cast<std::ptrdiff_t>(cells));
      }
    }
  }
}

std::vector<Face> SimulatedRig::photographed() const {
  if (options_.both_faces && rig_.sample.seen_face() != rig_.sample.lit_face()) {
    return {rig_.sample.seen_face(), rig_.sample.lit_face()};
  }
  return {rig_.sample.seen_face()};
}

void SimulatedRig::prepare(const std::vector<Image<std::uint8_t>>& images, Progress& progress) {
  if (!transport_->warning().empty()) progress.warn(transport_->warning());
  solve(images, progress);
  double brightest = 0.0;
  const double per_exitance = radiance_per_exitance(transport_->constants(), 1.0);
  const auto most = static_cast<std::size_t>(
      std::max_element(rig_.responsivity.begin(), rig_.responsivity.end()) -
      rig_.responsivity.begin());
  const auto look_at = [&](const Image<std::uint8_t>& image, Face face) {
    // Sinusoids light all of the face, and it is the lit pixels that are measured; so it is where
    // the surface reflects.
    const bool reflects = options_.surface_reflectance > 0.0;
    const bool lit_is_seen = face == rig_.sample.lit_face() &&
                             (reflects || options_.light.shape != capture::LightShape::sinusoids);
    const std::vector<double> light =
        lit_is_seen ? lit_face_irradiance(image) : std::vector<double>{};
    const double most_reflected =
        (1.0 + reflectance_wave) * options_.surface_reflectance / std::numbers::pi;
    const ExitanceMaps& maps = exitance(image, face);
    for (std::size_t c = 0; c < maps.size(); ++c) {
      const double relative = rig_.responsivity[c] / rig_.responsivity[most];
      for (std::size_t i = 0; i < maps[c].size(); ++i) {
        if (lit_is_seen && !reflects && light[i] > lit_threshold) continue;
        const double surface = lit_is_seen ? most_reflected * light[i] : 0.0;
        brightest = std::max(brightest, relative * (per_exitance * maps[c][i] + surface));
      }
    }
  };
  for (const Image<std::uint8_t>& image : images) {
    for (const Face face : photographed()) look_at(image, face);
  }
  check(brightest > 0.0, "some light comes through the sample");
  choose_gain(rig_, brightest, options_.exposures_s.front() / brightest_signal);
  const double room_exposure_s =
      options_.exposures_s[std::min<std::size_t>(1, options_.exposures_s.size() - 1)];
  ambient_ = paper_signal * std::numbers::pi /
             (paper_reflectance * rig_.responsivity[most] * room_exposure_s);
}

const SimulatedRig::ExitanceMaps& SimulatedRig::exitance(const Image<std::uint8_t>& image,
                                                         Face face) const {
  const auto found = solved_.find({key_of_image(image), face});
  check(found != solved_.end(), "light transport was solved for the image shown");
  return found->second;
}

const RayTable& SimulatedRig::rays() {
  if (!rays_) rays_ = std::make_unique<RayTable>(rig_.camera_lens, options_.rays_per_side);
  return *rays_;
}

Image<float> SimulatedRig::to_full_scales(Image<float> radiance) const {
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    radiance.values()[i] = static_cast<float>(radiance.values()[i] * rig_.responsivity[i % 3]);
  }
  return radiance;
}

Image<float> SimulatedRig::sample_radiance(const Image<std::uint8_t>& image, bool lit_face) {
  const Face face = lit_face ? rig_.sample.lit_face() : rig_.sample.seen_face();
  if (solved_.count({key_of_image(image), face}) == 0) {
    Progress silent;
    solve({image}, silent);
  }
  const std::string station = lit_face ? front_station : rig_.pattern_station();
  if (!face_views_.contains(station)) {
    face_views_.emplace(
        std::piecewise_construct, std::tuple(station),
        std::forward_as_tuple(rays(), rig_.world_from_camera.at(station), rig_.world_from_sample,
                              transport_->block().shape, face, transport_->constants()));
  }
  Image<float> radiance = face_views_.at(station).radiance(exitance(image, face));
  if (face == rig_.sample.lit_face() && options_.surface_reflectance > 0.0) {
    const Image<float> surface = reflected(image, station);
    for (std::size_t i = 0; i < radiance.size(); ++i) radiance.values()[i] += surface.values()[i];
  }
  return to_full_scales(std::move(radiance));
}

std::array<double, 3> SimulatedRig::surface_reflectance(const Vector2d& at_mm) const {
  const GridShape& grid = rig_.sample.grid;
  const Vector2d at =
      2.0 * std::numbers::pi / grid.voxel_mm * at_mm.cwiseQuotient(Vector2d(grid.nx, grid.ny));
  const double here = options_.surface_reflectance *
                      (1.0 + reflectance_wave * std::sin(2.0 * at.x()) * std::cos(3.0 * at.y()));
  std::array<double, 3> of{};
  for (std::size_t c = 0; c < of.size(); ++c) of[c] = reflectance_colour[c] * here;
  return of;
}

Image<float> SimulatedRig::reflected(const Image<std::uint8_t>& image, const std::string& station) {
  const GridShape& grid = rig_.sample.grid;
  const Image<float> thrown = thrown_image(rig_.projector, as_float(image));
  const Quad face{rig_.world_from_sample, Vector2d::Zero(),
                  grid.voxel_mm * Vector2d(grid.nx, grid.ny),
                  [this](const Vector2d& at, const Vector2d&) { return surface_reflectance(at); }};
  return render_quads(rays(), rig_.world_from_camera.at(station), {face},
                      {.projector = &rig_.projector, .thrown = &thrown});
}

double SimulatedRig::white_exposure_s(double signal) const {
  const double most = *std::max_element(rig_.responsivity.begin(), rig_.responsivity.end());
  return signal * std::numbers::pi / (white_target_reflectance * most);
}

Image<float> SimulatedRig::picture() {
  check(ambient_ > 0.0, "the rig was prepared before its first exposure");
  if (scene_.subject == Subject::lens_covered) {
    return Image<float>(rig_.camera_lens.width, rig_.camera_lens.height, 3);
  }
  Illumination light;
  light.ambient = scene_.lighting == capture::Lighting::room ? ambient_ : room_light();
  Rigid world_from_camera = rig_.world_from_camera.at(scene_.station);
  std::vector<Quad> quads;
  const Image<float> thrown = thrown_image(rig_.projector, as_float(shown_));
  light.projector = scene_.lighting == capture::Lighting::none ? nullptr : &rig_.projector;
  light.thrown = &thrown;
  const double s = rig_.size_mm;
  const GridShape& grid = rig_.sample.grid;
  const Vector2d face_mm(grid.nx * grid.voxel_mm, grid.ny * grid.voxel_mm);
  switch (scene_.subject) {
    case Subject::board:  // held by hand before the camera, away from the projector
      check(scene_.pose < static_cast<int>(rig_.camera_from_board.size()),
            "the board's pose exists");
      quads.push_back(board_quad(rig_.board, rig_.camera_from_board[scene_.pose]));
      world_from_camera = Rigid{};
      light.projector = nullptr;
      break;
    case Subject::plane: {
      check(scene_.pose < static_cast<int>(rig_.world_from_plane.size()),
            "the plane's pose exists");
      const Rigid& world_from_plane = rig_.world_from_plane[scene_.pose];
      quads.push_back(board_quad(rig_.board, world_from_plane * rig_.plane_from_board));
      quads.push_back(plain_quad({6.0 * s, 6.0 * s}, paper_reflectance, world_from_plane));
      break;
    }
    case Subject::white_target:
      // Covers lit face and chart, so that it tells the irradiance on both.
      quads.push_back(
          plain_quad({1.8 * s, 1.35 * s}, white_target_reflectance, rig_.world_from_target()));
      break;
    case Subject::colour_chart:
      quads.push_back(chart_quad(1.6 * s, rig_.world_from_target()));
      break;
    case Subject::sample: {
      if (scene_.lighting != capture::Lighting::room && !options_.both_faces &&
          scene_.station != rig_.pattern_station()) {
        throw InputError("the simulated sample's patterns are seen from station \"" +
                         rig_.pattern_station() + "\" only");
      }
      if (scene_.lighting != capture::Lighting::room && light.ambient == 0.0 &&
          scene_.lighting != capture::Lighting::none) {
        return sample_radiance(shown_, scene_.station != rig_.pattern_station());
      }
      Rigid sample_from_face{Eigen::Matrix3d::Identity(),
                             {0.5 * face_mm.x(), 0.5 * face_mm.y(), 0.0}};
      if (scene_.station == back_station) {
        sample_from_face.rotation.diagonal() << -1.0, 1.0, -1.0;
        sample_from_face.translation.z() = grid.nz * grid.voxel_mm;
      }
      quads.push_back(
          plain_quad(face_mm, sample_reflectance, rig_.world_from_sample * sample_from_face));
      light.projector = nullptr;
      break;
    }
    case Subject::lens_covered:
      break;
  }
  Image<float> picture = to_full_scales(render_quads(rays(), world_from_camera, quads, light));
  if (scene_.subject == Subject::sample && scene_.lighting == capture::Lighting::projector) {
    const Image<float> through = sample_radiance(shown_);
    for (std::size_t i = 0; i < picture.size(); ++i) picture.values()[i] += through.values()[i];
  }
  return picture;
}

double SimulatedRig::room_light() const {
  if (scene_.subject != Subject::sample) return options_.room_light;
  const auto solved = static_cast<double>(solved_.size() / photographed().size());
  const double patterns = std::max(1.0, solved - 1.0);
  const double share = scene_.lighting == capture::Lighting::none
                           ? scene_.pose
                           : std::clamp((patterns_shown_ - 1) / patterns, 0.0, 1.0);
  return options_.room_light * (1.0 + options_.room_change * share);
}

}  // namespace kappamu::synthetic

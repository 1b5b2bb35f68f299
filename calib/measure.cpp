#include "calib/measure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "calib/light/irradiance.h"
#include "calib/sample/footprint.h"
#include "calib/sample/surroundings.h"
#include "capture/session/frames.h"
#include "core/error.h"
#include "core/optics.h"
#include "core/parallel.h"

namespace kappamu::calib {
namespace {

/// Tells of patterns whose light hangs on a response that nobody measured.
class ValueCheck {
 public:
  void look_at(const capture::Pattern& pattern, const Image<std::uint16_t>& image,
               const LitFace& lit, const std::vector<float>& proportional) {
    if (std::all_of(image.values().begin(), image.values().end(),
                    [](std::uint16_t value) { return value == 0 || value == 255; })) {
      return;
    }
    const std::vector<float> other = lit.irradiance(image, power_table(usual_exponent));
    double difference = 0.0;
    double total = 0.0;
    for (std::size_t k = 0; k < other.size(); ++k) {
      difference += std::abs(other[k] - proportional[k]);
      total += proportional[k];
    }
    if (!(total > 0.0) || difference / total < worth_telling) return;
    ++patterns_;
    if (difference / total <= worst_) return;
    worst_ = difference / total;
    file_ = pattern.image;
  }
  void tell(Progress& progress) const {
    if (patterns_ == 0) return;
    progress.warn(
        file_ +
        (patterns_ > 1 ? " and " + std::to_string(patterns_ - 1) + " more patterns have" : " has") +
        " values between black and white, and how the projector's light grows with them is not "
        "measured: it is taken as proportional, and were it the power of 2.2 of most projectors, "
        "this pattern's would be wrong by " +
        std::to_string(std::lround(100.0 * worst_)) +
        " %; photograph the white target under several values (white_target.levels), or show black "
        "and white only.");
  }

 private:
  static constexpr double usual_exponent = 2.2;
  static constexpr double worth_telling = 0.01;  // of a pattern's light on the face
  int patterns_ = 0;
  double worst_ = 0.0;
  std::string file_;
};

/// Voxels lit above the threshold and the eight around each.
std::vector<std::uint8_t> lit_voxels(const float* irradiance, const FaceShape& shape,
                                     double threshold) {
  std::vector<std::uint8_t> lit(shape.cells(), 0);
  for (int v = 0; v < shape.nv; ++v) {
    for (int u = 0; u < shape.nu; ++u) {
      if (irradiance[static_cast<std::size_t>(v) * shape.nu + u] <= threshold) continue;
      for (int dv = std::max(0, v - 1); dv <= std::min(shape.nv - 1, v + 1); ++dv) {
        for (int du = std::max(0, u - 1); du <= std::min(shape.nu - 1, u + 1); ++du) {
          lit[static_cast<std::size_t>(dv) * shape.nu + du] = 1;
        }
      }
    }
  }
  return lit;
}

/// Where the footprints' pixels lie in a picture that may be a part of the camera's; throws
/// InternalError where one lies beyond it.
std::vector<std::uint32_t> pixels_in(const Region& part, const Footprints& footprints,
                                     int camera_width) {
  std::vector<std::uint32_t> places(footprints.pixel.size());
  bool inside = true;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const int x = static_cast<int>(footprints.pixel[k] % static_cast<unsigned>(camera_width));
    const int y = static_cast<int>(footprints.pixel[k] / static_cast<unsigned>(camera_width));
    inside = inside && x >= part.left && x < part.right() && y >= part.top && y < part.bottom();
    places[k] = static_cast<std::uint32_t>((y - part.top) * part.width + x - part.left);
  }
  check(inside, "the HDR pictures show all of the measured face");
  return places;
}

/// Where the values of the first channel of one picture go [v][u], those of the next `step` behind.
struct Target {
  float* value;
  float* variance;
  std::uint8_t* mask;
  std::size_t step;
};

/// Over the pixels of a voxel.
struct Sums {
  double value = 0.0, variance = 0.0;
  std::uint8_t flags = 0;
};

/// Of channels [first, first + together): the picture comes from memory once for all of them, and
/// their sums stay in registers.
template <std::size_t together>
std::array<Sums, together> sums_of(const capture::HdrImage& picture, std::size_t first,
                                   const Footprints& footprints,
                                   const std::vector<std::uint32_t>& pixels, std::size_t voxel) {
  const auto channels = static_cast<std::size_t>(picture.radiance.channels());
  const float* const radiance = picture.radiance.values().data() + first;
  const float* const variance = picture.variance.values().data() + first;
  const std::uint8_t* const flags = picture.flags.values().data() + first;
  std::array<Sums, together> sums{};
  for (std::size_t k = footprints.begin[voxel]; k < footprints.begin[voxel + 1]; ++k) {
    const std::size_t at = pixels[k] * channels;
    const double weight = footprints.weight[k];
    for (std::size_t c = 0; c < together; ++c) {
      sums[c].value += weight * radiance[at + c];
      sums[c].variance += weight * weight * variance[at + c];
      sums[c].flags |= flags[at + c];
    }
  }
  return sums;
}

void average(const capture::HdrImage& picture, const Footprints& footprints,
             const std::vector<std::uint32_t>& pixels,
             const std::vector<std::vector<double>>& exitance_per_signal,
             const MeasureOptions& options, const Target& target) {
  constexpr std::uint8_t unusable = capture::pixel_saturated | capture::pixel_missing;
  const FaceShape& shape = footprints.shape;
  const auto average_voxel = [&](int u, int v, std::size_t c, const Sums& sums) {
    const std::size_t voxel = static_cast<std::size_t>(v) * shape.nu + u;
    const bool rim = u == 0 || v == 0 || u == shape.nu - 1 || v == shape.nv - 1;
    const double relative = rim ? options.rim_relative_error : options.relative_error;
    const double factor = exitance_per_signal[c][voxel] * footprints.inverse_coverage[voxel];
    const double value = factor * sums.value;
    const std::size_t to = c * target.step + voxel;
    target.value[to] = static_cast<float>(value);
    target.variance[to] =
        static_cast<float>(factor * factor * sums.variance + relative * relative * value * value);
    const bool good = footprints.visible[voxel] != 0 && (sums.flags & unusable) == 0;
    target.mask[to] = good && target.variance[to] > 0.0F ? 1 : 0;
  };
  const std::size_t channels = exitance_per_signal.size();
  for_rows(shape.nv, [&](int v) {
    for (int u = 0; u < shape.nu; ++u) {
      const std::size_t voxel = static_cast<std::size_t>(v) * shape.nu + u;
      constexpr std::size_t colours = 3;
      if (channels == colours) {
        const auto sums = sums_of<colours>(picture, 0, footprints, pixels, voxel);
        for (std::size_t c = 0; c < colours; ++c) average_voxel(u, v, c, sums[c]);
        continue;
      }
      for (std::size_t c = 0; c < channels; ++c)
        average_voxel(u, v, c, sums_of<1>(picture, c, footprints, pixels, voxel)[0]);
    }
  });
}

/// Where the camera stands under a pattern.
const std::string& station_of(const capture::Session& session, const capture::Pattern& pattern) {
  return pattern.station.empty() ? session.pattern_station : pattern.station;
}

/// Of the sample before the camera there: two stations may see one face.
const SamplePose& pose_of(const capture::Session& session, const CalibrationResult& calibration,
                          const capture::Pattern& pattern) {
  return station_of(session, pattern) == session.pattern_station ? calibration.pattern_pose
                                                                 : calibration.calibration_pose;
}

/// A face as the camera sees it from one station.
struct SeenFace {
  Footprints footprints;
  std::vector<std::vector<double>> exitance_per_signal;  ///< [channel][voxel]
  Region part{};                                         ///< of the last picture
  std::vector<std::uint32_t> pixels{};                   ///< of the footprints in that part

  void look_at(const capture::HdrImage& picture, int camera_width) {
    if (picture.place() == part) return;
    part = picture.place();
    pixels = pixels_in(part, footprints, camera_width);
  }
};

SeenFace seen_face(const capture::Session& session, const CalibrationResult& calibration,
                   const SamplePose& pose, Face face) {
  SeenFace seen{make_footprints(calibration.camera.lens, pose.camera_from_sample,
                                session.sample.shape(), face),
                {}};
  const BoundaryConstants optics = boundary_constants(session.sample.eta);
  const std::size_t cells = seen.footprints.shape.cells();
  seen.exitance_per_signal.assign(session.channels.size(), std::vector<double>(cells));
  for (std::size_t voxel = 0; voxel < cells; ++voxel) {
    if (seen.footprints.visible[voxel] == 0) continue;
    const double shape_factor = radiance_per_exitance(optics, seen.footprints.cos_outside[voxel]);
    for (std::size_t c = 0; c < session.channels.size(); ++c) {
      seen.exitance_per_signal[c][voxel] = 1.0 / (calibration.scale[c] * shape_factor);
    }
  }
  return seen;
}

}  // namespace

Region measured_part(const capture::Session& session, const CalibrationResult& calibration) {
  Surrounding surrounding;
  for (const capture::Pattern& pattern : session.patterns) {
    add_block(calibration.camera.lens, pose_of(session, calibration, pattern).camera_from_sample,
              session.sample.shape(), surrounding);
  }
  return with_surroundings(surrounding, calibration.camera.lens);
}

SurfaceMeasurements measure_surface(const capture::Session& session,
                                    const CalibrationResult& calibration, capture::PatternRole role,
                                    const HdrSource& hdr, Progress& progress,
                                    const MeasureOptions& options) {
  std::vector<const capture::Pattern*> patterns;
  for (const capture::Pattern& pattern : session.patterns) {
    if (pattern.role == role) patterns.push_back(&pattern);
  }
  const std::string role_name = role == capture::PatternRole::fit ? "fit" : "validate";
  if (patterns.empty()) {
    throw InputError((session.folder / "session.json").string() + ": no pattern has the role \"" +
                     role_name + "\"; mark some with it");
  }
  const capture::Sample& sample = session.sample;
  SurfaceMeasurements result;
  result.grid = sample.shape();
  result.eta = sample.eta;
  result.lit_face = sample.lit_face;
  result.quantity = Quantity::exitance;
  result.light = Light::collimated;
  result.sides = sample.sides;
  result.channels = session.channels;
  result.patterns = static_cast<int>(patterns.size());

  const LitFace lit(calibration.projector.lens, calibration.projector_from_sample, result.grid,
                    sample.lit_face, calibration.white.flat, calibration.white.projector_black);
  constexpr double least_reached = 0.9;
  if (lit.reached() < least_reached) {
    throw InputError((session.folder / "session.json").string() +
                     ": by this calibration the projector reaches only " +
                     std::to_string(static_cast<int>(100.0 * lit.reached())) +
                     " % of the lit face; check calibration.board.square_mm, projector size, "
                     "projected_board and the sample view from station \"" +
                     session.calibration_station + "\"");
  }
  std::map<std::string, SeenFace> views;  // by station
  std::map<Face, int> stations;
  std::vector<Face> of_patterns;
  for (const capture::Pattern* pattern : patterns) {
    const Face face = capture::pattern_face(session, *pattern);
    of_patterns.push_back(face);
    const std::string& station = station_of(session, *pattern);
    if (views.contains(station)) continue;
    const SamplePose& pose = pose_of(session, calibration, *pattern);
    views.emplace(station, seen_face(session, calibration, pose, face));
    ++stations[face];
    result.cameras[face] = pose.camera_from_sample.inverse().translation;
  }
  // A face that is seen from two stations has no one camera.
  std::erase_if(result.cameras, [&](const auto& of_face) {
    return sample.radiance == capture::Radiance::p1 || stations.at(of_face.first) > 1;
  });
  set_seen_faces(of_patterns, result.seen_face, result.seen_faces);
  const std::size_t channels = session.channels.size();
  const std::size_t seen_cells = result.seen_shape().cells();
  const std::size_t count = patterns.size();
  result.value.resize(channels * count * seen_cells);
  result.variance.resize(result.value.size());
  result.mask.resize(result.value.size());
  const bool lit_is_seen = result.lit_is_seen();
  if (lit_is_seen && !options.keep_lit) result.lit.assign(result.value.size(), 0);
  const LightTable light = light_table(calibration.projector_curve);
  ValueCheck values;
  for (std::size_t m = 0; m < count; ++m) {
    progress.update("measure " + role_name, static_cast<double>(m) / static_cast<double>(count),
                    patterns[m]->id);
    const Image<std::uint16_t> image = capture::load_pattern(session, *patterns[m]);
    const std::vector<float> irradiance = lit.irradiance(image, light);
    if (!calibration.projector_curve) values.look_at(*patterns[m], image, lit, irradiance);
    result.irradiance.insert(result.irradiance.end(), irradiance.begin(), irradiance.end());
    const capture::HdrImage picture = hdr(patterns[m]->id);
    check(picture.radiance.channels() == static_cast<int>(channels),
          "the HDR picture of pattern " + patterns[m]->id + " has the session's channels");
    SeenFace& face = views.at(station_of(session, *patterns[m]));
    face.look_at(picture, session.camera.width);
    const std::vector<std::uint8_t> lit_here =
        of_patterns[m] == sample.lit_face && !options.keep_lit
            ? lit_voxels(irradiance.data(), face.footprints.shape, options.lit_threshold)
            : std::vector<std::uint8_t>(seen_cells, 0);
    const std::size_t first = m * seen_cells;
    average(
        picture, face.footprints, face.pixels, face.exitance_per_signal, options,
        {&result.value[first], &result.variance[first], &result.mask[first], count * seen_cells});
    for (std::size_t c = 0; c < channels; ++c) {
      const std::size_t at = c * count * seen_cells + first;
      for (std::size_t voxel = 0; voxel < seen_cells; ++voxel) {
        if (lit_here[voxel] != 0)
          result.lit[at + voxel] = std::exchange(result.mask[at + voxel], 0);
      }
    }
  }
  values.tell(progress);
  if (lit_is_seen && !options.keep_lit &&
      std::none_of(result.mask.begin(), result.mask.end(), [](std::uint8_t m) { return m != 0; })) {
    progress.warn(
        "every voxel of the seen face is lit under every pattern for " + role_name +
        ", and a fit of volumes leaves lit voxels out: `kappamu map` and `kappamu fit --model "
        "homogeneous` use them, by transport.");
  }
  progress.update("measure " + role_name, 1.0, "done");
  validate(result, session.folder.string());
  return result;
}

}  // namespace kappamu::calib

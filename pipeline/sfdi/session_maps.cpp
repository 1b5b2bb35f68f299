#include "pipeline/sfdi/session_maps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/sinusoid/face_waves.h"
#include "core/error.h"
#include "core/optics.h"
#include "core/shown_text.h"
#include "io/measurements_file.h"
#include "pipeline/sfdi/median.h"
#include "pipeline/sfdi/sfdi_map.h"
#include "pipeline/stages/calibrate_stage.h"
#include "pipeline/stages/merge_stage.h"

namespace kappamu::pipeline::sfdi {

namespace {

/// One frequency of a channel; `factor` turns exitance over irradiance into light that leaves over
/// light that entered.
Ratio ratio_of(double per_mm, const Image<float>& value, const Image<float>& deviation,
               const Image<std::uint8_t>& mask, double factor) {
  Ratio ratio{per_mm, value, deviation, {}, mask, 1.0};
  for (std::size_t i = 0; i < value.size(); ++i) {
    float& r = ratio.value.values()[i];
    if (r > 0.0F) ratio.deviation.values()[i] /= r;
    r = static_cast<float>(r * factor);
  }
  return ratio;
}

/// Mean of even light over all sinusoids, weighted alike.
void add_mean(Ratio& mean, const Ratio& one, double parts) {
  for (std::size_t i = 0; i < mean.value.size(); ++i) {
    mean.mask.values()[i] = mean.mask.values()[i] & one.mask.values()[i];
    mean.value.values()[i] += static_cast<float>(one.value.values()[i] / parts);
    mean.deviation.values()[i] = static_cast<float>(
        std::hypot(mean.deviation.values()[i], one.deviation.values()[i] / parts));
  }
}

/// Light that a half-space would give back is lost through the block's sides within this distance.
void warn_of_sides(const SurfaceMeasurements& m, Maps& maps) {
  if (m.sides == Sides::mirror) return;
  double reach = 0.0;
  for (const WavelengthMap& map : maps.wavelengths) {
    std::vector<double> lengths;
    for (std::size_t i = 0; i < map.mua.size(); ++i) {
      if (map.verdict.values()[i] != 0) continue;
      const double mua = map.mua.values()[i], musp = map.musp.values()[i];
      lengths.push_back(1.0 / std::sqrt(3.0 * mua * (mua + musp)));
    }
    reach = std::max(reach, median(std::move(lengths)));
  }
  constexpr double lengths_felt = 3.0;
  maps.warnings.push_back("within " + shown_number(lengths_felt * reach, "%.2g") +
                          " mm of the block's sides light is lost through them, which the maps "
                          "take for absorption; kappamu fit takes sides into account.");
}

}  // namespace

SessionMaps maps_of_measurements(const SurfaceMeasurements& m, const Scattering& scattering,
                                 const std::string& source) {
  if (m.two_faces()) {
    throw InputError(source +
                     ": patterns are seen on two faces; maps are of the lit one, and kappamu fit "
                     "takes both");
  }
  if (m.lit_face != m.seen_face) {
    throw InputError(source +
                     ": the lit face is not the seen one; maps need a front-lit sample, "
                     "and kappamu fit takes what shines through");
  }
  if (m.quantity != Quantity::exitance) {
    throw InputError(source + ": quantity is radiance_normal; maps need exitance");
  }
  std::vector<calib::FaceWave> waves;
  try {
    waves = calib::face_waves(m);
  } catch (const InputError& error) {
    throw InputError(source + ": " + error.what());
  }
  if (waves.empty()) {
    throw InputError(source +
                     ": no pattern is a sinusoid; plan them with frequencies per mm, or "
                     "use kappamu fit");
  }
  if (waves.size() >= inverse::most_frequencies) {
    throw InputError(source + ": has " + std::to_string(waves.size()) + " sinusoids; at most " +
                     std::to_string(inverse::most_frequencies - 1) + " are fitted together");
  }
  const GridShape& grid = m.grid;
  const std::array<int, 3> voxels{grid.nx, grid.ny, grid.nz};
  const double depth = voxels[static_cast<std::size_t>(m.seen_face) / 2] * grid.voxel_mm;
  // Errors of an octave are independent of another's: what a pixel has is the sum over the face's.
  const FaceShape face = m.seen_shape();
  const double octaves = std::max(1.0, std::log2(std::max(face.nu, face.nv)));
  SessionMaps result;
  Description& d = result.description;
  d.pixel_mm = grid.voxel_mm;
  d.codes_per_reflectance = 1.0;
  d.medium = {m.eta,
              scattering.index_deviation,
              scattering.anisotropy,
              scattering.anisotropy_deviation,
              depth,
              {},
              {},
              {}};
  try {
    const forward::LateralReflectance model({m.eta, scattering.anisotropy, depth});
  } catch (const InputError& error) {
    throw InputError(source + ": " + error.what());
  }
  d.errors =
      Errors{m.smooth_error.common * std::sqrt(octaves), m.smooth_error.own * std::sqrt(octaves)};
  d.region_px = {face.nu / 4, face.nv / 4, std::max(1, face.nu / 2), std::max(1, face.nv / 2)};
  const double factor = 1.0 / boundary_constants(m.eta).normal_transmittance;
  for (std::size_t c = 0; c < m.channels.size(); ++c) {
    WavelengthMap map;
    map.name = m.channels[c];
    Ratios ratios;
    ratios.by_frequency.emplace_back();
    for (const calib::FaceWave& wave : waves) {
      const double per_mm = wave.carrier.frequency() / grid.voxel_mm;
      const calib::FaceAnswer answer = calib::face_answer(m, c, wave);
      const Ratio even = ratio_of(0.0, answer.even, answer.even_deviation, answer.mask, factor);
      Ratio& mean = ratios.by_frequency.front();
      const auto parts = static_cast<double>(waves.size());
      if (mean.value.empty()) {
        const Image<float> zero(face.nu, face.nv, 1);
        mean = {0.0, zero, zero, {}, Image<std::uint8_t>(face.nu, face.nv, 1, 1), 1.0};
      }
      add_mean(mean, even, parts);
      ratios.by_frequency.push_back(
          ratio_of(per_mm, answer.wave, answer.wave_deviation, answer.mask, factor));
      map.checks.push_back({per_mm, {}, 0.0, answer.stripes, 0, {}});
    }
    result.maps.wavelengths.push_back(map_of_ratios(d, std::move(map), std::move(ratios)));
    add_map_warnings(result.maps.wavelengths.back(), d.pixel_mm, result.maps.warnings);
  }
  warn_of_sides(m, result.maps);
  return result;
}

SessionMaps maps_of_session(const capture::Session& session, const Scattering& scattering,
                            const std::filesystem::path& output, Progress& progress) {
  run_calibrate_stage(session, {}, output / "calibration", progress);
  calib::MeasureOptions options;
  options.keep_lit = true;
  run_merge_stage(session, {}, output / "calibration", output, progress, options);
  progress.update("map", 0.0,
                  "lit voxels are used: by transport with anisotropic scattering, which holds "
                  "where light falls");
  return maps_of_measurements(io::read_measurements(output / "measurements"), scattering,
                              (session.folder / "session.json").string());
}

}  // namespace kappamu::pipeline::sfdi

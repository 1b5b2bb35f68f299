// From camera signal to light: scale per channel, the projector's flat field and black level, from
// the white target and the colour chart. (Black level, response and noise of the camera itself are
// capture/response/radiometry.h.)
//
// The unit of irradiance is the projector's full white at the centre of the lit face, separately in
// each channel; that sets the white balance too. A Lambertian target of reflectance ρ under
// irradiance E has radiance L = ρ E/π in every direction, so no viewing angle enters.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calib/lens/lens.h"
#include "calib/targets/chart.h"
#include "capture/radiance/hdr.h"
#include "core/grid.h"
#include "core/rigid.h"

namespace kappamu::calib {

/// Irradiance of the projector's full white over the lit face, 1 at its centre: polynomial of total
/// degree `degree` in x, y in [-1, 1] over the face.
struct FlatField {
  static constexpr int degree = 4;
  static constexpr int terms = (degree + 1) * (degree + 2) / 2;
  std::array<double, terms> coefficients{1.0};  ///< of x^i y^j, i + j rising, then j rising

  double operator()(double x, double y) const;
};

/// Of each voxel of a face, relative to what should be there, and its variance; 0: no value.
struct FaceMap {
  FaceShape shape;
  std::vector<double> relative;  ///< [v][u]
  std::vector<double> variance;  ///< [v][u]
};

/// What the white target tells.
struct WhiteReference {
  std::vector<double> scale;  ///< [channel] full scales per second for unit radiance
  FlatField flat;
  double projector_black = 0.0;  ///< irradiance of a black pixel over that of a white one
  bool black_measured = false;   ///< else 0 is assumed
  /// The room's irradiance over that of the projector's white, channels' mean; absent where the
  /// target was not photographed with the projector off. Then it is in `projector_black`.
  std::optional<double> room_light;
  /// [channel] scatter of pixels about the fitted polynomial, relative to the centre; noise and
  /// texture of the target.
  std::vector<double> residual_rms;
  std::size_t pixels = 0;  ///< pixels of the lit face that were used
  /// Errors that neighbouring pixels share (shared_error.h), of the target's light about the
  /// polynomial, and of the target under one value beside another; absent where not measured.
  std::optional<double> smooth_error, level_error;
};

/// Pictures may be parts of the camera's (HdrImage::left, top), of one scene the same part.
///
/// `white` and `black` (optional) are pictures of the target from the calibration station,
/// `camera_from_sample` the sample's pose there. Throws InputError naming `name` if most of the lit
/// face is saturated or out of the picture.
WhiteReference measure_white(const capture::HdrImage& white,
                             const std::optional<capture::HdrImage>& black, double reflectance,
                             const Lens& camera, const Rigid& camera_from_sample,
                             const GridShape& grid, Face lit_face, const std::string& name);

/// [channel] `other` over `picture`, two pictures of one target over the lit face, relative to
/// their mean ratio.
std::vector<FaceMap> ratio_on_face(const capture::HdrImage& other, const capture::HdrImage& picture,
                                   const Lens& camera, const Rigid& camera_from_sample,
                                   const GridShape& grid, Face lit_face);

/// [channel] signal of a target at the centre of the lit face, from all of its usable pixels by the
/// flat field. Throws InputError naming `name` where a channel has none.
std::vector<double> centre_signal(const capture::HdrImage& target, const FlatField& flat,
                                  const Lens& camera, const Rigid& camera_from_sample,
                                  const GridShape& grid, Face lit_face, const std::string& name);

/// One neutral patch in one channel.
struct NeutralPatch {
  int patch = 0;                 ///< 18 white ... 23 black, counted from dark skin = 0
  double published = 0.0;        ///< reflectance Y/100
  std::vector<double> measured;  ///< [channel] reflectance by the white target (or by the chart's
                                 ///< own scale where there is none); empty if not usable
};

struct ChartReference {
  ChartPatches patches;
  std::vector<NeutralPatch> neutrals;
  /// [channel] full scales per second for unit radiance by the chart alone: Σ s ρ / Σ ρ² π over the
  /// neutrals, as if irradiance were 1 on all of them where no white target tells better. Empty if
  /// some channel has no neutral patch that can be used.
  std::vector<double> scale;
  /// Root mean square of measured/published - 1 over the neutrals above 5 % reflectance.
  double residual_rms = 0.0;
};

/// `white` is the white target from the same station, if there is one: its pixels tell the
/// irradiance on the chart, since both lie in the plane of the lit face.
ChartReference measure_chart(const capture::HdrImage& chart, const ChartPatches& patches,
                             const capture::HdrImage* white, double white_reflectance,
                             const std::vector<double>& white_scale);

}  // namespace kappamu::calib

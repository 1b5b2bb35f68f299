// Demodulated light of a sample over that of the phantom, per spatial frequency.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "calib/sinusoid/relief.h"
#include "core/image.h"
#include "pipeline/records/sfdi_maps.h"
#include "pipeline/sfdi/sfdi_file.h"

namespace kappamu::pipeline::sfdi {

/// One spatial frequency of one wavelength: sample over phantom (or 1), and its noise.
struct Ratio {
  double per_mm = 0.0;
  Image<float> value, deviation;  ///< deviation: of the pixels' noise, relative
  Image<float> detail;            ///< deviation of what is not resolved, relative; empty: none
  Image<std::uint8_t> mask;
  double shared_pixels = 1.0;
  bool far = false;  ///< seen from the slab's far side
};

struct Ratios {
  std::vector<Ratio> by_frequency;
  std::optional<calib::Relief> relief;  ///< where the description states the projector's place
};

/// Of one wavelength, even light first: from a picture of it, or as the mean of the first sinusoid.
/// Values are divided by the relief's irradiance. Adds what was found in the sample's pictures to
/// `checks`.
Ratios measure_ratios(const Description& description, double wavelength_nm,
                      std::vector<LightCheck>& checks);

}  // namespace kappamu::pipeline::sfdi

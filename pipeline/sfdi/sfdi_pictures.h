// The pictures of sfdi.json, read and demodulated.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/sinusoid/demodulate.h"
#include "pipeline/sfdi/picture_names.h"
#include "pipeline/sfdi/sfdi_file.h"

namespace kappamu::pipeline::sfdi {

struct DemodulatedSet {
  calib::Demodulated light;
  std::optional<double> found_per_mm;  ///< of a single picture: the sinusoid's own frequency
  std::size_t saturated = 0;           ///< pixels left out
};

/// Demodulates the sample's pictures of `pictures`, or the phantom's. `even` is the same object
/// under even light, for single pictures; null: there is none. Throws InputError naming the file.
DemodulatedSet demodulate(const Description& description, const Pictures& pictures, bool sample,
                          const calib::Demodulated* even, PictureReader& reader);

}  // namespace kappamu::pipeline::sfdi

// Maps that several wavelengths give together: amounts of absorbers, oxygen saturation, and the law
// of scattering.
#pragma once

#include <string>
#include <vector>

#include "pipeline/records/sfdi_maps.h"
#include "pipeline/sfdi/sfdi_file.h"

namespace kappamu::pipeline::sfdi {

/// Names of the maps that add_spectra() makes.
std::vector<std::string> spectral_names(const Description& description);

/// Throws InputError, naming the description's file and field, for an absorber that is not known or
/// not known at a wavelength, for more absorbers than wavelengths, and for spectra that are alike.
void check_spectra(const Description& description);

/// From the maps by wavelength; nothing with a single one. Adds a warning where the absorbers do
/// not explain μa.
void add_spectra(const Description& description, Maps& maps);

}  // namespace kappamu::pipeline::sfdi

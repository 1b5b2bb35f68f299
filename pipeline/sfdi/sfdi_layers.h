// Both layers of a sample, where sfdi.json states the thickness of the upper one and no
// coefficients: four numbers of a region, by transport in layers.
#pragma once

#include "pipeline/sfdi/calibration.h"

namespace kappamu::pipeline::sfdi {

/// Whether the layer over the sample is to be found.
bool cover_is_unknown(const Medium& medium);

/// From the region's mean reflectance, with the relative deviation of each mean by noise.
/// `calibration` is that of the sample without its cover, `start` its coefficients.
TwoLayers find_layers(const Medium& medium, const Calibration& calibration,
                      const inverse::PerFrequency& frequency,
                      const inverse::PerFrequency& reflectance, const inverse::PerFrequency& noise,
                      const inverse::LateralCoefficients& start);

/// As a cover of known coefficients.
Layer as_cover(const TwoLayers& found, double thickness_mm, double wavelength_nm);

/// Sentences about coefficients that the light does not determine, and thin upper layers.
void add_layer_warnings(const std::string& label, const TwoLayers& found,
                        std::vector<std::string>& warnings);

}  // namespace kappamu::pipeline::sfdi

// κ and μ of all colour channels of one sample, with what is known about their certainty: the
// result of a fit, and the source of every export.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/grid.h"

namespace kappamu::io {

struct VolumeSet {
  std::vector<std::string> channels;  ///< C names, such as "R", "G", "B"; "grey" for a single one
  std::vector<Medium> media;          ///< one per channel, all of one shape
  std::vector<Volume<double>> kappa_std;  ///< standard deviation of κ [mm]; empty, or C volumes
  std::vector<Volume<double>> mu_std;     ///< standard deviation of μ [1/mm]; empty, or C volumes
  /// Share of the variance that the data removed, 0 to 1 [dimensionless]; empty, or C volumes.
  std::vector<Volume<double>> kappa_resolution;
  std::vector<Volume<double>> mu_resolution;
  std::vector<Volume<double>> sensitivity;      ///< how strongly the data constrain the voxel
                                                ///< [dimensionless, >= 0]; empty, or C volumes
  std::optional<double> eta;                    ///< relative refractive index [dimensionless]
  std::map<std::string, std::string> metadata;  ///< provenance: session, options, versions, device

  const GridShape& shape() const { return media.front().kappa.shape(); }
};

/// Throws InputError unless there is at least one channel, sizes agree, channel names are different
/// words of letters, digits, '-' or '.', every κ is positive and every μ not negative. `source`
/// names the file it came from.
void validate(const VolumeSet& set, const std::string& source);

/// A volume of the set under the name all formats give it ("kappa_R", "std_mu_G", ...).
struct NamedVolume {
  std::string name;
  std::string unit;  ///< "mm", "1/mm" or "1" for dimensionless
  const Volume<double>* volume;
};
/// Everything measured in the set: kappa and mu of each channel, then what else is there.
std::vector<NamedVolume> named_volumes(const VolumeSet& set);

/// Coefficients that renderers take, by similarity theory with g = 0: σt' = 1/(3κ), albedo
/// 1 − 3κμ = σs'/σt' (docs/formats.md).
struct ScatteringVolumes {
  Volume<double> sigma_t;  ///< reduced extinction σt' [1/mm]
  Volume<double> albedo;   ///< reduced albedo [dimensionless]
  std::size_t clamped = 0;  ///< voxels with 3κμ ≥ 1 (no scattering left), whose albedo was set to 0
};
ScatteringVolumes scattering_volumes(const Medium& medium);

}  // namespace kappamu::io

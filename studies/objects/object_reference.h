// Monte Carlo references of the scenes of objects: exitance of patches with standard errors. They
// take minutes each, so they are recorded as files, one for each scene, and measured where missing.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "forward/patches.h"
#include "studies/objects/object_case.h"

namespace kappamu::studies {

using forward::Patches;

struct ObjectReference {
  std::vector<double> exitance;        ///< per patch, relative to one unit of irradiance
  std::vector<double> standard_error;  ///< per patch
  std::uint64_t photons = 0;
  double seconds = 0.0;  ///< that the random walk took
};

/// Walks `photons` photons.
ObjectReference measure_reference(const ObjectBench& bench, const Patches& patches,
                                  std::uint64_t photons, std::uint64_t seed, Progress& progress);

/// <folder>/<scene>.json.
std::filesystem::path reference_file(const std::filesystem::path& folder, const ObjectCase& object);

void write_reference(const ObjectReference& reference, const ObjectCase& object,
                     const ObjectBench& bench, const Patches& patches,
                     const std::filesystem::path& file);

/// Throws InputError unless the file holds a reference of this very scene.
ObjectReference read_reference(const ObjectCase& object, const ObjectBench& bench,
                               const Patches& patches, const std::filesystem::path& file);

/// How far an answer is from a reference, over the surface.
struct ObjectError {
  /// Relative 2-norm of the difference; the part that the reference's noise makes is taken off.
  double two_norm = 0.0;
  double reference_error = 0.0;  ///< standard error of the reference in the same norm
  /// ∫ |difference| dA over ∫ exitance dA, and what noise of the reference alone makes of it.
  double mean = 0.0, mean_of_noise = 0.0;
  /// Share of the surface where the difference exceeds three standard errors plus `allowed` times
  /// the exitance.
  double outside = 0.0;
};

ObjectError error_against(const ObjectReference& reference, const Patches& patches,
                          const std::vector<double>& exitance, double allowed);

}  // namespace kappamu::studies

// One scene of objects with its reference: what a model answers is held against it.
#pragma once

#include "core/processor_time.h"
#include "forward/choice/object_features.h"
#include "forward/patches.h"
#include "studies/objects/object_case.h"
#include "studies/objects/object_reference.h"
#include "studies/subject.h"

namespace kappamu::studies {

/// Of the subject's request.
struct ObjectSettings {
  std::vector<std::string> models;
  std::filesystem::path meshes, volume, references;
  double tolerance = 0.0;  ///< that models are asked for
  std::uint64_t photons = 0, reference_photons = 0;
  int edges_per_size = 0;  ///< of triangles
  bool maps = false;
};
ObjectSettings object_settings(const Request& request);

/// What takes less is done twice, and the lesser time counts: a device's programs are made on first
/// use.
inline constexpr double brief_seconds = 2.0;

/// What passes from here on.
class SpentTime {
 public:
  /// As "seconds", and "cpu_seconds" of all threads together.
  void record(Json& row) const;

 private:
  Stopwatch watch_;
  double processor_ = processor_seconds();
};

/// The model; the one that solves transport walks so many photons per light.
std::unique_ptr<forward::ObjectModel> make_walking(const std::string& model, std::uint64_t photons);

class ObjectMeasurement {
 public:
  /// Makes the scene and reads its reference, or measures and records it.
  ObjectMeasurement(const ObjectCase& object, const ObjectSettings& settings,
                    const Request& request, Progress& progress);

  const forward::ObjectFeatures& features() const { return features_; }
  /// Tolerance of the settings, device and seed of the request.
  forward::ObjectOptions options() const;
  /// Noise of the exitance of patches after so many photons, relative 2-norm, by the reference's
  /// standard errors.
  double noise_of_patches(std::uint64_t photons) const;
  forward::ObjectProblem problem() const { return bench_.problem(); }
  /// Relative 2-norm of an answer's difference from the reference, over the patches.
  double error_of(const forward::ObjectResult& result) const;
  /// "name" and "model", and what was measured, or "refused" with the sentence.
  Json row(const std::string& model, const forward::ObjectOptions& options,
           std::uint64_t photons) const;

 private:
  ObjectReference reference() const;
  void add(const forward::ObjectResult& result, const forward::ObjectOptions& options,
           Json& row) const;
  double covered(const forward::ObjectResult& result) const;
  double exact_error(const forward::ObjectResult& result) const;
  void write_map(const std::string& model, const forward::ObjectResult& result) const;

  const ObjectCase& object_;
  const ObjectSettings& settings_;
  const Request& request_;
  Progress& progress_;
  ObjectBench bench_;
  Patches patches_;
  ObjectReference reference_;
  forward::ObjectFeatures features_;
};

}  // namespace kappamu::studies

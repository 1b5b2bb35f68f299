#include "pipeline/fit_files.h"

#include <algorithm>

#include "core/error.h"
#include "io/measurements_file.h"
#include "pipeline/verify.h"

namespace kappamu::pipeline {

namespace fs = std::filesystem;

void require_same_sample(const SurfaceMeasurements& fitted, const SurfaceMeasurements& validation,
                         const fs::path& folder) {
  const auto fail = [&](const std::string& field) {
    throw InputError(
        (folder / "measurements.json").string() + ": " + field +
        " differs from that of the measurements to fit; validation patterns must be of "
        "the same sample");
  };
  if (!(fitted.grid == validation.grid)) fail("grid or voxel_mm");
  if (fitted.eta != validation.eta) fail("eta");
  if (fitted.channels != validation.channels) fail("channels");
}

fs::path find_measurements(const fs::path& input) {
  for (const fs::path& folder : {input, input / "measurements"}) {
    if (fs::exists(folder / "measurements.json")) return folder;
  }
  throw InputError(input.string() +
                   (fs::is_directory(input) ? ": has no measurements.json, nor measurements/"
                                            : ": no such folder") +
                   "; give a folder of surface measurements or a run that `kappamu merge` filled");
}

std::optional<fs::path> find_validation(const fs::path& input, const FitStageOptions& options) {
  if (options.validate) return options.validate;
  const fs::path beside = input / "measurements_validate";
  return fs::exists(beside / "measurements.json") ? std::optional(beside) : std::nullopt;
}

std::vector<fs::path> fit_inputs(const fs::path& input, const FitStageOptions& options) {
  return {find_measurements(input), input / "measurements_validate", input / "calibration",
          options.validate.value_or(fs::path()), options.continue_from.value_or(fs::path())};
}

std::vector<std::string> fit_outputs(const fs::path& folder) {
  std::vector<std::string> names{"fit.json", "volume.vdb", validated_folder};
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    std::string name = entry.path().filename().string();
    if (name.starts_with("reflectance_") && name.ends_with(".exr")) {
      names.push_back(std::move(name));
      continue;
    }
    for (const char* start :
         {"kappa_", "mu_", "std_", "resolution_", "correlation_", "sensitivity_", "prediction"}) {
      if (name.starts_with(start) && name.ends_with(".npy")) names.push_back(std::move(name));
      if (name.empty()) break;
    }
  }
  return names;
}

FitInput read_fit_input(const fs::path& input, const FitStageOptions& options) {
  const fs::path folder = find_measurements(input);
  require_as_written(folder);
  if (fs::exists(input / "calibration")) require_as_written(input / "calibration");
  FitInput read{io::read_measurements(folder), std::nullopt};
  if (const std::optional<fs::path> validate = find_validation(input, options)) {
    require_as_written(*validate);
    read.validation = io::read_measurements(*validate);
    require_same_sample(read.measurements, *read.validation, *validate);
  }
  return read;
}

std::vector<int> channels_of(const SurfaceMeasurements& measurements,
                             const std::vector<std::string>& names) {
  std::vector<int> indices;
  const auto& known = measurements.channels;
  for (const std::string& name : names.empty() ? known : names) {
    const auto at = std::find(known.begin(), known.end(), name);
    if (at == known.end()) {
      std::string sentence = "channel '";
      sentence.append(name).append("' is not among those measured (");
      for (const std::string& k : known)
        sentence.append(&k == &known.front() ? "" : ", ").append(k);
      throw InputError(sentence.append(")"));
    }
    indices.push_back(static_cast<int>(at - known.begin()));
  }
  return indices;
}

}  // namespace kappamu::pipeline

// `kappamu fit --continue RUN`: a finished fit goes on from its volumes with other options.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"
#include "pipeline/records/fit_options.h"

namespace kappamu::pipeline {

class FinishedFit {
 public:
  /// `folder` has fit.json, or fit/fit.json. Throws InputError naming what is missing.
  explicit FinishedFit(const std::filesystem::path& folder);

  const std::filesystem::path& folder() const { return folder_; }  ///< of fit.json
  /// What it was fitted to. Throws InputError when that is no longer there.
  const std::filesystem::path& present_input() const;

  /// Sets every option to what the fit was made with. Throws InputError for a damaged record.
  void set_options(FitStageOptions& options) const;

  /// Throws InputError in one sentence where `options` ask for what a continuation cannot change:
  /// the convention of κ and μ, the grids before the last, validation patterns that the fit saw.
  void require_continuable(const FitStageOptions& options,
                           const std::vector<int>& validation) const;

  /// Where the fit of `channel` stands. Throws InputError when it has no such channel or another
  /// grid.
  inverse::Continuation channel(const std::string& channel,
                                const SurfaceMeasurements& measurements) const;

 private:
  struct Channel {
    std::string name;
    double homogeneous_kappa = 0.0;  ///< [mm]
    double homogeneous_mu = 0.0;     ///< [1/mm]
    double homogeneous_log_residual = 0.0;
    double weight = 0.0;
    inverse::Physics physics = inverse::Physics::diffusion;
    std::string physics_reason;
  };
  std::filesystem::path folder_;
  std::filesystem::path input_;
  std::string options_;  ///< JSON, as options_json() writes it
  std::vector<int> validation_;
  std::vector<Channel> channels_;
};

}  // namespace kappamu::pipeline

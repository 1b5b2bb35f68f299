#include "pipeline/stages/continuation.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/file_name.h"
#include "inverse/fit/describe_options.h"
#include "io/json_reason.h"
#include "io/json_whole.h"
#include "io/read_file.h"
#include "io/volume/npy_volume.h"
#include "pipeline/fit_files.h"
#include "pipeline/stages/fit_stage.h"
#include "pipeline/verify.h"

namespace kappamu::pipeline {

namespace fs = std::filesystem;
using Json = nlohmann::json;

FinishedFit::FinishedFit(const fs::path& folder)
    : folder_(fs::exists(folder / "fit.json") ? folder : folder / "fit") {
  const fs::path file = folder_ / "fit.json";
  if (!fs::exists(file)) {
    throw InputError(folder.string() +
                     ": has no fit.json; a fit goes on from the folder of a finished one");
  }
  require_as_written(folder_);
  try {
    const Json fit = Json::parse(io::read_text(file));
    input_ = fit.at("input").get<std::string>();
    options_ = fit.at("options").dump();
    validation_ = io::whole_numbers<int>(fit.at("validation").at("patterns"));
    for (const Json& c : fit.at("channels")) {
      const Json& start = c.at("homogeneous");
      const Json& physics = c.at("physics");
      channels_.push_back({c.at("name").get<std::string>(), start.at("kappa_mm").get<double>(),
                           start.at("mu_per_mm").get<double>(),
                           start.at("log_residual_rms").get<double>(), c.at("weight").get<double>(),
                           value_of(inverse::physics_names, physics.at("name").get<std::string>())
                               .value_or(inverse::Physics::diffusion),
                           physics.at("reason").get<std::string>()});
      require_plain_name(channels_.back().name, file.string() + ": a channel's name");
    }
  } catch (const Json::exception& error) {
    throw InputError(file.string() + ": not as this kappamu writes it (" + io::json_reason(error) +
                     "); repeat that fit");
  }
}

const fs::path& FinishedFit::present_input() const {
  if (fs::exists(input_)) return input_;
  throw InputError(folder_.string() + ": was fitted to " + input_.string() +
                   ", which is no longer there; name its present place as INPUT");
}

void FinishedFit::set_options(FitStageOptions& options) const {
  try {
    pipeline::set_options(options, options_);
  } catch (const InputError& error) {
    throw InputError((folder_ / "fit.json").string() + ": options are damaged (" + error.what() +
                     "); repeat that fit");
  }
}

void FinishedFit::require_continuable(const FitStageOptions& options,
                                      const std::vector<int>& validation) const {
  const Json before = Json::parse(options_);
  const Json now = Json::parse(options_json(options));
  const auto refuse = [&](const std::string& what) {
    throw InputError(folder_.string() + ": cannot go on: " + what + "; fit anew");
  };
  if (before.value("convention", "") != now.value("convention", "")) {
    refuse("its κ and μ hold under the convention " + before.value("convention", "") + " only");
  }
  if (before.value("max_levels", Json()) != now.value("max_levels", Json())) {
    refuse("it goes on from the full grid, so that the number of levels cannot be changed");
  }
  for (const int m : validation) {
    if (std::find(validation_.begin(), validation_.end(), m) == validation_.end()) {
      refuse("it was fitted to pattern " + std::to_string(m) +
             ", which therefore cannot be held out now");
    }
  }
}

inverse::Continuation FinishedFit::channel(const std::string& channel,
                                           const SurfaceMeasurements& measurements) const {
  // What validates must not have been seen: where volumes of before are kept, from these.
  const fs::path before = folder_ / validated_folder;
  const std::string kappa = "kappa_" + channel + ".npy";
  const fs::path from = fs::exists(before / kappa) ? before : folder_;
  for (const Channel& c : channels_) {
    if (c.name != channel) continue;
    return {{io::read_npy_volume(from / kappa, measurements.grid),
             io::read_npy_volume(from / ("mu_" + channel + ".npy"), measurements.grid)},
            c.homogeneous_kappa,
            c.homogeneous_mu,
            c.homogeneous_log_residual,
            c.weight,
            inverse::PathEnd::asked,
            c.physics,
            c.physics_reason};
  }
  throw InputError(folder_.string() + ": has no channel '" + channel +
                       "' to go on from; choose among its own, or fit anew",
                   {{"channels"}});
}

}  // namespace kappamu::pipeline

#include "pipeline/stages/continuation.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/file_name.h"
#include "io/read_file.h"
#include "io/volume/npy_volume.h"
#include "pipeline/stages/fit_stage.h"

namespace kappamu::pipeline {

namespace fs = std::filesystem;
using Json = nlohmann::json;

FinishedFit::FinishedFit(const fs::path& folder)
    : folder_(fs::exists(folder / "fit.json") ? folder : folder / "fit") {
  const fs::path file = folder_ / "fit.json";
  if (!fs::exists(file)) {
    throw InputError(folder.string() +
                     ": has no fit.json; --continue takes the folder of a finished fit");
  }
  try {
    const Json fit = Json::parse(io::read_text(file));
    input_ = fit.at("input").get<std::string>();
    options_ = fit.at("options").dump();
    held_out_ = fit.at("validation").at("patterns").get<std::vector<int>>();
    for (const Json& c : fit.at("channels")) {
      const Json& start = c.at("homogeneous");
      channels_.push_back({c.at("name").get<std::string>(), start.at("kappa_mm").get<double>(),
                           start.at("mu_per_mm").get<double>(),
                           start.at("log_residual_rms").get<double>(),
                           c.at("weight").get<double>()});
      require_plain_name(channels_.back().name, file.string() + ": a channel's name");
    }
  } catch (const Json::exception& error) {
    throw InputError(file.string() + ": not as this kappamu writes it (" + error.what() +
                     "); repeat that fit");
  }
}

void FinishedFit::set_options(FitArguments& arguments) const {
  const Json o = Json::parse(options_);
  inverse::FitOptions& fit = arguments.stage.fit;
  const auto take = [&](const char* name, auto& value) {
    if (o.contains(name) && !o[name].is_null()) o[name].get_to(value);
  };
  try {
    take("optimiser", arguments.optimiser);
    take("convention", arguments.convention);
    take("precision", arguments.precision);
    take("loss", arguments.loss);
    take("huber_threshold", fit.data_term.huber_threshold);
    take("student_freedom", fit.data_term.student_freedom);
    take("gain_spread", arguments.gains);
    take("regulariser", arguments.regulariser);
    take("edge_slope", fit.regulariser.edge_slope);
    take("choose_weight", arguments.choose_weight);
    if (o.contains("weight") && o["weight"].is_number()) fit.weight = o["weight"].get<double>();
    take("target_chi2", fit.target_chi2);
    take("model_error_relative", fit.model_error.relative);
    take("model_error_of_maximum", fit.model_error.of_maximum);
    take("stage_tolerance", fit.stage_tolerance);
    take("final_tolerance", fit.final_tolerance);
    take("stage_steps", fit.stage_steps);
    take("max_levels", fit.max_levels);
    take("hold_out", arguments.stage.hold_out);
    take("channels", arguments.stage.channels);
    if (o.contains("correct_grid")) arguments.no_grid_correction = !o["correct_grid"].get<bool>();
  } catch (const Json::exception& error) {
    throw InputError((folder_ / "fit.json").string() + ": options are damaged (" + error.what() +
                     "); repeat that fit");
  }
}

void FinishedFit::require_continuable(const FitStageOptions& options,
                                      const std::vector<int>& held_out) const {
  const Json before = Json::parse(options_);
  const Json now = Json::parse(options_json(options));
  const auto refuse = [&](const std::string& what) {
    throw InputError("--continue " + folder_.string() + ": " + what +
                     "; fit anew without --continue");
  };
  if (before.value("convention", "") != now.value("convention", "")) {
    refuse("its κ and μ hold under --convention " + before.value("convention", "") + " only");
  }
  if (before.value("max_levels", 0) != now.value("max_levels", 0)) {
    refuse("it goes on from the full grid, so that --levels cannot be changed");
  }
  for (const int m : held_out) {
    if (std::find(held_out_.begin(), held_out_.end(), m) == held_out_.end()) {
      refuse("it was fitted to pattern " + std::to_string(m) +
             ", which therefore cannot be held out now");
    }
  }
}

inverse::Continuation FinishedFit::channel(const std::string& channel,
                                           const SurfaceMeasurements& measurements) const {
  // What is held out must not have been seen: where volumes of before are kept, from these.
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
            c.weight};
  }
  throw InputError("--continue " + folder_.string() + ": has no channel '" + channel +
                   "'; choose among its own with --channel, or fit anew without --continue");
}

}  // namespace kappamu::pipeline

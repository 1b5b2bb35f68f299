#include "pipeline/records/channel_json.h"

#include <nlohmann/json.hpp>

#include "inverse/fit/describe_options.h"
#include "pipeline/records/model_json.h"

namespace kappamu::pipeline {

nlohmann::ordered_json channel_json(const std::string& name, const inverse::FitReport& report) {
  nlohmann::ordered_json history = nlohmann::ordered_json::array();
  for (const inverse::StepRecord& r : report.history) {
    history.push_back({{"level", r.level},
                       {"weight", r.weight},
                       {"step", r.step},
                       {"adjoint_solves", r.solves.adjoint},
                       {"forward_solves", r.solves.forward},
                       {"refined_solves", r.solves.refined},
                       {"objective", r.objective},
                       {"chi2_per_value", r.chi2_per_value},
                       {"roughness", r.roughness},
                       {"seconds", r.seconds}});
  }
  return {{"name", name},
          {"status", inverse::to_string(report.status)},
          {"reason", report.reason},
          {"physics",
           {{"name", name_of(inverse::physics_names, report.physics)},
            {"reason", report.physics_reason},
            {"photons", report.solves.photons}}},
          {"model", model_json(report.model)},
          {"consistency", consistency_json(report.consistency)},
          {"chi2_per_value", report.chi2_per_value},
          {"shared_errors",
           {{"mean", report.shared.mean},
            {"mean_stated", report.shared.stated},
            {"octave_excess", report.shared.excess}}},
          {"values_used", report.data},
          {"weight", report.weight},
          {"homogeneous",
           {{"kappa_mm", report.homogeneous_kappa},
            {"mu_per_mm", report.homogeneous_mu},
            {"log_residual_rms", report.homogeneous_log_residual}}},
          {"seconds", report.seconds},
          {"warnings", report.warnings},
          {"history", history}};
}

}  // namespace kappamu::pipeline

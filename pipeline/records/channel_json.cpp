#include "pipeline/records/channel_json.h"

#include <nlohmann/json.hpp>

#include "pipeline/records/model_json.h"

namespace kappamu::pipeline {

nlohmann::ordered_json channel_json(const std::string& name, const inverse::FitReport& report) {
  nlohmann::ordered_json history = nlohmann::ordered_json::array();
  for (const inverse::StepRecord& r : report.history) {
    history.push_back({{"grid", r.level},
                       {"regularisation", r.weight},
                       {"step", r.step},
                       {"evaluations", r.solves.adjoint},
                       {"forward_solves", r.solves.forward},
                       {"refined_solves", r.solves.refined},
                       {"objective", r.objective},
                       {"chi2_per_value", r.chi2_per_datum},
                       {"roughness", r.roughness},
                       {"seconds", r.seconds}});
  }
  return {{"name", name},
          {"converged", report.status != inverse::FitStatus::ran_out},
          {"status", inverse::to_string(report.status)},
          {"reason", report.message},
          {"model", model_json(report.model)},
          {"consistency", consistency_json(report.consistency)},
          {"chi2_per_value", report.chi2_per_datum},
          {"values_used", report.data},
          {"regularisation", report.weight},
          {"homogeneous",
           {{"kappa_mm", report.homogeneous_kappa},
            {"mu_per_mm", report.homogeneous_mu},
            {"log_residual_rms", report.homogeneous_log_residual}}},
          {"seconds", report.seconds},
          {"warnings", report.warnings},
          {"history", history}};
}

}  // namespace kappamu::pipeline

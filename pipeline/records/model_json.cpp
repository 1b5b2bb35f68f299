#include "pipeline/records/model_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace kappamu::pipeline {

nlohmann::ordered_json model_json(const inverse::ModelChoice& choice) {
  using Json = nlohmann::ordered_json;
  Json trials = Json::array();
  for (const inverse::ModelTrial& t : choice.trials) {
    trials.push_back({{"model", to_string(t.model)},
                      {"layers", t.layers},
                      {"level", t.level},
                      {"chi2_per_value", t.chi2_per_value},
                      {"autocorrelation_chi2", t.coherent},
                      {"autocorrelation_limit", t.coherent_limit},
                      {"rejected", t.rejected}});
  }
  return {{"name", to_string(choice.model)},
          {"layers", choice.layers},
          {"reason", choice.reason},
          {"systematic_error", choice.systematic},
          {"systematic_error_pixels", choice.systematic_length},
          {"trials", trials}};
}

nlohmann::ordered_json consistency_json(const inverse::Consistency& c) {
  using Json = nlohmann::ordered_json;
  if (!c.checked) return {{"checked", false}};
  const inverse::VolumeErrors* scale =
      c.by_volume && c.by_volume->log_scale ? &*c.by_volume : nullptr;
  return {{"checked", true},
          {"homogeneous_explains", c.explained},
          {"shift_by_volume", c.volume_shift},
          {"scale", std::exp(c.log_scale.value)},
          {"log_scale", {{"value", c.log_scale.value}, {"std", c.log_scale.error}}},
          {"log_scale_limit", c.log_scale_limit},
          {"volume_log_scale", scale ? Json(scale->log_scale->value) : Json(nullptr)},
          {"scale_gain", scale ? Json(scale->scale_gain) : Json(nullptr)},
          {"scale_is_wrong", c.scale_is_wrong()},
          {"shift_voxels",
           {{"u", c.shift_u.value},
            {"u_std", c.shift_u.error},
            {"v", c.shift_v.value},
            {"v_std", c.shift_v.error}}},
          {"shift_limit_voxels", c.shift_limit},
          {"is_shifted", c.is_shifted()},
          {"other_eta", c.other_eta ? Json(*c.other_eta) : Json(nullptr)}};
}

std::string short_name(const inverse::ModelChoice& choice) {
  return choice.model == inverse::Model::layered ? std::to_string(choice.layers) + " layers"
                                                 : to_string(choice.model);
}

}  // namespace kappamu::pipeline

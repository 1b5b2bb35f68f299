// What a fit says about the model it chose and about its data, as fit.json and --json carry it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "inverse/block_model/block_model.h"
#include "inverse/data_checks/consistency.h"

namespace kappamu::pipeline {

/// {"name", "layers", "reason", "trials"} (docs/formats.md).
nlohmann::ordered_json model_json(const inverse::ModelChoice& choice);

/// {"checked", …}: scale and shift of the best homogeneous block, with limits and findings.
nlohmann::ordered_json consistency_json(const inverse::Consistency& consistency);

/// "homogeneous", "4 layers", "volume"
std::string short_name(const inverse::ModelChoice& choice);

}  // namespace kappamu::pipeline

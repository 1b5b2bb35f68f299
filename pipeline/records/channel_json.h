// One channel's part of fit.json (docs/formats.md).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "inverse/fit/fit.h"

namespace kappamu::pipeline {

nlohmann::ordered_json channel_json(const std::string& name, const inverse::FitReport& report);

}  // namespace kappamu::pipeline

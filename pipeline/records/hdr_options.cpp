#include "pipeline/records/hdr_options.h"

namespace kappamu::pipeline {

std::map<std::string, std::string> options_by_name(const capture::HdrOptions& options) {
  return {{"response", name_of(responses, options.response)},
          {"merge", name_of(weights, options.merge.weight)},
          {"on_flicker", name_of(actions, options.merge.on_flicker)},
          {"on_motion", name_of(actions, options.merge.on_motion)}};
}

std::string options_text(const capture::HdrOptions& options) {
  std::string text;
  for (const auto& [name, value] : options_by_name(options)) text += name + "=" + value + ";";
  return text;
}

}  // namespace kappamu::pipeline

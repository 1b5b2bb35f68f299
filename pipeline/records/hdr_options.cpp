#include "pipeline/records/hdr_options.h"

namespace kappamu::pipeline {

std::map<std::string, std::string> options_by_name(const capture::MergeOptions& options) {
  return {{"on_flicker", name_of(actions, options.on_flicker)},
          {"on_motion", name_of(motion_actions, options.on_motion)}};
}

std::string options_text(const capture::MergeOptions& options) {
  std::string text;
  for (const auto& [name, value] : options_by_name(options)) text += name + "=" + value + ";";
  return text;
}

}  // namespace kappamu::pipeline

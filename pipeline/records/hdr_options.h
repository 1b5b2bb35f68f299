// The options between frames and radiance, by name.
#pragma once

#include <map>
#include <string>

#include "capture/radiance/merge.h"
#include "core/names.h"

namespace kappamu::pipeline {

inline constexpr Names<capture::OnFault, 3> actions{{{"refuse", capture::OnFault::refuse},
                                                     {"correct", capture::OnFault::correct},
                                                     {"ignore", capture::OnFault::ignore}}};
inline constexpr Names<capture::OnFault, 4> motion_actions{{{"refuse", capture::OnFault::refuse},
                                                            {"correct", capture::OnFault::correct},
                                                            {"align", capture::OnFault::align},
                                                            {"ignore", capture::OnFault::ignore}}};

/// The options by name, for run.json.
std::map<std::string, std::string> options_by_name(const capture::MergeOptions& options);

/// The same in one text, equal for equal options: part of the stages' keys.
std::string options_text(const capture::MergeOptions& options);

}  // namespace kappamu::pipeline

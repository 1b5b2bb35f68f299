// The options between frames and radiance, by name.
#pragma once

#include <array>
#include <map>
#include <string>
#include <utility>

#include "capture/radiance/merge.h"

namespace kappamu::pipeline {

template <class Value, std::size_t n>
using Names = std::array<std::pair<const char*, Value>, n>;

inline constexpr Names<capture::ResponseMethod, 3> responses{
    {{"smooth", capture::ResponseMethod::smooth},
     {"debevec", capture::ResponseMethod::debevec_malik},
     {"robertson", capture::ResponseMethod::robertson}}};
inline constexpr Names<capture::MergeWeight, 3> weights{
    {{"variance", capture::MergeWeight::inverse_variance},
     {"debevec", capture::MergeWeight::debevec_hat},
     {"robertson", capture::MergeWeight::robertson}}};
inline constexpr Names<capture::OnFault, 3> actions{{{"refuse", capture::OnFault::refuse},
                                                     {"correct", capture::OnFault::correct},
                                                     {"ignore", capture::OnFault::ignore}}};

template <class Value, std::size_t n>
std::string name_of(const Names<Value, n>& names, Value value) {
  for (const auto& [name, named] : names) {
    if (named == value) return name;
  }
  return "";
}

/// The options by name, for run.json.
std::map<std::string, std::string> options_by_name(const capture::HdrOptions& options);

/// The same in one text, equal for equal options: part of the stages' keys.
std::string options_text(const capture::HdrOptions& options);

}  // namespace kappamu::pipeline

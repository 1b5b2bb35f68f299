#include "app/hdr_options.h"

#include <CLI/CLI.hpp>
#include <array>
#include <utility>

namespace kappamu::app {

namespace {

using capture::MergeWeight;
using capture::OnFault;
using capture::ResponseMethod;

template <class Value, std::size_t n>
using Names = std::array<std::pair<const char*, Value>, n>;

constexpr Names<ResponseMethod, 3> responses{{{"smooth", ResponseMethod::smooth},
                                              {"debevec", ResponseMethod::debevec_malik},
                                              {"robertson", ResponseMethod::robertson}}};
constexpr Names<MergeWeight, 3> weights{{{"variance", MergeWeight::inverse_variance},
                                         {"debevec", MergeWeight::debevec_hat},
                                         {"robertson", MergeWeight::robertson}}};
constexpr Names<OnFault, 3> actions{
    {{"refuse", OnFault::refuse}, {"correct", OnFault::correct}, {"ignore", OnFault::ignore}}};

template <class Value, std::size_t n>
std::string name_of(const Names<Value, n>& names, Value value) {
  for (const auto& [name, named] : names) {
    if (named == value) return name;
  }
  return "";
}

template <class Value, std::size_t n>
void add_choice(CLI::App& command, const std::string& option, const Names<Value, n>& names,
                Value& value, const std::string& text) {
  std::vector<std::string> allowed;
  for (const auto& [name, unused] : names) allowed.emplace_back(name);
  command
      .add_option_function<std::string>(
          option,
          [&names, &value](const std::string& chosen) {
            for (const auto& [name, named] : names) {
              if (chosen == name) value = named;
            }
          },
          text + " (default " + name_of(names, value) + ")")
      ->check(CLI::IsMember(allowed))
      ->group("Frames to radiance");
}

}  // namespace

void add_hdr_options(CLI::App& command, capture::HdrOptions& options) {
  add_choice(command, "--response", responses, options.response,
             "Recovery of the camera's response: smooth (ours), or the papers' debevec (Debevec "
             "and Malik 1997) or robertson (Robertson et al. 2003)");
  add_choice(command, "--merge", weights, options.merge.weight,
             "Weights of the merge: variance (inverse variance of shot, read and rounding noise), "
             "or the papers' debevec (hat) or robertson (bell)");
  add_choice(command, "--on-flicker", actions, options.merge.on_flicker,
             "A frame brighter or darker than the rest of its stack, or of a mislabelled "
             "exposure: refuse it by name, correct its exposure from the frames, or ignore");
  add_choice(command, "--on-motion", actions, options.merge.on_motion,
             "A frame shifted against the rest of its stack, or partly changed: refuse it by "
             "name, correct by leaving it out, or ignore");
}

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

}  // namespace kappamu::app

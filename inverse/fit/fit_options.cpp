// The bounds of a fit's options, and the names of how it ends.
#include "inverse/fit/fit_options.h"

#include <optional>
#include <string>
#include <type_traits>

#include "core/error.h"
#include "inverse/fit/describe_options.h"
#include "inverse/fit/fit.h"

namespace kappamu::inverse {

namespace {

void require(bool holds, const std::string& sentence) {
  if (!holds) throw InputError("fit options: " + sentence);
}

struct RequireBounds {
  template <class Value, class... MoreNames>
  void operator()(const Option& option, const Value& value, const MoreNames&...) const {
    if constexpr (std::is_arithmetic_v<Value>) {
      require(option.bounds.hold(static_cast<double>(value)),
              std::string(option.name) + " " + requirement(option.bounds));
    }
  }
  void operator()(const Option& option, const std::optional<double>& value) const {
    if (value) (*this)(option, *value);
  }
};

}  // namespace

void validate(const FitOptions& o) {
  describe(o, RequireBounds{});
  require(o.path.start_kappa.has_value() == o.path.start_mu.has_value(),
          "start_kappa and start_mu must be given together");
  require(o.path.last_weight <= o.path.first_weight, "last_weight must be at most first_weight");
  require(o.data.physics == Physics::diffusion ||
              (o.data.convention == forward::Convention::physical && o.path.correct_grid),
          "physics other than diffusion needs the physical convention and the grid correction");
  require(o.data.physics != Physics::diffusion || o.data.anisotropy == 0.0,
          "anisotropy is of transport, and physics is diffusion, which knows reduced scattering "
          "alone; choose transport or auto");
}

std::string to_string(FitStatus status) {
  switch (status) {
    case FitStatus::converged:
      return "converged";
    case FitStatus::above_noise:
      return "above_noise";
    default:
      return "ran_out";
  }
}

}  // namespace kappamu::inverse

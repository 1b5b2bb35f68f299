#include "forward/dipole/local/radius.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace kappamu::forward::dipole {

namespace {

/// The root v = log w of q·(e^v − 1) + v = l. The function is convex and both bounds lie above the
/// root, so that Newton's steps fall towards it.
double log_stretch(double q, double l) {
  constexpr int most_steps = 60;
  double v = q > 0.0 ? std::min(l, std::log1p(l / q)) : l;
  for (int step = 0; step < most_steps; ++step) {
    const double grown = q * std::expm1(v);
    const double change = (grown + v - l) / (grown + q + 1.0);
    v -= change;
    if (std::abs(change) <= 1e-14 * v) break;
  }
  return std::max(v, 0.0);
}

}  // namespace

double sampled_radius(const Profile& profile, double u) {
  double rest = u * profile.beyond(0.0);
  for (const SourceTerm& term : profile.terms()) {
    check(term.fluence == 0.0 && term.flux > 0.0, "terms of flux alone can be sampled");
    const double share = profile.term_beyond(term, term.z);
    if (rest < share || &term == &profile.terms().back()) {
      const double within = std::min(rest / share, 1.0 - 1e-16);
      const double v = log_stretch(profile.decay() * term.z, -std::log1p(-within));
      return term.z * std::sqrt(std::expm1(2.0 * v));
    }
    rest -= share;
  }
  return 0.0;
}

}  // namespace kappamu::forward::dipole

// Light of a slab's far side and of two layers one of which is known, by transport in layers
// (layered_transport.h), from a table that is filled where it is asked: over log μa and log σs' of
// what is not known, cubic in between, at each spatial frequency.
#pragma once

#include <cstdint>
#include <mutex>
#include <shared_mutex>
#include <unordered_map>

#include "forward/lateral/lateral_reflectance.h"
#include "forward/lateral/layered_transport.h"

namespace kappamu::forward {

class LateralStack {
 public:
  /// `medium` has a thickness, a cover or a base.
  explicit LateralStack(const LateralMedium& medium);

  /// As those of LateralReflectance; from any number of threads, with the same answers.
  LateralValue reflectance(double frequency, double mua, double musp) const;
  LateralValue transmittance(double frequency, double mua, double musp) const;

 private:
  /// Logarithms of both.
  struct Node {
    double reflected = 0.0, transmitted = 0.0;
  };
  Node node(int frequency, int mua, int musp) const;
  LateralValue at(double frequency, double mua, double musp, double Node::*of) const;

  LateralMedium medium_;
  mutable std::once_flag made_;
  mutable std::optional<LayeredTransport> transport_;  ///< made with the first node
  mutable std::shared_mutex lock_;
  mutable std::unordered_map<std::uint64_t, Node> nodes_;
};

}  // namespace kappamu::forward

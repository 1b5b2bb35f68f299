// A homogeneous object whose light alone changes: the dipole with sources placed reciprocally, its
// hierarchy and links kept between lights ([M]'s static mode), three colour channels in one sum.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "forward/object_model.h"

namespace kappamu::forward::dipole {

class Relight {
 public:
  /// `media` of R, G, B, all homogeneous. Keeps references to mesh and surface. Throws InputError
  /// for a medium that varies.
  Relight(const TriangleMesh& mesh, const Surface& surface,
          const std::array<const ObjectMedium*, 3>& media, double eta,
          const ObjectOptions& options);
  ~Relight();

  /// Exitance per triangle of R, G, B.
  std::array<std::vector<double>, 3> exitance(const std::array<ObjectLight, 3>& light);
  /// The summation's relative error for this light, the worst channel's, measured at a few
  /// triangles against the direct sum; takes longer than the sum itself.
  double measured_error(const std::array<ObjectLight, 3>& light,
                        const std::array<std::vector<double>, 3>& exitance) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kappamu::forward::dipole

// A mesh in parallel light, for the tests of forward/choice.
#pragma once

#include <utility>

#include "tests/forward/lit_object.h"

namespace kappamu::forward {

struct Lit : LitObject {
  Lit(TriangleMesh its_mesh, const ObjectMedium& filling)
      : LitObject(std::move(its_mesh), filling) {
    lights = {parallel_beams(surface, Eigen::Vector3d(-1.0, -2.0, -3.0).normalized())};
  }
};

}  // namespace kappamu::forward

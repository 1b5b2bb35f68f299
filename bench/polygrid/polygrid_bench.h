// Polygrids of meshes: how good their cells are, how close to the object, how long they take.
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

Subject polygrid_subject();

}  // namespace kappamu::bench

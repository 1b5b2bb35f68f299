// Models and deviations under systematic error, over populations of blocks of each kind.
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

Subject systematic_subject();

}  // namespace kappamu::bench

// The standard deviations of a fit proved by sampling, and what each estimate of them costs.
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

Subject uncertainty_subject();

}  // namespace kappamu::bench

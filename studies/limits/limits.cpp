#include "studies/limits/limits.h"

#include "studies/subjects.h"
namespace kappamu::studies {

namespace {

template <Json (*rows_of)(const Request&, Progress&)>
void rows(const Request& request, Progress& progress, const Save& save) {
  save({{"rows", rows_of(request, progress)}});
}

}  // namespace

Subject limits_subject() {
  return {"limits",
          "Where the solver and the fit meet their limits: every table of docs/limits.md",
          R"(  kappamu-studies limits -o out/bench                              all: some minutes
  kappamu-studies limits -o out/bench --section contrast size      two of them
  studies/bench.sh limits                                        and renew the page

Errors are distances to the solution of the grid's equations (double, refined in long
double) or to closed forms; no times. --small leaves out grids of 256^3, which need 3 GB.)",
          {{"contrast", "iterations and true error against the contrast of kappa",
            rows<limit_contrast>},
           {"size", "iterations against the size of the grid", rows<limit_size>},
           {"floor", "the error float and double can attain, against contrast", rows<limit_floor>},
           {"absorption", "mu from 0 to 100/mm", rows<limit_absorption>},
           {"coarse", "voxels against the mean free path", rows<limit_coarse>},
           {"stencil", "energy lost or made by [W] equation (8)'s stencil", rows<limit_stencil>},
           {"relaxation", "residual and error of the papers' relaxation", rows<limit_relaxation>},
           {"inverse", "fits of difficult, scarce and wrong data", rows<limit_inverse>},
           {"consistency", "how often a wrong scale, pose or eta of the data is reported",
            rows<limit_consistency>},
           {"shared-errors", "fits of data whose pixels share errors of the size stated",
            rows<limit_shared_errors>},
           {"objects", "iterations on cut cubes: jagged, thin and mixed objects",
            rows<limit_objects>}}};
}

}  // namespace kappamu::studies

#include "bench/limits/limits.h"

namespace kappamu::bench {

Subject limits_subject() {
  return {"limits",
          "Where the solver and the fit meet their limits: every table of docs/limits.md",
          "  kappamu bench limits -o out/bench                              all: some minutes\n"
          "  kappamu bench limits -o out/bench --section contrast shape     two of them\n"
          "  scripts/bench.sh limits                                        and renew the page\n\n"
          "Errors are distances to the solution of the grid's equations (double, refined in long\n"
          "double) or to closed forms; no times but those of objects-cost. --small leaves out "
          "grids of 256^3, which need 3 GB.",
          {{"contrast", "iterations and true error against the contrast of kappa", limit_contrast},
           {"size", "iterations against the size of the grid", limit_size},
           {"floor", "the error float and double can attain, against contrast", limit_floor},
           {"absorption", "mu from 0 to 100/mm", limit_absorption},
           {"mirror", "mirror sides without absorption", limit_mirror},
           {"shape", "thin, long, prime and odd grids", limit_shape},
           {"boundary", "kappa jumping at the surface", limit_boundary},
           {"coarse", "voxels against the mean free path", limit_coarse},
           {"stencil", "energy lost or made by [W] equation (8)'s stencil", limit_stencil},
           {"relaxation", "residual and error of the papers' relaxation", limit_relaxation},
           {"inverse", "fits of difficult, scarce and wrong data", limit_inverse},
           {"consistency", "how often a wrong scale, pose or eta of the data is reported",
            limit_consistency},
           {"objects", "iterations on cut cubes: jagged, thin and mixed objects", limit_objects},
           {"objects-cost", "time per cube of the model on cut cubes (docs/embedded.md)",
            limit_object_cost}}};
}

}  // namespace kappamu::bench

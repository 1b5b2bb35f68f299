#include <nlohmann/json.hpp>

#include "studies/shells/shells_bench.h"
#include "studies/subjects.h"

namespace kappamu::studies {

Subject fur_subject() {
  return {
      "fur",
      "Fur in shells: hair textures, transfer, pictures against rays",
      R"(Measures what docs/fur.md states of a tile of 64 x 64 x 32 texels with 55,000 hairs:
areas of coverage, symmetry, the error of transfer by bands and rays, pictures by shells against
the integral along the eye's rays, seconds. Figures are written as PNG files. Speed depends on
the load of the machine; all else is the same on every machine.)",
      {{"coverage", "Areas of circles in texels against the paper's approximations", fur_coverage},
       {"symmetry", "What makes light from one side brighter", fur_symmetry},
       {"transfer", "Light of texels and shells by bands and rays, four lights", fur_transfer},
       {"reference", "Pictures by shells against pictures by rays, four lights", fur_reference},
       {"detail", "Fewer shells far away against all of them", fur_detail},
       {"speed", "Seconds of texture, transfer and frame, by C++ and OpenCL", fur_speed},
       {"figures", "The paper's figures 1, 3, 4 and 5", fur_figures}}};
}

}  // namespace kappamu::studies

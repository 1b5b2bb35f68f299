#include <nlohmann/json.hpp>

#include "studies/figures/figures_bench.h"
#include "studies/subjects.h"

namespace kappamu::studies {

Subject figures_subject() {
  return {"figures",
          "Figures of the papers made again, in the papers' arrangement",
          R"(  kappamu-studies figures --section pictures --figure t-5-1 -o out/figures
  kappamu-studies figures --section weights -o out/figures --quick

Section pictures makes the figures that are pictures of scenes. Each is a file of
studies/figures: a scene, and what rows and columns change of it. The record has the seconds
of every cell; stated: the largest error that its model states of its numerics, or its noise;
error: relative 2-norm of its exitance against the column `from`, noise of both included.
Pictures of a row have one exposure. Differences are of luminance, blue below and red above;
error maps are logarithmic, from 0.001 (blue) to 1 (red).

The other sections make the figures that need fits, or no scene; studies/bench_charts.py
draws them. Meshes, materials and measured blocks are ours: the papers' are not published.)",
          {{"pictures", "Pictures of scenes, one file each", figure_pictures},
           {"samples", "[W] 10 to 12: four samples, E by number of images", figure_samples},
           {"weights", "[W] 13, 14: three weights, slices beside truth by depth", figure_weights},
           {"stairs", "[T] 4.1: stair steps against cut cells", figure_stairs}},
          {{"figure", "Of pictures: these alone; all if absent", Setting::Kind::words},
           {"files", "Of pictures: their folder (default studies/figures)", Setting::Kind::words},
           {"sample",
            "Of samples: these alone",
            Setting::Kind::words,
            0,
            0,
            {"wax1", "wax2", "marble", "stone"}},
           {"most", "Of samples: the largest n of n x n images (default 8)", Setting::Kind::number,
            1, 8}}};
}

}  // namespace kappamu::studies

// What a block of marble, lit evenly from below, sends out at the top.
#include <kappamu/forward/forward_model.h>

#include <cstdio>

int main() {
  const kappamu::GridShape shape{16, 16, 8, 0.25};  // voxels along x, y, z; their edge [mm]
  kappamu::forward::ForwardProblem block;
  block.setup = {.shape = shape, .eta = 1.3};
  block.medium = {kappamu::Volume<double>(shape, 0.18), kappamu::Volume<double>(shape, 0.005)};
  block.irradiance.assign(16 * 16, 1.0);  // on the lit face, z-
  kappamu::Progress quiet;
  const auto model = kappamu::forward::make_forward_model("multigrid");
  const auto result = model->solve(block, {.device = "reference"}, quiet);
  std::printf("exitance at the centre of z+: %.4f of the light's irradiance\n",
              result.exitance[5][8 * 16 + 8]);
}

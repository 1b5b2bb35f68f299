#include "app/options/block_options.h"

#include <CLI/CLI.hpp>

namespace kappamu::app {

forward::GridSetup BlockOptions::setup(const GridShape& shape) const {
  using forward::Convention;
  using forward::SourceModel;
  forward::GridSetup setup;
  setup.shape = shape;
  setup.eta = eta;
  setup.lit_face = face_from_string(lit_face);
  setup.sides = sides_from_string(sides);
  setup.convention = convention == "wang2008" ? Convention::wang2008 : Convention::physical;
  // wang2008 has one source only, so it is the default there.
  const bool boundary =
      source.value_or(setup.convention == Convention::wang2008 ? "boundary" : "first-collision") ==
      "boundary";
  setup.source = boundary ? SourceModel::boundary : SourceModel::first_collision;
  return setup;
}

void add_block_options(CLI::App& command, BlockOptions& options, forward::SolveOptions& solve) {
  command.add_option("--eta", options.eta, "Relative refractive index (default 1.3)");
  command.add_option("--lit-face", options.lit_face, "Where light enters (default z-)")
      ->check(CLI::IsMember({"x-", "x+", "y-", "y+", "z-", "z+"}))
      ->type_name("FACE");
  command
      .add_option("--sides", options.sides,
                  "open (default): Robin on the four faces beside the lit one; mirror: no flux")
      ->check(CLI::IsMember({"open", "mirror"}));
  command.add_option("--source", options.source, "first-collision (default) or boundary")
      ->check(CLI::IsMember({"first-collision", "boundary"}));
  command.add_option("--convention", options.convention, "physical (default) or wang2008")
      ->check(CLI::IsMember({"physical", "wang2008"}));
  command
      .add_option("--tolerance", solve.tolerance,
                  "Relative residual to reach for every pattern (default 1e-6)")
      ->check(CLI::Range(1e-14, 0.1));
  command.add_option("--max-iterations", solve.max_iterations, "Iterations allowed (default 200)")
      ->check(CLI::Range(1, 100'000'000));
}

}  // namespace kappamu::app

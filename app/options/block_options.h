// The options of a block's forward solve that `kappamu forward` and `kappamu-mpi forward` share.
#pragma once

#include <optional>
#include <string>

#include "forward/block_setup.h"
#include "forward/operator.h"

namespace CLI {
class App;
}

namespace kappamu::app {

struct BlockOptions {
  double eta = 1.3;
  std::string lit_face = "z-";
  std::string sides = "open";
  std::optional<std::string> source;  ///< by the convention, if not given
  std::string convention = "physical";

  forward::GridSetup setup(const GridShape& shape) const;
};

/// `options` and `solve` outlive the parse.
void add_block_options(CLI::App& command, BlockOptions& options, forward::SolveOptions& solve);

}  // namespace kappamu::app

// The commands of kappamu-mpi, a file each. Every rank runs them with the same arguments; the first
// one prints.
#pragma once

namespace CLI {
class App;
}

namespace kappamu::app::mpi {

/// What every command understands, and what it leaves for main().
struct Globals {
  bool json = false;
  int exit_code = 0;  ///< as `kappamu`
};

void add_bench(CLI::App& app, Globals& globals);
void add_fit(CLI::App& app, Globals& globals);
void add_forward(CLI::App& app, Globals& globals);

}  // namespace kappamu::app::mpi

// The subjects of `kappamu bench`, one cmd_bench_<subject>.cpp each.
#pragma once

#include "app/command.h"

namespace kappamu::app {

// Each adds its subcommand to `bench`; `globals` outlives the parse.
void add_bench_calibration(CLI::App& bench, Globals& globals);
void add_bench_choices(CLI::App& bench, Globals& globals);
void add_bench_forward(CLI::App& bench, Globals& globals);
void add_bench_hdr(CLI::App& bench, Globals& globals);
void add_bench_inverse(CLI::App& bench, Globals& globals);
void add_bench_limits(CLI::App& bench, Globals& globals);
void add_bench_rig(CLI::App& bench, Globals& globals);
void add_bench_slabs(CLI::App& bench, Globals& globals);
void add_bench_uncertainty(CLI::App& bench, Globals& globals);
void add_bench_validity(CLI::App& bench, Globals& globals);

}  // namespace kappamu::app

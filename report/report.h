// The report of a run: one self-contained HTML file, no script, nothing loaded from elsewhere.
#pragma once

#include <filesystem>

namespace kappamu::report {

/// Reads the run folder and writes `file` by rename. Parts the run does
/// not have are left out with a sentence. Throws InputError when `run` holds nothing to report or a
/// file in it is damaged.
void write_report(const std::filesystem::path& run, const std::filesystem::path& file);

}  // namespace kappamu::report

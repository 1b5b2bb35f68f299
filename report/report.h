// The report of a run: one self-contained HTML file, no script, nothing loaded from elsewhere.
#pragma once

#include <filesystem>

namespace kappamu::report {

/// Reads the run folder and writes run/report.html by rename; returns that path. Parts the run does
/// not have are left out with a sentence. Throws InputError when `run` holds nothing to report or a
/// file in it is damaged.
std::filesystem::path write_report(const std::filesystem::path& run);

}  // namespace kappamu::report

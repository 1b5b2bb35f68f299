#include "report/report.h"

#include "io/atomic_file.h"
#include "report/drawing/page.h"
#include "report/drawing/slices.h"
#include "report/sections.h"

namespace kappamu::report {

namespace {

std::string subject(const RunData& run) {
  if (run.session) return run.session->sample.name;
  if (run.record && !run.record->input.empty()) return run.record->input.filename().string();
  return run.folder.filename().string();
}

}  // namespace

void write_report(const std::filesystem::path& run, const std::filesystem::path& file) {
  const RunData data = read_run(run);
  const std::string title = "kappamu report: " + subject(data);
  const Html body = element("h1", text(subject(data))) +
                    element("p", {{"class", "subtitle"}},
                            text("kappamu: acquisition of diffusion and absorption volumes · " +
                                 data.folder.parent_path().filename().string() + "/" +
                                 data.folder.filename().string())) +
                    verdict_section(data) + volumes_section(data) + comparison_section(data) +
                    uncertainty_section(data) + convergence_section(data) + capture_section(data) +
                    calibration_section(data) + radiometry_section(data) +
                    provenance_section(data) + element("script", raw(slider_script));
  io::write_text_atomically(file, whole_page(title, body).markup());
}

}  // namespace kappamu::report

#include <algorithm>
#include <filesystem>

#include "report/sections.h"

namespace kappamu::report {

std::vector<std::string> all_warnings(const RunData& run) {
  std::vector<std::string> result;
  // A stage's own file repeats what it wrote to the run's record, there with the stage's name
  // before it.
  const auto is_known = [&](const std::string& warning) {
    return std::any_of(result.begin(), result.end(), [&](const std::string& known) {
      return known.find(warning) != std::string::npos;
    });
  };
  const auto add = [&](const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings)
      if (!is_known(warning)) result.push_back(warning);
  };
  if (run.record)
    for (const char* name : pipeline::stage_names)
      if (const auto stage = run.record->stages.find(name); stage != run.record->stages.end())
        add(stage->second.warnings);
  if (run.calibration) add(run.calibration->warnings);
  if (run.fit) add(run.fit->warnings);
  return result;
}

namespace {

Html warnings_block(const RunData& run) {
  const std::vector<std::string> warnings = all_warnings(run);
  if (warnings.empty()) return paragraph("None.");
  Html items;
  for (const std::string& warning : warnings) items += element("li", text(warning));
  return element("ul", {{"class", "warnings"}}, items);
}

Html timings_table(const pipeline::RunRecord& record) {
  std::vector<std::vector<Html>> rows;
  double total = 0.0;
  for (const char* name : pipeline::stage_names) {
    const auto stage = record.stages.find(name);
    if (stage == record.stages.end() || stage->second.status != pipeline::StageStatus::done)
      continue;
    rows.push_back({text(name), text(duration(stage->second.seconds))});
    total += stage->second.seconds;
  }
  rows.push_back({element("strong", text("total")), element("strong", text(duration(total)))});
  return table({"Stage", "wall time"}, rows);
}

/// Paths are relative to the run's folder: where that lies is no reader's business.
Html origin_table(const pipeline::RunRecord& record, const std::filesystem::path& run) {
  std::vector<std::vector<Html>> rows{
      {text(record.input_kind == pipeline::RunRecord::InputKind::session ? "session"
                                                                         : "measurements"),
       text(record.input.lexically_proximate(run).generic_string())},
      {text("fingerprint"), text(record.input_fingerprint)},
      {text("device"), text(record.device.empty() ? "not recorded" : record.device)}};
  for (const auto& [name, value] : record.options)
    rows.push_back({text("option " + name), text(value)});
  for (const auto& [name, value] : record.versions) rows.push_back({text(name), text(value)});
  return element("details",
                 element("summary", text("options, versions, inputs")) + table({}, rows));
}

}  // namespace

Html provenance_section(const RunData& run) {
  Html content = subsection("Warnings", warnings_block(run));
  if (!run.record)
    content += note("There is no run.json: times, options and device were not recorded.");
  else
    content += row({subsection("Times", timings_table(*run.record)),
                    subsection("How it was made", origin_table(*run.record, run.folder))});
  return section("Warnings, times, provenance", content);
}

}  // namespace kappamu::report

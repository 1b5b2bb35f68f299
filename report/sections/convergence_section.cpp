#include "report/drawing/chart.h"
#include "report/drawing/picture.h"
#include "report/sections.h"

namespace kappamu::report {

Html convergence_section(const RunData& run) {
  if (!run.fit || run.fit->convergence.empty())
    return section("Convergence", note("This run has no convergence history."));
  LineChart objective;
  objective.x_label = "adjoint solves, all grids";
  objective.y_label = "objective";
  objective.log_y = true;
  LineChart chi2 = objective;
  chi2.y_label = "χ² per value";
  chi2.reference = 1.0;
  chi2.reference_label = "noise level";
  std::vector<std::vector<Html>> rows;
  for (std::size_t c = 0; c < run.fit->convergence.size(); ++c) {
    const Convergence& channel = run.fit->convergence[c];
    const std::string colour = channel_colour(channel.channel, c);
    objective.series.push_back(
        {channel.channel, colour, channel.adjoint_solves, channel.objective, false});
    chi2.series.push_back({channel.channel, colour, channel.adjoint_solves, channel.chi2});
    rows.push_back(
        {text(channel.channel), text(channel.model.empty() ? "–" : channel.model),
         text(channel.status), text(channel.reason),
         text(channel.adjoint_solves.empty() ? "–" : number(channel.adjoint_solves.back(), 4)),
         text(number(channel.chi2_per_value)),
         text(channel.seconds ? duration(*channel.seconds) : "–")});
  }
  Html content;
  if (render(objective).empty())
    content += note("The fit recorded no objective values.");
  else
    content += row({figure(render(objective),
                           "Objective; it jumps where the regularisation weight is lowered or a "
                           "finer grid begins"),
                    figure(render(chi2), "How far the data are explained")});
  content += table(
      {"Channel", "model", "status", "stopped because", "adjoint solves", "χ² per value", "time"},
      rows);
  for (const Convergence& channel : run.fit->convergence) {
    if (!channel.model_reason.empty()) {
      content +=
          note("Model of " + channel.channel + ": " + channel.model + ". " + channel.model_reason);
    }
    for (const std::string& sentence : channel.notes)
      content += note(channel.channel + ": " + sentence);
  }
  return section("Convergence", content);
}

}  // namespace kappamu::report

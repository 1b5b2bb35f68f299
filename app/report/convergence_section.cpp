#include "app/report/chart.h"
#include "app/report/sections.h"

namespace kappamu::app::report {

Html convergence_section(const RunData& run) {
  if (!run.fit || run.fit->convergence.empty())
    return section("Convergence", note("This run has no convergence history."));
  LineChart chart;
  chart.x_label = "gradient evaluations";
  chart.y_label = "objective";
  chart.log_y = true;
  chart.width = 720;
  std::vector<std::vector<Html>> rows;
  for (std::size_t c = 0; c < run.fit->convergence.size(); ++c) {
    const Convergence& channel = run.fit->convergence[c];
    chart.series.push_back({channel.channel, channel_colour(channel.channel, c),
                            channel.evaluations, channel.objective, false});
    rows.push_back({text(channel.channel), text(channel.converged ? "yes" : "no"),
                    text(channel.reason),
                    text(channel.evaluations.empty() ? "–" : number(channel.evaluations.back(), 4)),
                    text(number(channel.chi2_per_value)),
                    text(channel.seconds ? duration(*channel.seconds) : "–")});
  }
  const Html plot = render(chart);
  Html content;
  if (plot.empty())
    content += note("The fit recorded no objective values.");
  else
    content += element("figure",
                       plot + element("figcaption", text("Objective over gradient evaluations, log "
                                                         "scale; steps mark a lower regularisation "
                                                         "weight or a finer grid")));
  content += table(
      {"Channel", "converged", "stopped because", "evaluations", "χ² per value", "time"}, rows);
  return section("Convergence", content);
}

}  // namespace kappamu::app::report

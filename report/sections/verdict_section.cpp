// The verdict on top of the page, as the fit's record has it.
#include "report/sections.h"

namespace kappamu::report {

namespace {

std::string capitalised(std::string clause) {
  if (clause.front() >= 'a' && clause.front() <= 'z') clause.front() += 'A' - 'a';
  return clause + ".";
}

}  // namespace

Html verdict_section(const RunData& run) {
  const pipeline::Verdict verdict = run.fit ? run.fit->verdict : pipeline::Verdict{};
  const std::string headline = run.fit ? verdict.sentence : "There is no fit in this run yet.";
  Html lines;
  for (const pipeline::Criterion& criterion : verdict.criteria)
    lines += element(
        "tr", element("td", element("span", {{"class", "lamp " + to_string(criterion.grade)}},
                                    text(""))) +
                  element("th", text(criterion.name)) +
                  element("td", text(capitalised(criterion.reason))));
  Html content = element("h2", text(headline)) +
                 element("table", {{"class", "criteria"}}, element("tbody", lines));
  if (run.fit)
    content += note(
        "E = Σ(L′ − L)²/ΣL², the appearance error, compares light L′ predicted by the volumes with "
        "measured light L, over all channels. χ² per value is the mean of (L′ − L)²/σ² over the "
        "fitted values of a channel: 1 where volumes and stated variances σ² are right.");
  return element("section", {{"class", "verdict " + to_string(verdict.grade)}}, content);
}

}  // namespace kappamu::report

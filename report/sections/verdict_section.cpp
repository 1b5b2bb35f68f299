// The page's first screen: the verdict as the fit's record has it, what the block is made of, what
// to do next.
#include <array>

#include "report/drawing/cutaway.h"
#include "report/drawing/picture.h"
#include "report/sections.h"

namespace kappamu::report {

namespace {

constexpr int cutaway_width = 360;  // CSS px

/// Where the page shows what a criterion is about, and what to do where it is not green.
struct Advice {
  const char* criterion;
  const char* section;
  const char* next;
};
constexpr std::array<Advice, 5> advices{
    {{"Fit", "Measured against re-rendered",
      "Look at the residual maps: what follows the block's edges is a pose that is off, what "
      "follows the light is "
      "scale or response, spots are dirt on a face. Mend it there and run again; where a channel "
      "ran out of steps, "
      "continue the fit."},
     {"Validation", "Measured against re-rendered",
      "Photograph more patterns, or continue the fit with a larger target for chi2, which makes "
      "the "
      "volume smoother."},
     {"Coverage", "What was captured",
      "Add exposures until nothing that is needed is saturated or unseen."},
     {"Calibration", "Geometric calibration",
      "Take the views with the largest reprojection RMS again, sharp and with the board flat."},
     {"Warnings", "Warnings, times, provenance", "Read the warnings; each names its cause."}}};

std::string capitalised(std::string clause) {
  if (clause.front() >= 'a' && clause.front() <= 'z') clause.front() += 'A' - 'a';
  return clause + ".";
}

Html code(const std::string& command) {
  return element("code", text(command));
}

const Advice* advice_for(const std::string& criterion) {
  for (const Advice& advice : advices) {
    if (criterion == advice.criterion) return &advice;
  }
  return nullptr;
}

Html criteria_table(const pipeline::Verdict& verdict) {
  Html lines;
  for (const pipeline::Criterion& criterion : verdict.criteria) {
    const Advice* advice = advice_for(criterion.name);
    const Html name = text(criterion.name);
    lines += element(
        "tr",
        element("td",
                element("span", {{"class", "lamp " + to_string(criterion.grade)}}, text(""))) +
            element("th",
                    advice ? element("a", {{"href", "#" + anchor(advice->section)}}, name) : name) +
            element("td", text(capitalised(criterion.reason))));
  }
  return element("table", {{"class", "criteria"}}, element("tbody", lines));
}

Html next_steps(const RunData& run, const pipeline::Verdict& verdict) {
  const std::string folder = run.folder.filename().string();
  Html items;
  for (const pipeline::Criterion& criterion : verdict.criteria) {
    const Advice* advice = advice_for(criterion.name);
    if (!advice || criterion.grade < pipeline::Grade::amber) continue;
    items += element("li", text(advice->next));
  }
  if (items.empty()) {
    items = element("li", code("kappamu view " + folder) + text(" turns lights round it")) +
            element("li", code("kappamu export " + folder) + text(" gives it to other programs, ") +
                              code("kappamu edit") + text(" changes it"));
  }
  return subsection("What to do next", element("ul", {{"class", "next"}}, items));
}

}  // namespace

Html verdict_section(const RunData& run) {
  const pipeline::Verdict verdict = run.fit ? run.fit->verdict : pipeline::Verdict{};
  const std::string headline = run.fit ? verdict.sentence : "There is no fit in this run yet.";
  Html words = element("h2", text(headline)) + criteria_table(verdict);
  if (run.fit) words += next_steps(run, verdict);
  Html content = element("div", words);
  if (run.fit && !run.fit->media.empty()) {
    const double eta = run.session ? run.session->sample.eta : 1.3;
    content += element("div", figure(picture(cutaway(run.fit->media, eta, 2 * cutaway_width),
                                             cutaway_width, "the fitted block"),
                                     "The fitted block, a corner cut away: the colour a thick "
                                     "piece of each voxel's material has in "
                                     "white light. Light enters the face in front."));
  }
  content = element("div", {{"class", "first"}}, content);
  if (run.fit)
    content += note(
        "E = Σ(L′ − L)²/ΣL², the appearance error, compares light L′ predicted by the volumes with "
        "measured light L, over all channels. χ² per value is the mean of (L′ − L)²/σ² over the "
        "fitted values of a channel: 1 where volumes and stated variances σ² are right.");
  return element("section", {{"class", "verdict " + to_string(verdict.grade)}}, content);
}

}  // namespace kappamu::report

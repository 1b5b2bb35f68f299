#include "report/drawing/page.h"

#include "report/drawing/slices.h"

namespace kappamu::report {

namespace {

constexpr const char* style = R"(
:root { --ink: #1f2a33; --muted: #66727d; --line: #dfe4e8; --green: #2e8b57; --amber: #d08a1d; --red: #c0392b; --grey: #9aa3ad; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 28px 32px 64px; max-width: 1200px; color: var(--ink); background: #fff;
       font: 15px/1.5 "Source Sans 3", "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif; }
h1 { font-size: 28px; font-weight: 600; margin: 0; }
h2 { font-size: 20px; font-weight: 600; margin: 0 0 10px; }
h3 { font-size: 15px; font-weight: 600; margin: 0 0 8px; }
section { overflow-x: auto; margin-top: 34px; padding-top: 18px; border-top: 1px solid var(--line); }
.subsection { margin: 18px 0 8px; }
.note, figcaption, .unit, .subtitle { color: var(--muted); font-size: 13px; }
.note { max-width: 860px; }
.subtitle { margin: 2px 0 0; }
.row { display: flex; flex-wrap: wrap; gap: 14px 20px; align-items: flex-start; }
.row > .block > .subsection { margin-top: 0; }
figure { margin: 0; }
figcaption { margin-top: 4px; max-width: 520px; }
figure img { display: inline-block; margin-right: 6px; }
img { image-rendering: pixelated; vertical-align: top; background: #eef0f2; }
svg text { font: 12px "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif; }
table { border-collapse: collapse; font-size: 14px; font-variant-numeric: tabular-nums; }
th, td { padding: 4px 14px 4px 0; text-align: right; border-bottom: 1px solid var(--line); vertical-align: top; }
th { font-weight: 600; color: var(--muted); font-size: 13px; }
th:first-child, td:first-child { text-align: left; }
td:nth-child(2):last-child { text-align: left; overflow-wrap: anywhere; max-width: 620px; }
.pictures td, .pictures th { text-align: left; padding: 5px 8px 5px 0; border: 0; }
.figures { font-size: 12.5px; color: var(--muted); white-space: nowrap; }
.verdict { border: 1px solid var(--line); border-left: 10px solid var(--grey); border-radius: 6px; padding: 18px 24px; background: #fafbfc; }
.verdict.green { border-left-color: var(--green); } .verdict.amber { border-left-color: var(--amber); } .verdict.red { border-left-color: var(--red); }
.verdict h2 { font-size: 24px; }
.criteria th, .criteria td { text-align: left; font-size: 15px; color: var(--ink); border: 0; padding: 4px 16px 4px 0; }
.criteria td:nth-child(1) { width: 24px; } .criteria th { white-space: nowrap; }
.lamp { display: inline-block; width: 14px; height: 14px; border-radius: 50%; background: var(--grey); margin-top: 4px; }
.lamp.green { background: var(--green); } .lamp.amber { background: var(--amber); } .lamp.red { background: var(--red); }
.legend { margin: 6px 0 10px; } .legend .bar { image-rendering: auto; display: block; }
.legend .marks { display: flex; justify-content: space-between; font-size: 12px; font-variant-numeric: tabular-nums; }
.legend .unit { white-space: nowrap; }
.stack > div { display: none; } .stack > .shown { display: block; }
.slider { display: flex; gap: 14px; align-items: center; color: var(--muted); font-size: 13px; } .slider input { flex: 0 1 420px; }
.first { display: flex; flex-wrap: wrap; gap: 20px 32px; } .first > div:first-child { flex: 1 1 420px; min-width: 0; }
.first img { image-rendering: auto; background: none; max-width: 100%; height: auto; } .next { margin: 4px 0 0; padding-left: 20px; }
code { font: 13px "DejaVu Sans Mono", monospace; background: #eef0f2; padding: 1px 5px; border-radius: 3px; overflow-wrap: anywhere; }
details { margin-top: 12px; } summary { color: var(--muted); cursor: pointer; }
.warnings { margin: 0; padding-left: 20px; }
@media (max-width: 560px) {
  body { padding: 16px 14px 40px; } .verdict { padding: 12px 14px; border-left-width: 6px; }
  .criteria tr { display: grid; grid-template-columns: 24px 1fr; } .criteria td:last-child { grid-column: 2; }
}
@media print { section { break-inside: avoid-page; } }
)";

}  // namespace

Html whole_page(const std::string& title, const Html& body) {
  // Nothing is loaded and nothing but the slider runs, whatever a name in the data contains.
  const Html head = raw("<meta charset=\"utf-8\"/>\n") +
                    raw("<meta http-equiv=\"Content-Security-Policy\" content=\"default-src "
                        "'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-" +
                        std::string(slider_script_sha256) + "'\"/>\n") +
                    raw("<meta name=\"viewport\" content=\"width=device-width\"/>\n") +
                    element("title", text(title)) + element("style", raw(style));
  return raw("<!DOCTYPE html>\n") +
         element("html", {{"lang", "en"}}, element("head", head) + element("body", body));
}

}  // namespace kappamu::report

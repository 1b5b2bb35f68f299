#include "pipeline/fit_folder.h"

#include "pipeline/fit_files.h"
#include "pipeline/output_folder.h"
#include "pipeline/records/fingerprint.h"
#include "pipeline/stages/continuation.h"

namespace kappamu::pipeline {

FitSummary fit_folder(FitFolders folders, FitStageOptions options, Progress& progress) {
  if (folders.continued) {
    const FinishedFit finished(*folders.continued);
    options.continue_from = finished.folder();
    if (folders.input.empty()) folders.input = finished.present_input();
    if (folders.out.empty()) folders.out = finished.folder().string() + "_continued";
  }
  const std::string key = Fingerprint()
                              .add(options_json(options))
                              .add(measurements_fingerprint(find_measurements(folders.input)))
                              .text();
  OutputFolder folder(folders.out, "fit", fit_inputs(folders.input, options),
                      fit_outputs(folders.out), Former::removed, key,
                      options.restart ? Interrupted::removed : Interrupted::continued);
  FitSummary summary = run_fit_stage(folders.input, folder.partial(), options, progress);
  summary.volume = folders.out / "volume.vdb";
  folder.commit();
  return summary;
}

}  // namespace kappamu::pipeline

// Whether a fit uses the pixels that were measured where light falls: by transport, which holds
// there for one κ and one μ under slowly varying light (inverse/problem/lit_face.h). Volumes are
// fitted without them.
#pragma once

#include <string>

#include "pipeline/fit_files.h"
#include "pipeline/records/fit_options.h"

namespace kappamu::pipeline {

struct LitPixels {
  FitStageOptions
      options;         ///< of the fit: its model is homogeneous where nothing but lit pixels is
  std::string note{};  ///< a sentence for the user; empty where no pixel is lit
  bool used = false;
};

/// Puts them into `input` or leaves them out, and says which. Throws InputError where every pixel
/// is lit and the fit asked for has no use of them.
LitPixels choose_lit_pixels(FitInput& input, const FitStageOptions& options);

}  // namespace kappamu::pipeline

#include "pipeline/lit_pixels.h"

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "core/shown_text.h"
#include "inverse/problem/lit_face.h"

namespace kappamu::pipeline {

namespace {

using inverse::Model;

bool any(const std::vector<std::uint8_t>& flags) {
  return std::ranges::any_of(flags, [](std::uint8_t flag) { return flag != 0; });
}

/// Why the fit asked for cannot use them; empty where it can.
std::string unfit(const FitStageOptions& options) {
  if (options.fit.data.convention != forward::Convention::physical) {
    return "the paper's convention has no transport";
  }
  if (!options.fit.path.correct_grid) return "the grid is not corrected";
  return {};
}

}  // namespace

LitPixels choose_lit_pixels(FitInput& input, const FitStageOptions& options) {
  LitPixels chosen{.options = options};
  SurfaceMeasurements& measured = input.measurements;
  if (!any(measured.lit)) return chosen;
  const bool others = measured.mask.empty() || any(measured.mask);
  Model& model = chosen.options.fit.path.model;
  if (!others && model == Model::automatic) model = Model::homogeneous;
  std::string why = unfit(options), noisy;
  if (model != Model::homogeneous) {
    why = "diffusion does not describe them, and transport does for a homogeneous block alone";
  }
  try {
    if (!why.empty()) throw InputError(why);
    inverse::LitPixelUse use = inverse::with_lit_pixels(measured);
    measured = std::move(use.measurements);
    constexpr double told = 2.0;  // standard deviations
    if (use.noise > told * use.stated) {
      noisy = " Their values scatter by " + shown_number(100.0 * use.noise, "%.2g") +
              " % from voxel to voxel, beyond the " + shown_number(100.0 * use.stated, "%.2g") +
              " % stated: grain, or a simulation's photons; it counts as noise.";
    }
  } catch (const InputError& reason) {
    if (!others) {
      throw InputError("every pixel of the seen face is lit, and lit pixels cannot be used: " +
                           std::string(reason.what()) +
                           "; fit a homogeneous block, or measure maps",
                       {{"model"}});
    }
    chosen.note = "Lit pixels are left out: " + std::string(reason.what()) + ".";
    return chosen;
  }
  chosen.used = true;
  if (input.validation) inverse::use_lit_pixels(*input.validation);
  chosen.note = "Lit pixels are used under slowly varying light, by transport with anisotropy " +
                shown_number(inverse::lit_anisotropy, "%.2g") +
                (options.fit.path.model == Model::automatic
                     ? "; every pixel is lit, so the block is taken as homogeneous."
                     : ".") +
                noisy;
  return chosen;
}

}  // namespace kappamu::pipeline

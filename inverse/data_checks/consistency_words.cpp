// Findings on scale, pose and eta as sentences.
#include <cmath>
#include <string>
#include <vector>

#include "core/shown_text.h"
#include "inverse/data_checks/consistency.h"

namespace kappamu::inverse {

namespace {

std::string scale_sentence(const Consistency& c) {
  const double low = std::exp(c.log_scale.value - 2.0 * c.log_scale.error);
  const double high = std::exp(c.log_scale.value + 2.0 * c.log_scale.error);
  return formatted(
      "All values are about %.2f times (%.2f to %.2f) what a homogeneous block would show%s: kappa "
      "and mu absorb such a factor and are then wrong. Check the white reference, the exposure "
      "times and eta, and whether diffusion holds in so thick or thin a block.",
      std::exp(c.log_scale.value), low, high,
      c.explained ? ", and with that factor it explains the data to their noise"
                  : ", more than the structure of usual blocks does to this figure");
}

}  // namespace

std::string brightness_sentence(const Consistency& c) {
  const VolumeErrors& found = *c.by_volume;
  return formatted(
      "All values seem too high, by more than the factor of %.2f that the volume shows: %.0f %% of "
      "its roughness is due to them, and kappa and mu that absorb them are wrong. Check the white "
      "reference, the exposure times and eta, and whether diffusion holds in so thick or thin a "
      "block.",
      std::exp(found.log_scale->value), 100.0 * found.scale_gain);
}

std::string shift_sentence(const Consistency& c, const GridShape& grid, Face seen_face) {
  std::string towards;
  const auto part = [&](double shift, int axis) {
    if (std::abs(shift) < 0.5 * c.shift_limit) return;
    towards += formatted("%s%.1f voxels (%.2f mm) towards %c%c", towards.empty() ? "" : " and ",
                         std::abs(shift), std::abs(shift) * grid.voxel_mm, shift > 0.0 ? '+' : '-',
                         "xyz"[axis]);
  };
  const auto [u, v] = face_axes(seen_face);
  part(c.shift_u.value, u);
  part(c.shift_v.value, v);
  return "The images sit " + towards +
         " of where the light would put them: check the sample pose, the projector's calibration "
         "and that irradiance and values are of the same patterns, in the same order.";
}

std::vector<std::string> warnings_of(const Consistency& consistency, const Problem& problem) {
  std::vector<std::string> warnings;
  if (!consistency.checked && problem.patterns >= fewest_patterns) {
    warnings.emplace_back(
        "Whether scale and pose of the data are right could not be checked: no homogeneous block "
        "comes near them; look at exposure, variances and masks.");
  } else if (!consistency.checked) {
    warnings.emplace_back(
        "With fewer than four patterns neither a wrong absolute scale nor a shift of the images "
        "can be distinguished from structure of the block: measure more.");
  }
  if (consistency.other_eta) {
    warnings.push_back(
        formatted("A homogeneous block explains the data to their noise with eta %.2f, not with "
                  "the stated %.2f: check eta of the sample.",
                  *consistency.other_eta, problem.setup.eta));
  } else if (consistency.block_scale_is_wrong()) {
    warnings.push_back(scale_sentence(consistency));
  }
  return warnings;
}

std::string in_words(const Consistency& consistency, double eta) {
  if (!consistency.checked) return {};
  std::string words = formatted(
      "The homogeneous block that suits the data best makes them %.2f times what they should be; "
      "an "
      "error is reported beyond a factor of %.2f. The %s makes them %.2f voxels off; a shift is "
      "reported beyond %.2f voxels.",
      std::exp(consistency.log_scale.value), std::exp(consistency.log_scale_limit),
      consistency.volume_shift ? "fitted volume" : "same block",
      std::hypot(consistency.shift_u.value, consistency.shift_v.value), consistency.shift_limit);
  if (!consistency.explained && !consistency.other_eta) {
    words += formatted(
        " Only a block that is homogeneous to the noise determines its eta: kappa and mu hold "
        "for the stated %.2f.",
        eta);
  }
  return words;
}

}  // namespace kappamu::inverse

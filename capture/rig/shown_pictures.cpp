#include "capture/rig/shown_pictures.h"

#include <utility>

#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"

namespace kappamu::capture {

std::string numbered(const std::string& stem, std::size_t number) {
  return stem + formatted("%02zu", number);
}

std::string level_picture(int value) {
  return "calibration/level_" + std::to_string(value) + ".png";
}

std::string gray_picture(std::size_t number) {
  return numbered("calibration/gray_code_", number) + ".png";
}

std::string phase_picture(std::size_t set, std::size_t step) {
  return "calibration/phase_" + std::to_string(set) + "_" + std::to_string(step) + ".png";
}

std::string pattern_picture(const PlannedPattern& pattern) {
  return "patterns/" + pattern.id + ".png";
}

std::map<std::string, Image<std::uint8_t>> shown_pictures(const CapturePlan& plan,
                                                          const Projector& projector) {
  const auto uniform = [&](std::uint8_t value) { return make_uniform_image(projector, value); };
  std::map<std::string, Image<std::uint8_t>> pictures{{"black", uniform(0)},
                                                      {"white", uniform(255)}};
  for (const std::uint8_t value : plan.projector_levels) {
    pictures[level_picture(value)] = uniform(value);
  }
  if (chessboards(plan.plane_light)) {
    pictures[board_picture] = make_chessboard_image(projector, plan.projected_board);
  }
  if (gray_codes(plan.plane_light)) {
    std::vector<Image<std::uint8_t>> code = make_gray_code_images(projector);
    for (std::size_t k = 0; k < code.size(); ++k) {
      pictures[gray_picture(k)] = std::move(code[k]);
    }
  }
  if (plan.plane_light == PlaneLight::phase_shift) {
    const std::vector<PhaseShift> sets = usual_phase_shift(projector);
    for (std::size_t s = 0; s < sets.size(); ++s) {
      auto images = make_phase_shift_images(projector, sets[s], usual_phase_steps);
      for (std::size_t n = 0; n < images.size(); ++n) {
        pictures[phase_picture(s, n)] = std::move(images[n]);
      }
    }
  }
  for (const PlannedPattern& pattern : plan.patterns) {
    pictures[pattern_picture(pattern)] = pattern.image;
  }
  return pictures;
}

void check_plan(const CapturePlan& plan, const Projector& projector) {
  const std::string where = "capture plan: ";
  if (plan.exposures_s.empty()) {
    throw InputError(where + "exposures_s is empty; list at least one exposure time.");
  }
  for (const std::string& station : {plan.calibration_station, plan.pattern_station}) {
    require_plain_name(station, where + "a station's name");
  }
  for (const PlannedPattern& pattern : plan.patterns) {
    require_plain_name(pattern.id, where + "the id of a pattern");
    if (pattern.image.width() != projector.width || pattern.image.height() != projector.height ||
        pattern.image.channels() != 1) {
      throw InputError(
          where + "the image of pattern " + pattern.id + " is " +
          std::to_string(pattern.image.width()) + " x " + std::to_string(pattern.image.height()) +
          " in " + std::to_string(pattern.image.channels()) +
          " channels; make it grey and of the projector's " + std::to_string(projector.width) +
          " x " + std::to_string(projector.height) + ".");
    }
  }
}

bool chessboards(PlaneLight light) {
  return light == PlaneLight::chessboard || light == PlaneLight::both;
}

bool gray_codes(PlaneLight light) {
  return light == PlaneLight::gray_code || light == PlaneLight::both;
}

PlaneLight plane_light_from_string(const std::string& text) {
  if (const auto light = value_of(plane_light_names, text)) return *light;
  throw InputError("the light on the projector's planes is '" + text + "'; write " +
                   list_of(plane_light_names) + ".");
}

}  // namespace kappamu::capture

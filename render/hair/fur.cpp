#include "render/hair/fur.h"

#include <algorithm>

namespace kappamu::render {

bool FurChange::empty() const {
  return std::none_of(std::begin(numbers), std::end(numbers),
                      [](const auto& number) { return number.has_value(); }) &&
         !root_colour && !tip_colour && !reflectance && strokes.empty();
}

void FurChange::change(Fur& fur) const {
  for (std::size_t i = 0; i < fur_number_count; ++i) {
    if (numbers[i]) fur.*fur_numbers[i].of = *numbers[i];
  }
  if (root_colour) fur.root_colour = *root_colour;
  if (tip_colour) fur.tip_colour = *tip_colour;
  if (reflectance) fur.reflectance = *reflectance;
  if (fur.tile_mm) {
    fur.tile_mm =
        std::clamp(*fur.tile_mm, least_tile * fur.length_mm, largest_tile * fur.length_mm);
  }
  fur.strokes.insert(fur.strokes.end(), strokes.begin(), strokes.end());
}

FurChange change_between(const Fur& before, const Fur& after) {
  FurChange change;
  for (std::size_t i = 0; i < fur_number_count; ++i) {
    const auto of = fur_numbers[i].of;
    if (after.*of != before.*of) change.numbers[i] = after.*of;
  }
  if ((after.root_colour != before.root_colour).any()) change.root_colour = after.root_colour;
  if ((after.tip_colour != before.tip_colour).any()) change.tip_colour = after.tip_colour;
  if (after.reflectance != before.reflectance) change.reflectance = after.reflectance;
  const std::size_t known = std::min(before.strokes.size(), after.strokes.size());
  change.strokes.assign(after.strokes.begin() + static_cast<std::ptrdiff_t>(known),
                        after.strokes.end());
  return change;
}

std::string described(const FurChange& change) {
  std::string text;
  const auto add = [&](const std::string& name) { text += (text.empty() ? "" : ", ") + name; };
  for (std::size_t i = 0; i < fur_number_count; ++i) {
    if (change.numbers[i]) add(fur_numbers[i].name);
  }
  if (change.root_colour) add("root_colour");
  if (change.tip_colour) add("tip_colour");
  if (change.reflectance) add(*change.reflectance);
  if (!change.strokes.empty()) {
    add("brush of " + std::string(name_of(fur_brushes, change.strokes.back().of)));
  }
  return text;
}

}  // namespace kappamu::render

#include <algorithm>
#include <utility>

#include "render/edit/history.h"

namespace kappamu::render {

EditList with_deformations(EditList list, const std::vector<Deformation>& unedited,
                           const std::vector<Deformation>& wanted) {
  const auto begins_with = [&](const std::vector<Deformation>& first) {
    return wanted.size() >= first.size() && std::equal(first.begin(), first.end(), wanted.begin());
  };
  std::vector<Deformation> before = unedited;
  const auto instead =
      std::find_if(list.begin(), list.end(), [](const auto& edit) { return edit->instead; });
  if (instead != list.end() && !(*instead)->off) before = (*instead)->deformations;
  const bool goes_on = begins_with(before);
  auto next = wanted.begin() + static_cast<std::ptrdiff_t>(goes_on ? before.size() : 0);
  const auto edit_of = [](std::vector<Deformation> deformations, bool all) {
    Edit edit;
    edit.operation = Operation::deform;
    edit.deformations = std::move(deformations);
    edit.instead = all;
    return std::make_shared<const Edit>(std::move(edit));
  };
  EditList result;
  bool stated = goes_on;
  for (const auto& edit : list) {
    if (edit->operation != Operation::deform || edit->off || (edit->instead && goes_on)) {
      result.push_back(edit);
      continue;
    }
    if (!stated) {
      result.push_back(edit_of({next, wanted.end()}, true));
      next = wanted.end();
      stated = true;
      continue;
    }
    const auto left = static_cast<std::size_t>(wanted.end() - next);
    const auto end = next + static_cast<std::ptrdiff_t>(std::min(left, edit->deformations.size()));
    const std::vector<Deformation> these(next, end);
    if (!these.empty()) {
      result.push_back(these == edit->deformations ? edit : edit_of(these, false));
    }
    next = end;
  }
  if (!stated) result.push_back(edit_of({next, wanted.end()}, true));
  if (!stated) next = wanted.end();
  for (; next != wanted.end(); ++next) result.push_back(edit_of({*next}, false));
  return result;
}

}  // namespace kappamu::render

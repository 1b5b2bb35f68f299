#include "render/edit/history.h"

#include <algorithm>
#include <utility>

#include "core/error.h"

namespace kappamu::render {

std::size_t EditHistory::put(const VoxelDifference& difference,
                             VoxelValue VoxelDifference::Change::*side) {
  ++revision_;
  for (std::size_t c = 0; c < difference.channels.size(); ++c) {
    for (const VoxelDifference::Change& change : difference.channels[c]) {
      const VoxelValue& value = change.*side;
      volume_.media[c].kappa[change.voxel] = value.kappa;
      volume_.media[c].mu[change.voxel] = value.mu;
      if (!volume_.kappa_std.empty()) volume_.kappa_std[c][change.voxel] = value.kappa_std;
      if (!volume_.mu_std.empty()) volume_.mu_std[c][change.voxel] = value.mu_std;
    }
  }
  return difference.voxels();
}

std::size_t EditHistory::apply(const std::shared_ptr<const Edit>& edit, std::vector<Step>& to) {
  Step step{edit, {}, volume_.eta};
  std::size_t changed = 0;
  if (!edit->off) {
    if (edit->operation == Operation::deform && shapes_ == nullptr) {
      throw InputError("it deforms an object, and there is none; edit a scene's object");
    }
    if (edit->operation == Operation::fur && (shapes_ == nullptr || !shapes_->has_fur())) {
      throw InputError("it edits fur, and the object has none; give it 'fur' in its scene");
    }
    refine_for(*edit);
  }
  if (!edit->off && !edit->of_form()) {
    step.difference = difference_of(*edit, volume_, body_for(*edit));
    changed = put(step.difference, &VoxelDifference::Change::after);
    if (edit->eta) volume_.eta = edit->eta;  // put() counts this as well
  }
  to.push_back(std::move(step));
  return changed;
}

std::vector<Deformation> EditHistory::deformations() const {
  std::vector<Deformation> all;
  if (shapes_ != nullptr) all = shapes_->unedited();
  for (const std::vector<Step>* steps : {&steps_, &trial_}) {
    for (const Step& step : *steps) step.edit->deform_on(all);
  }
  return all;
}

void EditHistory::change(Fur& fur) const {
  for (const std::vector<Step>* steps : {&steps_, &trial_}) {
    for (const Step& step : *steps) step.edit->change(fur);
  }
}

/// Of the shape that the edits so far have left.
const EditedBody* EditHistory::body_for(const Edit& edit) const {
  if (shapes_ == nullptr || body_ == nullptr || !edit.of_object()) return body_;
  const std::vector<Deformation> now = deformations();
  return now == shapes_->unedited() ? body_ : shapes_->body_of(now);
}

std::size_t EditHistory::take_back(std::vector<Step>& from) {
  const Step step = std::move(from.back());
  from.pop_back();
  if (step.edit->of_form()) return 0;
  volume_.eta = step.eta_before;
  return put(step.difference, &VoxelDifference::Change::before);
}

void EditHistory::refine_for(const Edit& edit) {
  if (!homogeneous() || edit.uniform()) return;
  Refined refined = refine_();
  refined_ = true;
  begin_with(std::move(refined.volume), refined.body);
}

void EditHistory::coarsen() {
  const auto is_uniform = [](const Step& step) { return step.edit->off || step.edit->uniform(); };
  if (!refined_ || !std::all_of(steps_.begin(), steps_.end(), is_uniform) ||
      !std::all_of(trial_.begin(), trial_.end(), is_uniform)) {
    return;
  }
  refined_ = false;
  begin_with(voxel_, nullptr);
}

/// Does all edits so far to another volume of the same object.
void EditHistory::begin_with(io::VolumeSet volume, const EditedBody* body) {
  const std::vector<Step> done = std::exchange(steps_, {}), tried = std::exchange(trial_, {});
  const std::optional<double> eta = volume_.eta;
  volume_ = std::move(volume);
  body_ = body;
  ++revision_;
  for (const Step& step : done) apply(step.edit, steps_);
  for (const Step& step : tried) apply(step.edit, trial_);
  volume_.eta = eta;
}

std::size_t EditHistory::follow(const EditList& list) {
  std::size_t same = 0, changed = 0;
  while (same < list.size() && same < steps_.size() && list[same] == steps_[same].edit) ++same;
  while (steps_.size() > same) changed += take_back(steps_);
  for (std::size_t i = same; i < list.size(); ++i) changed += apply(list[i], steps_);
  coarsen();
  return changed;
}

std::size_t EditHistory::try_edit(const std::optional<Edit>& edit) {
  std::size_t changed = 0;
  if (!trial_.empty()) changed = take_back(trial_);
  if (edit) changed = std::max(changed, apply(std::make_shared<const Edit>(*edit), trial_));
  coarsen();
  return changed;
}

void EditHistory::commit() {
  if (trial_.empty()) return;
  EditList list = this->list();
  list.push_back(trial_.back().edit);
  steps_.push_back(std::move(trial_.back()));
  trial_.clear();
  states_.resize(++at_);
  states_.push_back(std::move(list));
}

std::size_t EditHistory::go_to(const EditList& list) {
  const EditList before = this->list();
  try {
    return follow(list);
  } catch (...) {
    follow(before);
    throw;
  }
}

std::size_t EditHistory::set_list(EditList list) {
  const std::size_t changed = try_edit(std::nullopt) + go_to(list);
  states_.resize(++at_);
  states_.push_back(std::move(list));
  return changed;
}

std::size_t EditHistory::switch_off(std::size_t place, bool off) {
  EditList list = this->list();
  Edit edit = *list.at(place);
  edit.off = off;
  list[place] = std::make_shared<const Edit>(std::move(edit));
  return set_list(std::move(list));
}

std::size_t EditHistory::move(std::size_t place, std::size_t to) {
  EditList list = this->list();
  const std::shared_ptr<const Edit> edit = list.at(place);
  list.erase(list.begin() + static_cast<std::ptrdiff_t>(place));
  list.insert(list.begin() + static_cast<std::ptrdiff_t>(std::min(to, list.size())), edit);
  return set_list(std::move(list));
}

std::size_t EditHistory::remove(std::size_t place) {
  EditList list = this->list();
  list.erase(list.begin() + static_cast<std::ptrdiff_t>(place));
  return set_list(std::move(list));
}

std::size_t EditHistory::undo() {
  std::size_t changed = try_edit(std::nullopt);
  if (!can_undo()) return changed;
  changed += go_to(states_[at_ - 1]);
  --at_;
  return changed;
}

std::size_t EditHistory::redo() {
  std::size_t changed = try_edit(std::nullopt);
  if (!can_redo()) return changed;
  changed += go_to(states_[at_ + 1]);
  ++at_;
  return changed;
}

std::size_t EditHistory::held() const {
  if (!trial_.empty()) return trial_.back().difference.held;
  return steps_.empty() ? 0 : steps_.back().difference.held;
}

std::optional<double> EditHistory::surface(std::optional<double> Edit::*field) const {
  std::optional<double> value;
  for (const std::vector<Step>* steps : {&steps_, &trial_}) {
    for (const Step& step : *steps) {
      if (!step.edit->off && (*step.edit).*field) value = (*step.edit).*field;
    }
  }
  return value;
}

Recipe EditHistory::recipe() const {
  Recipe recipe;
  for (const auto& edit : list()) recipe.edits.push_back(*edit);
  return recipe;
}

void apply(const Recipe& recipe, const std::string& origin, EditHistory& history,
           std::vector<std::string>& warnings) {
  EditList list = history.list();
  std::size_t number = 0;
  for (const Edit& edit : recipe.edits) {
    const std::string name = "edit " + std::to_string(++number);
    list.push_back(std::make_shared<const Edit>(edit));
    try {
      const std::size_t changed = history.set_list(list);
      if (changed == 0 && !edit.off && edit.of_medium()) {
        warnings.push_back(name + " changes no voxel");
      }
    } catch (const InputError& error) {
      throw InputError(origin + ": " + name + ": " + error.what());
    }
    if (history.held() > 0) {
      warnings.push_back(name +
                         ": coefficients held at their bounds (kappa 0.0001 to 10000 mm, mu "
                         "0 to 10000 1/mm): " +
                         std::to_string(history.held()));
    }
  }
}

}  // namespace kappamu::render

#include "render/edit/history.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "render/edit/selection.h"

namespace kappamu::render {

namespace {

VoxelValue value_of(const io::VolumeSet& set, std::size_t channel, std::size_t voxel) {
  return {set.media[channel].kappa[voxel], set.media[channel].mu[voxel],
          set.kappa_std.empty() ? 0.0 : set.kappa_std[channel][voxel],
          set.mu_std.empty() ? 0.0 : set.mu_std[channel][voxel]};
}

/// The channels that `edit` is for, by their place in the set.
std::vector<std::size_t> channels_of(const Edit& edit, const io::VolumeSet& set) {
  std::vector<std::size_t> places;
  for (std::size_t c = 0; c < set.channels.size(); ++c) {
    if (edit.channels.empty() ||
        std::count(edit.channels.begin(), edit.channels.end(), set.channels[c]) > 0) {
      places.push_back(c);
    }
  }
  for (const std::string& name : edit.channels) {
    if (std::count(set.channels.begin(), set.channels.end(), name) > 0) continue;
    std::string all;
    for (const std::string& channel : set.channels) all += (all.empty() ? "" : ", ") + channel;
    throw InputError("the volume has no channel " + name +
                     ", which an edit names; its channels: " + all);
  }
  return places;
}

/// A coefficient and its deviation.
struct Quantity {
  double value = 0.0, deviation = 0.0;
};

/// f of edit.h.
Quantity operated(const Edit& edit, double a, const Quantity& v) {
  switch (edit.operation) {
    case Operation::multiply:
      return {a * v.value, a * v.deviation};
    case Operation::add:
      return {v.value + a, v.deviation};
    case Operation::set:
      return {a, 0.0};
    case Operation::blend:
      return {(1.0 - edit.share) * v.value + edit.share * a, (1.0 - edit.share) * v.deviation};
    case Operation::copy:
      break;
  }
  return v;
}

class Editing {
 public:
  Editing(const Edit& edit, const io::VolumeSet& set) : edit_(edit), set_(set) {
    for (int axis = 0; axis < 3; ++axis) {
      shift_[static_cast<std::size_t>(axis)] =
          std::lround(edit.offset_mm[axis] / set.shape().voxel_mm);
    }
  }

  VoxelDifference difference() {
    VoxelDifference result;
    result.channels.resize(set_.channels.size());
    const std::vector<SelectedVoxel> selected = select(edit_.where, set_.shape());
    for (const std::size_t c : channels_of(edit_, set_)) {
      for (const SelectedVoxel& voxel : selected) {
        const VoxelValue before = value_of(set_, c, voxel.voxel);
        const VoxelValue after = changed(c, voxel, before);
        if (after.kappa == before.kappa && after.mu == before.mu) continue;
        result.channels[c].push_back({voxel.voxel, before, after});
      }
    }
    result.held = held_;
    return result;
  }

 private:
  VoxelValue changed(std::size_t channel, const SelectedVoxel& at, const VoxelValue& before) {
    const Quantity kappa{before.kappa, before.kappa_std}, mu{before.mu, before.mu_std};
    Quantity new_kappa = kappa, new_mu = mu;
    if (edit_.operation == Operation::copy) {
      const std::optional<std::size_t> from = source(at.voxel);
      if (!from) return before;
      const VoxelValue other = value_of(set_, channel, *from);
      new_kappa = {other.kappa, other.kappa_std};
      new_mu = {other.mu, other.mu_std};
    } else {
      if (edit_.kappa) new_kappa = operated(edit_, *edit_.kappa, kappa);
      if (edit_.mu) new_mu = operated(edit_, *edit_.mu, mu);
    }
    new_kappa = mixed(kappa, new_kappa, at.weight);
    new_mu = mixed(mu, new_mu, at.weight);
    return {held(new_kappa.value, smallest_kappa_mm, largest_kappa_mm),
            held(new_mu.value, 0.0, largest_mu_per_mm), new_kappa.deviation, new_mu.deviation};
  }

  static Quantity mixed(const Quantity& before, const Quantity& after, double weight) {
    return {(1.0 - weight) * before.value + weight * after.value,
            (1.0 - weight) * before.deviation + weight * after.deviation};
  }

  double held(double value, double smallest, double largest) {
    if (value < smallest || value > largest) ++held_;
    return std::clamp(value, smallest, largest);
  }

  /// Where a voxel's copy comes from; nothing beyond the volume.
  std::optional<std::size_t> source(std::size_t voxel) const {
    const GridShape& s = set_.shape();
    const auto nx = static_cast<std::size_t>(s.nx), ny = static_cast<std::size_t>(s.ny);
    const long x = static_cast<long>(voxel % nx) + shift_[0];
    const long y = static_cast<long>(voxel / nx % ny) + shift_[1];
    const long z = static_cast<long>(voxel / (nx * ny)) + shift_[2];
    if (x < 0 || y < 0 || z < 0 || x >= s.nx || y >= s.ny || z >= s.nz) return std::nullopt;
    return s.index(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z));
  }

  const Edit& edit_;
  const io::VolumeSet& set_;
  std::array<long, 3> shift_{};  ///< [voxels]
  std::size_t held_ = 0;
};

}  // namespace

std::size_t VoxelDifference::voxels() const {
  std::vector<std::uint32_t> all;
  for (const auto& channel : channels) {
    for (const Change& change : channel) all.push_back(change.voxel);
  }
  std::sort(all.begin(), all.end());
  return static_cast<std::size_t>(std::unique(all.begin(), all.end()) - all.begin());
}

VoxelDifference difference_of(const Edit& edit, const io::VolumeSet& set) {
  return Editing(edit, set).difference();
}

std::size_t EditHistory::put(const Step& step, VoxelValue VoxelDifference::Change::*side) {
  for (std::size_t c = 0; c < step.difference.channels.size(); ++c) {
    for (const VoxelDifference::Change& change : step.difference.channels[c]) {
      const VoxelValue& value = change.*side;
      volume_.media[c].kappa[change.voxel] = value.kappa;
      volume_.media[c].mu[change.voxel] = value.mu;
      if (!volume_.kappa_std.empty()) volume_.kappa_std[c][change.voxel] = value.kappa_std;
      if (!volume_.mu_std.empty()) volume_.mu_std[c][change.voxel] = value.mu_std;
    }
  }
  return step.difference.voxels();
}

std::size_t EditHistory::try_edit(const std::optional<Edit>& edit) {
  std::size_t changed = 0;
  if (trial_) changed = put(*trial_, &VoxelDifference::Change::before);
  trial_.reset();
  if (edit) {
    trial_ = Step{*edit, difference_of(*edit, volume_)};
    changed = std::max(changed, put(*trial_, &VoxelDifference::Change::after));
  }
  return changed;
}

void EditHistory::commit() {
  if (!trial_) return;
  steps_.resize(done_);
  steps_.push_back(std::move(*trial_));
  trial_.reset();
  ++done_;
}

std::size_t EditHistory::undo() {
  std::size_t changed = try_edit(std::nullopt);
  if (done_ > 0) changed += put(steps_[--done_], &VoxelDifference::Change::before);
  return changed;
}

std::size_t EditHistory::redo() {
  std::size_t changed = try_edit(std::nullopt);
  if (done_ < steps_.size()) changed += put(steps_[done_++], &VoxelDifference::Change::after);
  return changed;
}

std::size_t EditHistory::held() const {
  if (trial_) return trial_->difference.held;
  return done_ > 0 ? steps_[done_ - 1].difference.held : 0;
}

Recipe EditHistory::recipe() const {
  Recipe recipe;
  for (std::size_t i = 0; i < done_; ++i) recipe.edits.push_back(steps_[i].edit);
  return recipe;
}

io::VolumeSet edited(io::VolumeSet set, const Recipe& recipe, const std::string& origin,
                     std::vector<std::string>& warnings) {
  EditHistory history(std::move(set));
  for (std::size_t i = 0; i < recipe.edits.size(); ++i) {
    const std::string name = "edit " + std::to_string(i + 1);
    try {
      if (history.try_edit(recipe.edits[i]) == 0) {
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
    history.commit();
  }
  io::VolumeSet result = history.volume();
  result.metadata["edits"] = std::to_string(recipe.edits.size());
  return result;
}

}  // namespace kappamu::render

// A volume while it is edited: edits done, undone and done again as differences of voxels, and one
// edit on trial, a preview. The same edits on the same volume give equal bits, interactively, by a
// recipe and after any number of undone ones.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/volume/volume_set.h"
#include "render/edit/edit.h"

namespace kappamu::render {

/// One coefficient pair with its standard deviations; those are 0 where the set has none.
struct VoxelValue {
  double kappa = 0.0, mu = 0.0, kappa_std = 0.0, mu_std = 0.0;
};

/// What an edit changes.
struct VoxelDifference {
  struct Change {
    std::uint32_t voxel = 0;
    VoxelValue before, after;
  };
  std::vector<std::vector<Change>> channels;  ///< one list per channel of the set
  std::size_t held = 0;  ///< coefficients that the edit asked beyond the bounds of edit.h

  std::size_t voxels() const;  ///< changed in at least one channel
};

/// `edit` on `set`, which it leaves as it is. Throws InputError naming a channel that the set lacks
/// or an image that cannot be read.
///
/// Standard deviations follow as of a linear map: a product scales them, a sum leaves them, a
/// number that was set has zero, a copy brings its own. Resolution and sensitivity stay those of
/// the measurement.
VoxelDifference difference_of(const Edit& edit, const io::VolumeSet& set);

class EditHistory {
 public:
  explicit EditHistory(io::VolumeSet volume) : volume_(std::move(volume)) {}

  /// With all edits done, and the one on trial.
  const io::VolumeSet& volume() const { return volume_; }

  // Each returns what changed in volume(), as the changed voxels' number.

  /// Puts `edit` in place of the one on trial; nothing: takes that back.
  std::size_t try_edit(const std::optional<Edit>& edit);
  /// Keeps the edit on trial; what was undone is then gone for good.
  void commit();
  std::size_t undo();
  std::size_t redo();

  bool can_undo() const { return done_ > 0; }
  bool can_redo() const { return done_ < steps_.size(); }
  /// Coefficients held within bounds by the last edit done or on trial.
  std::size_t held() const;
  /// The edits done, the one on trial apart.
  Recipe recipe() const;

 private:
  struct Step {
    Edit edit;
    VoxelDifference difference;
  };
  std::size_t put(const Step& step, VoxelValue VoxelDifference::Change::*side);

  io::VolumeSet volume_;
  std::vector<Step> steps_;
  std::size_t done_ = 0;  ///< of steps_; the rest was undone
  std::optional<Step> trial_;
};

/// All edits of `recipe` on `set`; metadata "edits" is their number. Warnings count the
/// coefficients that were held at their bounds, and name edits that change no voxel. `origin` names
/// the recipe in messages.
io::VolumeSet edited(io::VolumeSet set, const Recipe& recipe, const std::string& origin,
                     std::vector<std::string>& warnings);

}  // namespace kappamu::render

// A volume while it is edited: a list of edits, its former states and those taken back, and one
// edit on trial, a preview. Edits are kept as differences of voxels. The same list on the same
// volume gives equal bits, interactively, by a recipe and after any number of states taken back.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/volume/volume_set.h"
#include "render/edit/edit.h"
#include "render/edit/edited_body.h"
#include "render/edit/voxel_edit.h"

namespace kappamu::render {

using EditList = std::vector<std::shared_ptr<const Edit>>;

/// The object of a history while edits deform it, or change its fur.
class EditedShapes {
 public:
  virtual ~EditedShapes() = default;
  virtual bool has_fur() const = 0;
  virtual const std::vector<Deformation>& unedited() const = 0;
  /// The object with these deformations in place of the unedited ones; until the next call.
  virtual const EditedBody* body_of(const std::vector<Deformation>& deformations) = 0;
};

/// `list` with edits of the shape such that an object of deformations `unedited` gets those of
/// `wanted`: edits that differ are changed in their place, others added at the end; where `wanted`
/// does not go on from what came before, one edit states it all.
EditList with_deformations(EditList list, const std::vector<Deformation>& unedited,
                           const std::vector<Deformation>& wanted);

class EditHistory {
 public:
  /// `body` as in select(), or none, has the unedited shape of `shapes`; none: no edit deforms it.
  explicit EditHistory(io::VolumeSet volume, const EditedBody* body = nullptr,
                       EditedShapes* shapes = nullptr)
      : volume_(std::move(volume)), body_(body), shapes_(shapes) {}
  /// Of a volume of one voxel, a homogeneous object, which `refine` makes the volume and the body
  /// of while a part of it is edited.
  struct Refined {
    io::VolumeSet volume;
    const EditedBody* body;
  };
  EditHistory(io::VolumeSet voxel, std::function<Refined()> refine, EditedShapes* shapes)
      : volume_(voxel), shapes_(shapes), voxel_(std::move(voxel)), refine_(std::move(refine)) {}

  /// With all edits of the list done that are not off, and the one on trial.
  const io::VolumeSet& volume() const { return volume_; }
  /// Another number whenever the volume may have changed.
  std::size_t revision() const { return revision_; }
  /// Whether no part of a homogeneous object is edited.
  bool homogeneous() const { return refine_ && !refined_; }
  /// What the edits make of the surface; none: they leave it.
  std::optional<double> eta() const { return surface(&Edit::eta); }
  std::optional<double> roughness() const { return surface(&Edit::roughness); }
  /// Of the object's shape: the unedited ones, and what the edits make of them.
  std::vector<Deformation> deformations() const;
  /// Changes the unedited `fur` as the edits do, the one on trial included.
  void change(Fur& fur) const;

  // Each returns what changed in volume(), as the changed voxels' number.

  /// Puts `edit` in place of the one on trial; nothing: takes that back.
  std::size_t try_edit(const std::optional<Edit>& edit);
  /// Puts the edit on trial at the end of the list; states that were taken back are then gone.
  void commit();
  /// A list in place of the present one, as a new state: in another order, with edits switched
  /// off, without some.
  std::size_t set_list(EditList list);
  /// The edit at `place` switched off or on; moved to `to`; taken out of the list.
  std::size_t switch_off(std::size_t place, bool off);
  std::size_t move(std::size_t place, std::size_t to);
  std::size_t remove(std::size_t place);
  std::size_t undo();
  std::size_t redo();

  bool can_undo() const { return at_ > 0; }
  bool can_redo() const { return at_ + 1 < states_.size(); }
  /// Coefficients held within bounds by the last edit done or on trial.
  std::size_t held() const;
  /// The one on trial apart.
  const EditList& list() const { return states_[at_]; }
  Recipe recipe() const;

 private:
  struct Step {
    std::shared_ptr<const Edit> edit;
    VoxelDifference difference;
    std::optional<double> eta_before;
  };
  std::size_t put(const VoxelDifference& difference, VoxelValue VoxelDifference::Change::*side);
  std::size_t apply(const std::shared_ptr<const Edit>& edit, std::vector<Step>& to);
  std::size_t take_back(std::vector<Step>& from);
  /// Makes the volume of one voxel one of many where `edit` needs it, and one voxel again where no
  /// edit does.
  void refine_for(const Edit& edit);
  void coarsen();
  void begin_with(io::VolumeSet volume, const EditedBody* body);
  const EditedBody* body_for(const Edit& edit) const;
  std::size_t follow(const EditList& list);
  /// The same; where it throws, the list is as before.
  std::size_t go_to(const EditList& list);
  std::optional<double> surface(std::optional<double> Edit::*field) const;

  io::VolumeSet volume_;
  const EditedBody* body_ = nullptr;
  EditedShapes* shapes_ = nullptr;
  io::VolumeSet voxel_;  ///< of a homogeneous object, unedited
  std::function<Refined()> refine_;
  bool refined_ = false;
  std::vector<Step> steps_;  ///< of the list, in its order
  std::vector<Step> trial_;  ///< none or one
  std::vector<EditList> states_{EditList{}};
  std::size_t at_ = 0;  ///< of states_
  std::size_t revision_ = 0;
};

/// Puts the edits of `recipe` at the end of the list, one state each. Warnings count the
/// coefficients that were held at their bounds, and name edits that change no voxel. `origin` names
/// the recipe in messages.
void apply(const Recipe& recipe, const std::string& origin, EditHistory& history,
           std::vector<std::string>& warnings);

}  // namespace kappamu::render

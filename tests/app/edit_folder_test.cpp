// What a window leaves of its edits on disk: saved, not saved yet, and for another volume.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/edit/edit_folder.h"
#include "core/error.h"
#include "io/volume/volume_file.h"
#include "process.h"

namespace kappamu::app {
namespace {

class EditFolderTest : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    io::VolumeSet set;
    set.channels = {"R", "G", "B"};
    for (const double mu : {0.01, 0.02, 0.03}) {
      set.media.push_back({Volume<double>(shape_, 0.3), Volume<double>(shape_, mu)});
    }
    io::write_vdb(source(), set);
  }
  std::filesystem::path source() const { return folder() / "volume.vdb"; }
  EditFolder made() const { return {folder() / "edits", EditSource{nullptr, 0, source()}}; }
  render::EditedObject unedited() const { return render::EditedObject(source()); }
  static void multiply(render::EditedObject& edited, double factor) {
    render::Edit edit;
    edit.mu = {factor};
    edit.where = render::BoxSelection{{0, 0, 0}, {2, 2, 2}};
    edited.history().try_edit(edit);
    edited.history().commit();
  }

  const GridShape shape_{6, 5, 4, 1.0};
};

TEST_F(EditFolderTest, LeavesNoTraceBeforeTheFirstEdit) {
  made();
  EXPECT_FALSE(std::filesystem::exists(folder() / "edits"));
}

TEST_F(EditFolderTest, UnsavedEditsComeBackAndAreGoneWhenDiscarded) {
  render::EditedObject edited = unedited();
  multiply(edited, 3.0);
  EditFolder edits = made();
  edits.keep(edited.recipe());
  EXPECT_FALSE(edits.is_saved(edited.recipe()));

  render::EditedObject next = unedited();
  EditFolder again = made();
  ASSERT_TRUE(again.has_edits());
  again.restore(next);
  EXPECT_EQ(next.history().volume().media[1].mu.values(),
            edited.history().volume().media[1].mu.values());
  EXPECT_FALSE(again.is_saved(next.recipe()));
  again.discard();
  EXPECT_FALSE(std::filesystem::exists(folder() / "edits"));
}

TEST_F(EditFolderTest, UnsavedEditsGoBeforeSavedOnes) {
  render::EditedObject edited = unedited();
  multiply(edited, 3.0);
  EditFolder edits = made();
  edits.keep(edited.recipe());
  edits.save(edited);
  EXPECT_TRUE(edits.is_saved(edited.recipe()));
  EXPECT_FALSE(std::filesystem::exists(edits.unsaved_file()));
  multiply(edited, 0.5);
  edits.keep(edited.recipe());

  render::EditedObject next = unedited();
  EditFolder again = made();
  again.restore(next);
  EXPECT_EQ(next.recipe().edits.size(), 2U);
  EXPECT_FALSE(again.is_saved(next.recipe()));
  next.history().undo();
  EXPECT_TRUE(again.is_saved(next.recipe()));
  again.keep(next.recipe());
  EXPECT_FALSE(std::filesystem::exists(again.unsaved_file()));
}

TEST_F(EditFolderTest, RefusesEditsOfAnotherVolume) {
  render::EditedObject edited = unedited();
  multiply(edited, 3.0);
  made().save(edited);
  io::VolumeSet other = io::read_volume(source());
  other.media[2].kappa(5, 4, 3) = 0.31;
  io::write_vdb(source(), other);
  render::EditedObject next = unedited();
  EXPECT_THROW(made().restore(next), InputError);
}

}  // namespace
}  // namespace kappamu::app

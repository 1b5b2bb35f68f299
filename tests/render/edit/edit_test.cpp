// Edits of volumes: which voxels a selection names, what an operation makes of them, undo, replay.
// Recipes on disk are tested in recipe_file_test.cpp, the command in tests/app.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include "core/error.h"
#include "core/optics.h"
#include "io/image/image_file.h"
#include "io/volume/volume_file.h"
#include "render/edit/history.h"
#include "render/edit/selection.h"
#include "render/material/published_materials.h"
#include "tests/own_folder.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

const GridShape shape{11, 7, 5, 0.5};  // a block of 5.5 x 3.5 x 2.5 mm

io::VolumeSet made_set() {
  io::VolumeSet set;
  set.channels = {"R", "G"};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> amount(0.1, 1.0);
  for (int c = 0; c < 2; ++c) {
    Medium medium{Volume<double>(shape), Volume<double>(shape)};
    Volume<double> kappa_std(shape), mu_std(shape);
    for (std::size_t i = 0; i < shape.cells(); ++i) {
      medium.kappa[i] = amount(random);
      medium.mu[i] = 0.1 * amount(random);
      kappa_std[i] = 0.01 * amount(random);
      mu_std[i] = 0.001 * amount(random);
    }
    set.media.push_back(std::move(medium));
    set.kappa_std.push_back(std::move(kappa_std));
    set.mu_std.push_back(std::move(mu_std));
  }
  return set;
}

bool equal(const io::VolumeSet& a, const io::VolumeSet& b) {
  for (std::size_t c = 0; c < a.channels.size(); ++c) {
    if (a.media[c].kappa.values() != b.media[c].kappa.values() ||
        a.media[c].mu.values() != b.media[c].mu.values() ||
        a.kappa_std[c].values() != b.kappa_std[c].values() ||
        a.mu_std[c].values() != b.mu_std[c].values()) {
      return false;
    }
  }
  return true;
}

Edit edit_of(Operation operation, std::optional<double> kappa, std::optional<double> mu,
             Selection where = WholeSelection{}) {
  Edit edit;
  edit.operation = operation;
  if (kappa) edit.kappa = {*kappa};
  if (mu) edit.mu = {*mu};
  edit.where = std::move(where);
  return edit;
}

BrushSelection brush_on_top(std::vector<Vector3d> points) {
  BrushSelection brush;
  brush.strokes.push_back({std::move(points), {-Vector3d::UnitZ()}});
  brush.radius_mm = 1.2;
  brush.depth_mm = 0.8;
  return brush;
}

io::VolumeSet with(const Edit& edit) {
  EditHistory history(made_set());
  history.try_edit(edit);
  return history.volume();
}

TEST(Select, BoxAndDepthNameVoxelsByTheirCentres) {
  const auto box = select(BoxSelection{{0.25, 0, 0}, {1.3, 0.5, 9}}, shape);
  EXPECT_EQ(box.size(), 3U * 1U * 5U);  // centres 0.25, 0.75, 1.25; 0.25; all
  DepthSelection shell{0.0, 0.5, {all_faces.begin(), all_faces.end()}};
  EXPECT_EQ(select(shell, shape).size(), shape.cells() - 9U * 5U * 3U);
  // Shells of all depths are the whole, once each.
  std::size_t total = 0;
  for (int layer = 0; layer < 3; ++layer) {
    shell.from_mm = 0.5 * layer;
    shell.to_mm = 0.5 * (layer + 1);
    total += select(shell, shape).size();
  }
  EXPECT_EQ(total, shape.cells());
  const DepthSelection top{0.0, 1.0, {Face::z_plus}};
  for (const SelectedVoxel& voxel : select(top, shape)) {
    EXPECT_GE(voxel.voxel / (11U * 7U), 3U);
    EXPECT_EQ(voxel.weight, 1.0);
  }
}

TEST(Select, BrushIsRoundAndReachesItsDepth) {
  const Vector3d on_top(2.75, 1.75, 2.5);
  BrushSelection brush = brush_on_top({on_top});
  brush.hardness = 1.0;
  std::size_t expected = 0;
  for (int z = 0; z < 5; ++z) {
    for (int y = 0; y < 7; ++y) {
      for (int x = 0; x < 11; ++x) {
        const double aside = std::hypot(0.5 * (x + 0.5) - 2.75, 0.5 * (y + 0.5) - 1.75);
        if (aside < 1.2 && 2.5 - 0.5 * (z + 0.5) <= 0.8) ++expected;
      }
    }
  }
  const auto hard = select(brush, shape);
  EXPECT_EQ(hard.size(), expected);
  brush.hardness = 0.0;
  const auto soft = select(brush, shape);
  ASSERT_EQ(soft.size(), hard.size());
  for (const SelectedVoxel& voxel : soft) {
    const double x = 0.5 * (voxel.voxel % 11 + 0.5), y = 0.5 * (voxel.voxel / 11 % 7 + 0.5);
    const double aside = std::hypot(x - 2.75, y - 1.75) / 1.2;
    EXPECT_NEAR(voxel.weight, 0.5 + 0.5 * std::cos(std::numbers::pi * aside), 1e-6);
  }
}

/// A stroke is the union of its dabs: it gains nothing from points that lie on its way.
TEST(Select, StrokeHasNoGapsAndDoesNotDependOnItsPoints) {
  const Vector3d from(0.5, 1.75, 2.5), to(5.0, 1.75, 2.5);
  BrushSelection brush = brush_on_top({from, to});
  brush.hardness = 1.0;
  brush.radius_mm = 0.6;
  const auto whole = select(brush, shape);
  std::size_t along_middle = 0;
  for (const SelectedVoxel& voxel : whole) {
    along_middle += voxel.voxel / 11 == 4U * 7U + 3U ? 1 : 0;
  }
  EXPECT_EQ(along_middle, 11U);
  brush.strokes[0].points_mm = {from, 0.5 * (from + to), to};
  EXPECT_EQ(select(brush, shape).size(), whole.size());
}

TEST(Select, StrokesFarLongerThanTheirRadiusAreRefused) {
  BrushSelection brush = brush_on_top({{0, 0, 2.5}, {5, 0, 2.5}});
  brush.radius_mm = 1e-6;
  EXPECT_THROW(select(brush, shape), InputError);
}

/// A brush on an object into which the volume is stretched is round there.
TEST(Select, StretchedBrushIsRoundOnTheObject) {
  BrushSelection brush = brush_on_top({{2.75, 1.75, 2.5}});
  brush.hardness = 1.0;
  brush.stretch = {3.0, 1.0, 1.0};
  for (const SelectedVoxel& voxel : select(brush, shape)) {
    const double x = 3.0 * (0.5 * (voxel.voxel % 11 + 0.5) - 2.75);
    const double y = 0.5 * (voxel.voxel / 11 % 7 + 0.5) - 1.75;
    EXPECT_LT(std::hypot(x, y), 1.2);
  }
  EXPECT_EQ(select(brush, shape).size(), 5U * 2U);  // one column wide, five rows, two layers
}

TEST(Select, TextureLiesOnItsFaceWithRowZeroAtTheLargestV) {
  const OwnFolder folder;
  const std::filesystem::path file = folder / "texture.png";
  Image<std::uint8_t> image(11, 7, 3);  // white at the top left corner alone
  for (int c = 0; c < 3; ++c) image(0, 0, c) = 255;
  io::write_image(file, image);
  const auto selected = select(TextureSelection{file, Face::z_plus, 0.8}, shape);
  ASSERT_EQ(selected.size(), 2U);  // two layers
  EXPECT_EQ(selected[0].voxel, shape.index(0, 6, 3));
  EXPECT_EQ(selected[1].voxel, shape.index(0, 6, 4));
  EXPECT_NEAR(selected[1].weight, 1.0, 1e-6);
  std::filesystem::remove(file);
  EXPECT_THROW(select(TextureSelection{file, Face::z_plus, 0.8}, shape), InputError);
}

TEST(Edits, ComputeTheirOperation) {
  const io::VolumeSet before = made_set();
  const io::VolumeSet multiplied = with(edit_of(Operation::multiply, 2.0, 0.0));
  const io::VolumeSet added = with(edit_of(Operation::add, 0.5, std::nullopt));
  const io::VolumeSet set = with(edit_of(Operation::set, std::nullopt, 0.25));
  Edit blend = edit_of(Operation::blend, 1.0, std::nullopt);
  blend.share = 0.25;
  const io::VolumeSet blended = with(blend);
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    EXPECT_DOUBLE_EQ(multiplied.media[1].kappa[i], 2.0 * before.media[1].kappa[i]);
    EXPECT_DOUBLE_EQ(multiplied.kappa_std[1][i], 2.0 * before.kappa_std[1][i]);
    EXPECT_EQ(multiplied.media[1].mu[i], 0.0);
    EXPECT_DOUBLE_EQ(added.media[0].kappa[i], 0.5 + before.media[0].kappa[i]);
    EXPECT_EQ(added.kappa_std[0][i], before.kappa_std[0][i]);
    EXPECT_EQ(added.media[0].mu[i], before.media[0].mu[i]);
    EXPECT_EQ(set.media[0].mu[i], 0.25);
    EXPECT_EQ(set.mu_std[0][i], 0.0);
    EXPECT_DOUBLE_EQ(blended.media[0].kappa[i], 0.75 * before.media[0].kappa[i] + 0.25);
  }
}

TEST(Edits, ChangeTheChannelsTheyNameAlone) {
  Edit edit = edit_of(Operation::multiply, 2.0, std::nullopt);
  edit.channels = {"G"};
  const io::VolumeSet before = made_set(), after = with(edit);
  EXPECT_EQ(after.media[0].kappa.values(), before.media[0].kappa.values());
  EXPECT_NE(after.media[1].kappa.values(), before.media[1].kappa.values());
  edit.channels = {"B"};
  EXPECT_THROW(with(edit), InputError);
}

TEST(Edits, CopyTakesWhatLiesAtTheOffset) {
  Edit edit;
  edit.operation = Operation::copy;
  edit.offset_mm = {1.0, 0.0, -0.5};
  const io::VolumeSet before = made_set(), after = with(edit);
  for (int z = 0; z < 5; ++z) {
    for (int x = 0; x < 11; ++x) {
      const bool inside = x + 2 < 11 && z >= 1;
      const std::size_t here = shape.index(x, 3, z);
      const std::size_t from = inside ? shape.index(x + 2, 3, z - 1) : here;
      EXPECT_EQ(after.media[0].mu[here], before.media[0].mu[from]);
      EXPECT_EQ(after.mu_std[0][here], before.mu_std[0][from]);
    }
  }
}

TEST(Edits, StayPhysicalWhateverTheyAsk) {
  for (const Edit& edit : {edit_of(Operation::add, -1e3, -1e3), edit_of(Operation::add, 1e4, 1e4),
                           edit_of(Operation::multiply, 1e6, 1e6)}) {
    EditHistory history(made_set());
    history.try_edit(edit);
    EXPECT_GT(history.held(), 0U);
    EXPECT_NO_THROW(io::validate(history.volume(), "edited"));
  }
}

TEST(History, UndoAndRedoAreExact) {
  EditHistory history(made_set());
  std::vector<io::VolumeSet> states{history.volume()};
  const std::vector<Edit> edits{
      edit_of(Operation::multiply, 1.7, 0.3, brush_on_top({{1, 1, 2.5}, {3, 2, 2.5}})),
      edit_of(Operation::add, -0.3, 0.01, DepthSelection{0, 1, {Face::x_minus}}),
      edit_of(Operation::set, 0.4, std::nullopt, BoxSelection{{1, 1, 1}, {3, 3, 3}})};
  for (const Edit& edit : edits) {
    EXPECT_GT(history.try_edit(edit), 0U);
    history.commit();
    states.push_back(history.volume());
  }
  for (std::size_t i = edits.size(); i > 0; --i) {
    EXPECT_TRUE(history.can_undo());
    EXPECT_GT(history.undo(), 0U);
    EXPECT_TRUE(equal(history.volume(), states[i - 1])) << i;
  }
  EXPECT_FALSE(history.can_undo());
  for (std::size_t i = 1; i <= edits.size(); ++i) {
    history.redo();
    EXPECT_TRUE(equal(history.volume(), states[i])) << i;
  }
  history.undo();
  history.try_edit(edits[0]);
  history.commit();
  EXPECT_FALSE(history.can_redo());
  EXPECT_EQ(history.recipe().edits.size(), 3U);
}

/// The list in another order, with edits off and out of it, is what the same list makes from
/// nothing; and every state comes back.
TEST(History, ListsAreWhatTheyMakeFromNothing) {
  const std::vector<Edit> edits{
      edit_of(Operation::multiply, 1.7, 0.3, brush_on_top({{1, 1, 2.5}, {3, 2, 2.5}})),
      edit_of(Operation::set, 0.4, std::nullopt, BoxSelection{{1, 1, 1}, {3, 3, 3}}),
      edit_of(Operation::add, 0.1, 0.01)};
  EditHistory history(made_set());
  for (const Edit& edit : edits) {
    history.try_edit(edit);
    history.commit();
  }
  const auto from_nothing = [&](const std::vector<std::size_t>& order) {
    EditHistory fresh(made_set());
    for (const std::size_t i : order) {
      fresh.try_edit(edits[i]);
      fresh.commit();
    }
    return fresh.volume();
  };
  EXPECT_GT(history.switch_off(0, true), 0U);
  EXPECT_TRUE(equal(history.volume(), from_nothing({1, 2})));
  EXPECT_TRUE(history.recipe().edits[0].off);
  history.switch_off(0, false);
  EXPECT_TRUE(equal(history.volume(), from_nothing({0, 1, 2})));
  history.move(2, 0);
  EXPECT_TRUE(equal(history.volume(), from_nothing({2, 0, 1})));
  EXPECT_FALSE(equal(history.volume(), from_nothing({0, 1, 2})));
  history.remove(1);
  EXPECT_TRUE(equal(history.volume(), from_nothing({2, 1})));
  history.undo();
  EXPECT_TRUE(equal(history.volume(), from_nothing({2, 0, 1})));
  history.undo();
  history.undo();
  EXPECT_TRUE(equal(history.volume(), from_nothing({1, 2})));
  history.redo();
  EXPECT_TRUE(equal(history.volume(), from_nothing({0, 1, 2})));
}

/// A list that cannot be done leaves the volume and the list as they were.
TEST(History, RefusedListsLeaveNoTrace) {
  EditHistory history(made_set());
  history.try_edit(edit_of(Operation::add, 0.1, 0.01));
  history.commit();
  const io::VolumeSet before = history.volume();
  Edit wrong = edit_of(Operation::multiply, 2.0, std::nullopt);
  wrong.channels = {"X"};
  EXPECT_THROW(history.set_list({std::make_shared<const Edit>(wrong)}), InputError);
  EXPECT_TRUE(equal(history.volume(), before));
  EXPECT_EQ(history.list().size(), 1U);
}

TEST(Edits, TakeOneNumberForEachChannel) {
  Edit edit;
  edit.operation = Operation::set;
  edit.mu = {0.03, 0.07};
  const io::VolumeSet both = with(edit);
  EXPECT_EQ(both.media[0].mu[5], 0.03);
  EXPECT_EQ(both.media[1].mu[5], 0.07);
  edit.channels = {"G", "R"};
  EXPECT_EQ(with(edit).media[1].mu[5], 0.03);
  edit.mu.push_back(0.1);
  EXPECT_THAT(sentence_of([&] { with(edit); }), HasSubstr("3 numbers for 2 channels"));
}

TEST(Edits, NameAPublishedMaterialByItsChannels) {
  Edit edit;
  edit.operation = Operation::set;
  edit.published = "marble";
  const HomogeneousMaterial marble = published_material("marble");
  const io::VolumeSet set = with(edit);
  EXPECT_EQ(set.media[0].kappa[3], marble.kappa_mm[0]);
  EXPECT_EQ(set.media[1].mu[3], marble.mu_per_mm[1]);
}

/// What an artist sets is what the volume then has; what is not stated stays.
TEST(Edits, SetColourAndMeanFreePath) {
  const double A = boundary_constants(1.3).A;
  const io::VolumeSet before = made_set();
  Edit edit;
  edit.operation = Operation::set;
  edit.albedo = {0.42};
  const io::VolumeSet coloured = with(edit);
  edit.albedo.clear();
  edit.mean_free_path_mm = {0.9};
  const io::VolumeSet longer = with(edit);
  edit.operation = Operation::multiply;
  edit.mean_free_path_mm = {2.0};
  const io::VolumeSet twice = with(edit);
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    const auto terms = [&](const io::VolumeSet& set) {
      return artist_terms(set.media[1].kappa[i], set.media[1].mu[i], A);
    };
    EXPECT_NEAR(terms(coloured).albedo, 0.42, 1e-12);
    EXPECT_DOUBLE_EQ(coloured.media[1].kappa[i], before.media[1].kappa[i]);
    EXPECT_NEAR(terms(longer).albedo, terms(before).albedo, 1e-12);
    EXPECT_DOUBLE_EQ(terms(longer).mean_free_path_mm, 0.9);
    EXPECT_DOUBLE_EQ(terms(twice).mean_free_path_mm, 2.0 * terms(before).mean_free_path_mm);
    EXPECT_NEAR(twice.media[1].mu[i], 0.5 * before.media[1].mu[i], 1e-12);
    EXPECT_EQ(longer.kappa_std[1][i], 0.0);
    EXPECT_NEAR(coloured.kappa_std[1][i], before.kappa_std[1][i], 1e-15);
  }
}

TEST(Edits, CopyFromAnotherVolume) {
  const OwnFolder folder;
  io::VolumeSet other;
  other.channels = {"G", "R"};
  const GridShape fine{4, 4, 4, 0.25};
  for (const double mu : {0.5, 0.25}) {
    other.media.push_back({Volume<double>(fine, 2.0), Volume<double>(fine, mu)});
  }
  io::write_vdb(folder / "other.vdb", other);
  Edit edit;
  edit.operation = Operation::copy;
  edit.volume = folder / "other.vdb";
  edit.offset_mm = {-1.0, 0.0, 0.0};  // the other's millimetre lies from x = 1 to 2
  const io::VolumeSet before = made_set(), after = with(edit);
  for (int x = 0; x < 11; ++x) {
    const bool inside = x == 2 || x == 3;
    EXPECT_EQ(after.media[0].mu(x, 1, 1), inside ? 0.25 : before.media[0].mu(x, 1, 1)) << x;
    EXPECT_EQ(after.media[1].mu(x, 1, 1), inside ? 0.5 : before.media[1].mu(x, 1, 1)) << x;
  }
}

/// A volume by itself has no object whose frame a place could be in.
TEST(Edits, RefusePlacesOfAnObjectWhereThereIsNone) {
  DepthSelection below;
  below.frame = Frame::object;
  EXPECT_THAT(sentence_of([&] { with(edit_of(Operation::multiply, 2.0, 2.0, below)); }),
              HasSubstr("in the frame of an object, and there is none"));
}

TEST(History, TrialLeavesNoTrace) {
  EditHistory history(made_set());
  history.try_edit(edit_of(Operation::set, 1.0, 1.0));
  history.try_edit(edit_of(Operation::multiply, 2.0, std::nullopt, brush_on_top({{1, 1, 2.5}})));
  history.try_edit(std::nullopt);
  EXPECT_TRUE(equal(history.volume(), made_set()));
  EXPECT_TRUE(history.recipe().edits.empty());
}

/// What the window holds after trials, undone and redone edits, its recipe makes of the volume too,
/// to the bit, also by way of its file.
io::VolumeSet edited(io::VolumeSet set, const Recipe& recipe, const std::string& origin,
                     std::vector<std::string>& warnings) {
  EditHistory history(std::move(set));
  apply(recipe, origin, history, warnings);
  return history.volume();
}

TEST(Recipes, ReplayGivesEqualBits) {
  EditHistory history(made_set());
  Edit painted = edit_of(Operation::multiply, 1.3, 0.7, brush_on_top({{1.01, 1.3, 2.5}}));
  history.try_edit(painted);
  std::get<BrushSelection>(painted.where).strokes[0].points_mm.push_back({3.1, 2.2, 2.5});
  std::get<BrushSelection>(painted.where).strokes[0].inward = {
      Vector3d(0.1, 0.2, -1).normalized(), Vector3d(-0.3, 0.1, -1).normalized()};
  history.try_edit(painted);
  history.commit();
  history.try_edit(edit_of(Operation::add, 0.1, 0.1));
  history.commit();
  history.undo();
  Edit copy;
  copy.operation = Operation::copy;
  copy.offset_mm = {1, 0, 0};
  copy.channels = {"R"};
  copy.where = BoxSelection{{0, 0, 0}, {2, 2, 2}};
  history.try_edit(copy);
  history.commit();
  const OwnFolder folder;
  const std::filesystem::path file = folder / "recipe.json";
  std::ofstream(file) << recipe_json(history.recipe(), file.parent_path());
  const Recipe read = read_recipe(file);
  std::vector<std::string> warnings;
  EXPECT_TRUE(equal(edited(made_set(), read, "recipe", warnings), history.volume()));
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(recipe_json(read, "/a"), recipe_json(history.recipe(), "/a"));
}

TEST(Recipes, WarnOfWhatIsHeldAndWhatDoesNothing) {
  Recipe recipe;
  recipe.edits.push_back(edit_of(Operation::add, -1e3, std::nullopt));
  recipe.edits.push_back(
      edit_of(Operation::add, 1.0, std::nullopt, BoxSelection{{90, 90, 90}, {91, 91, 91}}));
  std::vector<std::string> warnings;
  edited(made_set(), recipe, "r", warnings);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_THAT(warnings[0], HasSubstr("edit 1: coefficients held at their bounds"));
  EXPECT_THAT(warnings[0], testing::EndsWith(": 770"));
  EXPECT_EQ(warnings[1], "edit 2 changes no voxel");
  recipe.edits[1].channels = {"X"};
  EXPECT_THAT(sentence_of([&] { edited(made_set(), recipe, "r.json", warnings); }),
              HasSubstr("r.json: edit 2: the volume has no channel X"));
}

}  // namespace
}  // namespace kappamu::render

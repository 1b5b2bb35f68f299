// Objects under edits: what becomes of homogeneous, wrapped, stretched and mirrored ones, and the
// selections that need an object. Selections of a volume by itself are tested in edit_test.cpp.
#include "render/scene/edited_object.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "core/mesh/shapes.h"
#include "io/image/image_file.h"
#include "render/edit/selection.h"
#include "render/embree_caster.h"
#include "render/scene/object_shape.h"
#include "render/scene/world.h"
#include "tests/own_folder.h"
#include "tests/render/made_scene.h"
#include "tests/sentence.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double radius = 10.0;  // of the ball of sphere_scene() [mm]

Edit multiplied(double mu, Selection where) {
  Edit edit;
  edit.mu = {mu};
  edit.where = std::move(where);
  return edit;
}

/// An object of the scene with what its edits look at.
struct Made {
  explicit Made(const SceneObject& of, std::optional<double> voxel_mm = std::nullopt)
      : mesh(make_object_mesh(of, warnings)),
        rays(make_embree_caster(mesh)),
        edited(of, mesh, mesh, *rays, voxel_mm) {}

  std::size_t done(const Edit& edit) {
    const std::size_t changed = edited.history().try_edit(edit);
    edited.history().commit();
    return changed;
  }
  /// Where a voxel's middle lies in the object.
  Vector3d place(std::size_t voxel) const {
    const GridShape& s = edited.history().volume().shape();
    const auto nx = static_cast<std::size_t>(s.nx), ny = static_cast<std::size_t>(s.ny);
    return edited.placing().object_from_volume *
           Vector3d(s.voxel_mm * Vector3d(static_cast<double>(voxel % nx) + 0.5,
                                          static_cast<double>(voxel / nx % ny) + 0.5,
                                          static_cast<double>(voxel / nx / ny) + 0.5));
  }
  /// Calls check(place, whether μ of R is not `before`) for every voxel.
  template <class Check>
  void for_voxels(double before, const Check& check) const {
    const Volume<double>& mu = edited.history().volume().media[0].mu;
    for (std::size_t i = 0; i < mu.size(); ++i) check(place(i), mu[i] != before);
  }

  std::vector<std::string> warnings;
  TriangleMesh mesh;
  std::unique_ptr<RayCaster> rays;
  EditedObject edited;
};

SceneObject ball() {
  return sphere_scene().objects[0];
}

DepthSelection below_surface(double from_mm, double to_mm) {
  return {.from_mm = from_mm, .to_mm = to_mm, .frame = Frame::object};
}

TEST(EditedObject, HomogeneousStaysSoWhileAllOfItIsEdited) {
  Made made(ball());
  made.done(multiplied(3.0, WholeSelection{}));
  ASSERT_TRUE(made.edited.homogeneous());
  EXPECT_DOUBLE_EQ(made.edited.homogeneous()->mu_per_mm[2], 0.03);
  EXPECT_TRUE(made.edited.media().channels[0]->homogeneous());
  EXPECT_EQ(made.edited.media().channels[0]->smallest().mu, 0.003);
}

/// The voxels' edge is the smaller of a mean free path and a 64th of the size: 3 · 0.1 mm and
/// 20/64 mm.
TEST(EditedObject, HomogeneousBecomesAVolumeAtTheFirstEditOfAPart) {
  Made made(ball());
  made.done(multiplied(3.0, WholeSelection{}));
  EXPECT_GT(made.done(multiplied(2.0, below_surface(0.0, 1.0))), 0U);
  EXPECT_FALSE(made.edited.homogeneous());
  EXPECT_NEAR(made.edited.history().volume().shape().voxel_mm, 0.3, 1e-12);
  const auto media = made.edited.media().channels;
  EXPECT_DOUBLE_EQ(media[0]->at({0.0, 0.0, 0.0}).mu, 0.003);
  EXPECT_DOUBLE_EQ(media[0]->at({0.0, 0.0, 9.6}).mu, 0.006);
  made.edited.history().undo();
  EXPECT_DOUBLE_EQ(made.edited.media().channels[0]->at({0.0, 0.0, 9.6}).mu, 0.003);
}

/// Undone, switched off or not kept, the last edit of a part leaves one material, with all edits of
/// the whole.
TEST(EditedObject, AVolumeBecomesHomogeneousWithItsLastEditOfAPart) {
  Made made(ball());
  EditHistory& history = made.edited.history();
  made.done(multiplied(3.0, WholeSelection{}));
  const auto expect_one = [&](double mu) {
    ASSERT_TRUE(made.edited.homogeneous());
    EXPECT_DOUBLE_EQ(made.edited.homogeneous()->mu_per_mm[0], mu);
    EXPECT_TRUE(made.edited.media().channels[0]->homogeneous());
    EXPECT_DOUBLE_EQ(made.edited.media().channels[0]->smallest().mu, mu);
  };
  const auto expect_volume = [&](double mu_below) {
    EXPECT_FALSE(made.edited.homogeneous());
    EXPECT_DOUBLE_EQ(made.edited.media().channels[0]->at({0.0, 0.0, 9.6}).mu, mu_below);
  };
  made.done(multiplied(2.0, below_surface(0.0, 1.0)));
  history.undo();
  expect_one(0.003);
  history.redo();
  expect_volume(0.006);
  made.done(multiplied(5.0, WholeSelection{}));
  expect_volume(0.03);
  history.switch_off(1, true);
  expect_one(0.015);
  history.switch_off(1, false);
  expect_volume(0.03);
  history.remove(1);
  expect_one(0.015);
  history.try_edit(multiplied(2.0, below_surface(0.0, 1.0)));
  expect_volume(0.03);
  history.try_edit(multiplied(2.0, WholeSelection{}));
  expect_one(0.03);
  history.try_edit(std::nullopt);
  expect_one(0.015);
  EXPECT_EQ(history.list().size(), 2U);
}

TEST(EditedObject, VoxelsAreAsAskedOrRefused) {
  Made made(ball(), 1.7);
  made.done(multiplied(2.0, below_surface(0.0, 1.0)));
  EXPECT_EQ(made.edited.history().volume().shape().nx, 12);
  EXPECT_EQ(made.edited.recipe().voxel_mm, 1.7);
  Made fine(ball(), 0.01);
  EXPECT_THAT(sentence_of([&] { fine.done(multiplied(2.0, below_surface(0.0, 1.0))); }),
              HasSubstr("object 'ball': its material: voxels of 0.01 mm are too many"));
  // And nothing is left of it.
  EXPECT_TRUE(fine.edited.homogeneous());
  EXPECT_TRUE(fine.edited.history().list().empty());
}

Edit deformed_by(DeformKind kind, double amount) {
  Edit edit;
  edit.operation = Operation::deform;
  edit.deformations = {{.kind = kind, .amount = amount}};
  return edit;
}

/// Depth is below the surface as the edits before it have left it: a ball of radius 10 mm shrunk to
/// 5 mm has no skin at 9 mm, whatever comes later; and a scene that names the recipe is of the same
/// voxels and the same shape.
TEST(EditedObject, DeformationsAreEditsInTheOrderOfTheList) {
  Made made(ball(), 0.5);
  made.done(multiplied(2.0, below_surface(0.0, 1.0)));
  made.done(deformed_by(DeformKind::scale, 0.5));
  EXPECT_GT(made.done(multiplied(8.0, below_surface(0.0, 1.0))), 0U);
  const auto mu_at = [](const EditedObject& edited, double z) {
    return edited.media().channels[0]->at({0.0, 0.0, z}).mu;
  };
  EXPECT_DOUBLE_EQ(mu_at(made.edited, 9.6), 0.002);
  EXPECT_DOUBLE_EQ(mu_at(made.edited, 7.1), 0.001);
  EXPECT_DOUBLE_EQ(mu_at(made.edited, 4.6), 0.008);
  ASSERT_EQ(made.edited.history().deformations().size(), 1U);

  const OwnFolder folder;
  std::ofstream(folder / "recipe.json") << recipe_json(made.edited.recipe(), folder);
  SceneObject named = ball();
  named.edits = folder / "recipe.json";
  named.deform = made.edited.history().deformations();
  const TriangleMesh rest = make_object_mesh(named, made.warnings);
  const TriangleMesh mesh = deformed_body(rest, named.deform);
  const auto rays = make_embree_caster(mesh);
  const EditedObject again(named, rest, mesh, *rays);
  EXPECT_EQ(again.history().volume().media[0].mu.values(),
            made.edited.history().volume().media[0].mu.values());
  EXPECT_EQ(again.history().deformations(), named.deform);

  made.edited.history().switch_off(1, true);
  EXPECT_TRUE(made.edited.history().deformations().empty());
  EXPECT_DOUBLE_EQ(mu_at(made.edited, 9.6), 0.016);
  made.edited.history().undo();
  EXPECT_DOUBLE_EQ(mu_at(made.edited, 4.6), 0.008);
  // Beyond what a body bears.
  made.done(deformed_by(DeformKind::bend, 360.0));
  EXPECT_THAT(sentence_of([&] { made.edited.require_body(); }), HasSubstr("bend of 360"));
  EXPECT_THAT(sentence_of([] {
                EditHistory alone(one_voxel(HomogeneousMaterial{}));
                alone.try_edit(deformed_by(DeformKind::scale, 0.5));
              }),
              HasSubstr("it deforms an object, and there is none"));
}

TEST(EditedObject, ShapesThatAPersonSetsBecomeEdits) {
  const Deformation first{.kind = DeformKind::scale, .amount = 0.9},
      second{.kind = DeformKind::inflate, .amount = 0.2},
      third{.kind = DeformKind::twist, .amount = 5.0};
  const auto after = [](const EditList& list, std::vector<Deformation> before) {
    for (const auto& edit : list) edit->deform_on(before);
    return before;
  };
  const std::vector<Deformation> unedited{first};
  EditList list = with_deformations({}, unedited, {first, second});
  ASSERT_EQ(list.size(), 1U);
  EXPECT_FALSE(list[0]->instead);
  list = with_deformations(list, unedited, {first, second, third});
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(after(list, unedited), (std::vector{first, second, third}));
  list = with_deformations(list, unedited, {first, third});
  EXPECT_EQ(after(list, unedited), (std::vector{first, third}));
  list = with_deformations(list, unedited, {second, third});  // not the scene's own any more
  ASSERT_EQ(list.size(), 1U);
  EXPECT_TRUE(list[0]->instead);
  EXPECT_EQ(after(list, unedited), (std::vector{second, third}));
  list = with_deformations(list, unedited, {second, third, first});
  EXPECT_EQ(after(list, unedited), (std::vector{second, third, first}));
  list = with_deformations(list, unedited, {});
  EXPECT_EQ(after(list, unedited), std::vector<Deformation>{});
}

/// A mesh of two colours by its texture coordinates: u below a half and above.
TEST(EditedObject, ImagesLieByTextureCoordinates) {
  const OwnFolder folder;
  Image<std::uint8_t> halves(2, 1, 3, 0);
  for (int c = 0; c < 3; ++c) halves(0, 0, c) = 255;
  io::write_image(folder / "halves.png", halves);
  Edit edit = multiplied(
      4.0, CoordinatesSelection{.image = folder / "halves.png", .from_mm = 0.0, .to_mm = 1.0});
  Made bare(ball(), 0.5);
  EXPECT_THAT(sentence_of([&] { bare.done(edit); }), HasSubstr("texture coordinates"));

  const SceneObject object = ball();
  std::vector<std::string> warnings;
  TriangleMesh mesh = make_object_mesh(object, warnings);
  for (const auto& triangle : mesh.triangles) {
    CornerTexture texture;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d& corner = mesh.vertices[static_cast<std::size_t>(triangle[k])];
      // From 0 at the lowest x to 1 at the highest, and once round more.
      texture[k] = {static_cast<float>(1.0 + 0.5 + 0.499 * corner.x() / radius), 0.5F};
    }
    mesh.texture.push_back(texture);
  }
  const auto rays = make_embree_caster(mesh);
  EditedObject edited(object, mesh, mesh, *rays, 0.5);
  edited.history().try_edit(edit);
  edited.history().commit();
  const auto mu_at = [&](const Vector3d& at) { return edited.media().channels[0]->at(at).mu; };
  EXPECT_DOUBLE_EQ(mu_at({-9.6, 0.1, 0.1}), 0.004);
  EXPECT_DOUBLE_EQ(mu_at({9.6, 0.1, 0.1}), 0.001);
  EXPECT_DOUBLE_EQ(mu_at({-7.6, 0.1, 0.1}), 0.001);
}

/// Half a voxel's diagonal and the facets of the ball blur the depth.
TEST(EditedObject, DepthIsBelowTheObjectsSurface) {
  constexpr double voxel = 0.5, blur = 0.87 * voxel + 0.05;
  Made made(ball(), voxel);
  made.done(multiplied(2.0, below_surface(1.0, 2.5)));
  int inside = 0;
  made.for_voxels(0.001, [&](const Vector3d& place, bool changed) {
    const double depth = radius - place.norm();
    if (depth > 1.0 + 0.06 && depth < 2.5 - 0.06) {
      EXPECT_TRUE(changed) << place.transpose();
      ++inside;
    }
    if (depth < 1.0 - 0.06 || depth > 2.5 + 0.06) {
      EXPECT_FALSE(changed) << place.transpose();
    }
  });
  EXPECT_GT(inside, 9000);  // of 9466 voxels between 1.06 and 2.44 mm
  // From the surface on, voxels that it cuts count.
  Made skin(ball(), voxel);
  skin.done(multiplied(2.0, below_surface(0.0, 1.0)));
  skin.for_voxels(0.001, [&](const Vector3d& place, bool changed) {
    const double depth = radius - place.norm();
    if (depth > -0.3 * voxel && depth < 1.0 - 0.06) {
      EXPECT_TRUE(changed) << place.transpose();
    }
    if (depth < -blur || depth > 1.0 + 0.06) {
      EXPECT_FALSE(changed) << place.transpose();
    }
  });
}

TEST(EditedObject, BrushAndBoxAreInTheObjectsFrame) {
  Made made(ball(), 0.4);
  BrushSelection brush;
  brush.frame = Frame::object;
  brush.strokes = {{{{0.0, 0.0, radius}}, {-Vector3d::UnitZ()}}};
  brush.radius_mm = 2.0;
  brush.depth_mm = 3.0;
  brush.hardness = 1.0;
  made.done(multiplied(2.0, brush));
  made.for_voxels(0.001, [&](const Vector3d& place, bool changed) {
    const double aside = std::hypot(place.x(), place.y()), depth = radius - place.z();
    if (aside < 1.99 && depth > 0.0 && depth < 2.99) {
      EXPECT_TRUE(changed) << place.transpose();
    }
    if (aside > 2.01 || depth > 3.01) {
      EXPECT_FALSE(changed) << place.transpose();
    }
  });
  Made box(ball(), 0.4);
  const BoxSelection where{{-1.0, -2.0, -3.0}, {4.0, 5.0, 6.0}, Frame::object};
  box.done(multiplied(2.0, where));
  const Eigen::AlignedBox3d inside(where.from_mm, where.to_mm);
  box.for_voxels(0.001, [&](const Vector3d& place, bool changed) {
    EXPECT_EQ(changed, inside.contains(place)) << place.transpose();
  });
}

/// A white left half, thrown from +z: it lies on the side that is seen, left of the middle, and not
/// on the far side.
TEST(EditedObject, ImagesAreThrownOnWhatIsSeen) {
  const OwnFolder folder;
  Image<std::uint8_t> image(40, 40, 3);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 20; ++x) {
      for (int c = 0; c < 3; ++c) image(x, y, c) = 255;
    }
  }
  io::write_image(folder / "half.png", image);
  ProjectionSelection where;
  where.image = folder / "half.png";
  where.position_mm = {0.0, 0.0, 100.0};
  where.fov_deg = 30.0;
  where.from_mm = 0.5;
  where.to_mm = 2.0;
  Made made(ball(), 0.4);
  made.done(multiplied(2.0, where));
  // The camera at 100 mm sees the ball to z = r²/100.
  const double rim = radius * radius / 100.0;
  int inside = 0;
  made.for_voxels(0.001, [&](const Vector3d& place, bool changed) {
    const Vector3d surface = radius * place.normalized();
    const double depth = radius - place.norm();
    if (surface.z() > rim + 0.3 && place.x() < -0.1 && depth > 0.56 && depth < 1.94) {
      EXPECT_TRUE(changed) << place.transpose();
      ++inside;
    }
    if (surface.z() < rim - 0.3 || place.x() > 0.1 || depth < 0.44 || depth > 2.06) {
      EXPECT_FALSE(changed) << place.transpose();
    }
  });
  EXPECT_GT(inside, 1000);
}

/// What hides a place of the surface keeps the image from it: the inner wall of a torus's hole.
TEST(EditedObject, ImagesDoNotPassThroughTheObject) {
  SceneObject torus = ball();
  torus.shape = std::string("torus");
  const OwnFolder folder;
  Image<std::uint8_t> image(8, 8, 3);
  for (std::uint8_t& code : image.values()) code = 255;
  io::write_image(folder / "white.png", image);
  ProjectionSelection where;
  where.image = folder / "white.png";
  where.to_mm = 0.5;
  where.fov_deg = 40.0;
  // In the plane of the ring, so that its near half hides the far one's inner wall.
  Made probe(torus);
  const Vector3d sizes = bounding_box(probe.mesh).sizes();
  Eigen::Index thin = 0;
  sizes.minCoeff(&thin);
  const Vector3d side = Vector3d::Unit((thin + 1) % 3);
  where.position_mm = 100.0 * side;
  where.up = Vector3d::Unit(thin);
  Made made(torus, 0.4);
  ASSERT_GT(made.done(multiplied(2.0, where)), 0U);
  const double most = 0.5 * sizes.maxCoeff();
  made.for_voxels(0.001, [&](const Vector3d& place, bool changed) {
    if (place.dot(side) < -0.2 * most) {
      EXPECT_FALSE(changed) << place.transpose();
    }
  });
}

/// Where a volume lies mirrored, an edit of a place of the object changes the voxel that is seen
/// there.
TEST(EditedObject, MirroredVolumesAreEditedWhereTheyAreSeen) {
  const OwnFolder folder;
  const GridShape shape{6, 5, 4, 1.0};
  io::VolumeSet set;
  set.channels = {"R", "G", "B"};
  set.media.assign(3, {Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)});
  io::write_vdb(folder / "volume.vdb", set);
  for (const auto placement :
       {VolumeMaterial::Placement::repeat, VolumeMaterial::Placement::mirror}) {
    SceneObject object = ball();
    VolumeMaterial material;
    material.volume = folder / "volume.vdb";
    material.placement = placement;
    material.turn_deg = {20.0, 0.0, 0.0};
    material.offset_mm = {1.0, 2.0, 0.0};
    object.material = material;
    Made made(object);
    const Vector3d at(-4.3, 6.1, 5.2);
    const BoxSelection where{at - Vector3d::Constant(0.9), at + Vector3d::Constant(0.9),
                             Frame::object};
    const double before = made.edited.media().channels[0]->at(at).mu;
    EXPECT_GT(made.done(multiplied(3.0, where)), 0U);
    EXPECT_DOUBLE_EQ(made.edited.media().channels[0]->at(at).mu, 3.0 * before);
    // A copy of the place is the place.
    Edit copy;
    copy.operation = Operation::copy;
    copy.where = BoxSelection{{-20, -20, -20}, {20, 20, 20}, Frame::object};
    EXPECT_EQ(made.done(copy), 0U);
  }
}

TEST(EditedObject, WrappedBlocksBecomeAVolumeOfTheObject) {
  const OwnFolder folder;
  const GridShape shape{8, 8, 5, 0.8};
  io::VolumeSet set;
  set.channels = {"grey"};
  set.media.push_back({Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)});
  io::write_vdb(folder / "volume.vdb", set);
  SceneObject object = ball();
  VolumeMaterial material;
  material.volume = folder / "volume.vdb";
  material.placement = VolumeMaterial::Placement::shell;
  object.material = material;
  Made made(object);
  EXPECT_GT(made.done(multiplied(2.0, below_surface(0.0, 1.0))), 0U);
  const auto medium = made.edited.media().channels[1];
  EXPECT_NEAR(medium->at({0.0, 9.5, 0.0}).mu, 0.02, 1e-6);
  EXPECT_NEAR(medium->at({0.0, 5.0, 0.0}).mu, 0.01, 1e-6);
}

/// η changes what a colour means, in the order of the list.
TEST(EditedObject, SurfaceIsEditedInTheListsOrder) {
  Made made(ball());
  Edit surface, colour;
  surface.operation = Operation::surface;
  surface.eta = 1.5;
  surface.roughness = 0.4;
  colour.operation = Operation::set;
  colour.albedo = {0.5};
  made.done(colour);
  made.done(surface);
  const ObjectMedia first = made.edited.media();
  EXPECT_EQ(first.eta, 1.5);
  EXPECT_EQ(first.roughness, 0.4);
  made.edited.history().move(1, 0);
  const ObjectMedia second = made.edited.media();
  const Coefficients c = second.channels[0]->smallest();
  EXPECT_NEAR(artist_terms(c.kappa, c.mu, boundary_constants(1.5).A).albedo, 0.5, 1e-12);
  EXPECT_NE(first.channels[0]->smallest().mu, c.mu);
  made.edited.history().undo();
  made.edited.history().undo();
  EXPECT_EQ(made.edited.media().eta, 1.3);
  EXPECT_EQ(made.edited.media().roughness, 0.0);
}

/// Fur is edited in the list's order, a switched off edit leaves no trace, and the volume stays.
TEST(EditedObject, FurIsEditedInTheListsOrder) {
  SceneObject object = ball();
  Edit longer, stroke;
  longer.operation = stroke.operation = Operation::fur;
  longer.fur.numbers[0] = 3.0;
  stroke.fur.strokes = {{FurStroke::Of::density, {{0, 0, 10}, {0, 1, 10}}, 2.0, 0.0}};
  EXPECT_THAT(sentence_of([&] { Made(object).done(longer); }),
              testing::HasSubstr("it edits fur, and the object has none"));
  object.fur = Fur{};
  object.fur->tile_mm = 0.2;
  Made made(object);
  EditHistory& history = made.edited.history();
  const std::size_t revision = history.revision();
  made.done(longer);
  made.done(stroke);
  const auto fur = [&] {
    Fur now = *object.fur;
    history.change(now);
    return now;
  };
  EXPECT_EQ(fur().length_mm, 3.0);
  EXPECT_EQ(fur().tile(), least_tile * 3.0);  // a tile of 0.2 mm is too small for it
  EXPECT_EQ(fur().strokes.size(), 1U);
  EXPECT_EQ(history.revision(), revision);
  history.switch_off(0, true);
  EXPECT_EQ(fur().length_mm, 1.0);
  EXPECT_EQ(fur().strokes.size(), 1U);
  history.undo();
  history.undo();
  EXPECT_EQ(fur().length_mm, 3.0);
  EXPECT_TRUE(fur().strokes.empty());
  EXPECT_TRUE(history.homogeneous());
}

/// A scene's own edits are done when it is read, and are not in the list.
TEST(EditedObject, ScenesStateEdits) {
  const OwnFolder folder;
  Recipe recipe;
  recipe.edits = {multiplied(4.0, WholeSelection{}), multiplied(2.0, below_surface(0.0, 1.0))};
  recipe.voxel_mm = 0.8;
  std::ofstream(folder / "recipe.json") << recipe_json(recipe, folder / "");
  Scene scene = sphere_scene();
  scene.objects[0].edits = folder / "recipe.json";
  std::vector<std::string> warnings;
  const World world(scene, warnings);
  const auto& medium = world.objects()[0].media.channels[0];
  EXPECT_DOUBLE_EQ(medium->at({0.0, 0.0, 9.5}).mu, 0.008);
  EXPECT_DOUBLE_EQ(medium->at({0.0, 0.0, 0.0}).mu, 0.004);
  Made made(scene.objects[0]);
  EXPECT_TRUE(made.edited.history().list().empty());
  EXPECT_EQ(made.edited.history().volume().media[0].mu.shape().nx, 25);
}

}  // namespace
}  // namespace kappamu::render

// A shape that the answer refuses is taken back, whatever was edited before and after it.
#include "app/viewer/shaping.h"

#include <gtest/gtest.h>

#include "render/material/published_materials.h"

namespace kappamu::app {
namespace {

render::Scene ball() {
  render::SceneObject object;
  object.name = "ball";
  object.shape = std::string("sphere");
  object.size_mm = 20.0;
  object.material = render::published_material("marble");
  render::Scene scene;
  scene.file = "scene.json";
  scene.objects = {object};
  scene.camera.position_mm = {0.0, 0.0, 80.0};
  return scene;
}

class Shapes : public testing::Test {
 protected:
  Shapes() : scene_(ball()), world_(scene_, warnings_), painter_(scene_, world_) {}

  std::vector<render::Deformation> bent(double amount) const {
    render::Deformation bend = shaping_.begun(0, render::DeformKind::bend);
    bend.amount = amount;
    return {bend};
  }
  void refuse() {
    render::LiveAnswer answer;
    answer.shape_refused = "ball: the shape crosses itself";
    shaping_.take(answer);
  }

  std::vector<std::string> warnings_;
  render::Scene scene_;
  render::World world_;
  Painter painter_;
  Shaping shaping_{world_, painter_};
};

TEST_F(Shapes, RefusedEditIsUndoneAndTheOneBeforeStays) {
  shaping_.set(0, bent(0.1), false);
  shaping_.set(0, bent(3.0), false);
  refuse();
  EXPECT_EQ(shaping_.of(0), bent(0.1));
  EXPECT_NE(shaping_.note().find("the stroke is undone"), std::string::npos);
  EXPECT_FALSE(painter_.can_redo());
  refuse();  // an answer to the same question, later
  EXPECT_EQ(shaping_.of(0), bent(0.1));
}

TEST_F(Shapes, UndoneByHandBeforeTheRefusalNothingElseIsUndone) {
  shaping_.set(0, bent(0.1), false);
  shaping_.set(0, bent(3.0), false);
  painter_.undo();
  refuse();
  EXPECT_EQ(shaping_.of(0), bent(0.1));
}

TEST_F(Shapes, EditsMadeAfterARefusedShapeStay) {
  shaping_.set(0, bent(3.0), false);
  render::Edit darker;
  darker.mu = {2.0};
  painter_.preview(darker);
  ASSERT_TRUE(painter_.keep());
  refuse();
  EXPECT_TRUE(shaping_.of(0).empty());
  EXPECT_EQ(painter_.list().size(), 1U);
}

}  // namespace
}  // namespace kappamu::app

#include "render/live/live_models.h"

#include <algorithm>

#include "forward/block/block_grid.h"
#include "forward/registry.h"

namespace kappamu::render {

namespace {

bool all_blocks(const World& world) {
  return std::all_of(world.objects().begin(), world.objects().end(), [](const WorldObject& object) {
    return std::all_of(object.media.channels.begin(), object.media.channels.end(),
                       [&](const auto& medium) {
                         return forward::block::block_grid(object.mesh, *medium).has_value();
                       });
  });
}

}  // namespace

bool all_homogeneous(const World& world) {
  return std::all_of(world.objects().begin(), world.objects().end(), [](const WorldObject& object) {
    return std::all_of(object.media.channels.begin(), object.media.channels.end(),
                       [](const auto& medium) { return medium->homogeneous(); });
  });
}

std::vector<std::string> live_models(const World& world) {
  const bool homogeneous = all_homogeneous(world), blocks = all_blocks(world),
             inside = world.lit_inside();
  std::vector<std::string> models, general;
  for (const forward::ModelDescription& model : forward::object_models()) {
    const auto& can = model.can;
    if (!can.live || !(can.heterogeneous || homogeneous) || !(can.any_shape || blocks) ||
        !(can.inner_light || !inside)) {
      continue;
    }
    (can.heterogeneous && can.any_shape ? general : models).push_back(model.name);
  }
  models.insert(models.end(), general.begin(), general.end());
  return models;
}

}  // namespace kappamu::render

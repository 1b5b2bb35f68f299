#include "render/live/live_object.h"

#include "forward/dipole/relight.h"
#include "render/live/live_block.h"
#include "render/live/live_polygrid.h"

namespace kappamu::render {

namespace {

/// A homogeneous object, whose hierarchy and links are kept.
class LiveLinks final : public LiveObject {
 public:
  LiveLinks(const WorldObject& object, const forward::ObjectOptions& options)
      : relight_(object.mesh, object.surface,
                 std::array{object.media.channels[0].get(), object.media.channels[1].get(),
                            object.media.channels[2].get()},
                 object.boundary.eta, options) {}

  Answer solve(const LightOfChannels& light) override { return {relight_.exitance(light)}; }
  double measured_error(const LightOfChannels& light,
                        const ExitanceOfChannels& exitance) const override {
    return relight_.measured_error(light, exitance);
  }

 private:
  forward::dipole::Relight relight_;
};

}  // namespace

ChannelProblems::ChannelProblems(const WorldObject& object, const LightOfChannels& light) {
  for (std::size_t c = 0; c < 3; ++c) {
    lights[c] = {light[c]};
    of.push_back({object.mesh, object.surface, *object.rays, *object.media.channels[c],
                  object.boundary.eta, lights[c], object.drawn()});
  }
}

std::unique_ptr<LiveObject> make_live_object(const std::string& model, const WorldObject& object,
                                             const forward::ObjectOptions& options) {
  if (model == "grid") return std::make_unique<LiveBlock>(object, options.device);
  if (model == "polygrid") return std::make_unique<LivePolygrid>(object, options.device);
  if (model == "dipole-rotated") return std::make_unique<LiveLinks>(object, options);
  return nullptr;
}

}  // namespace kappamu::render

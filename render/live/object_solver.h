// One object's model in a scene that is looked at, and what it keeps from light to light.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/options/options.h"
#include "forward/choice/object_features.h"
#include "forward/live_model.h"
#include "render/light/beam_places.h"
#include "render/live/live_shapes.h"
#include "render/scene/world.h"

namespace kappamu::render {

class ObjectSolver {
 public:
  /// Keeps references to the object. Throws InputError where the model does not answer for it.
  ObjectSolver(const WorldObject& lit, const std::string& model, const OptionValues& parameters,
               const forward::ObjectOptions& options, Progress& progress);

  /// Whether answers start from what was kept; else each is solved anew.
  bool keeps() const { return kept_ != nullptr; }
  int levels() const { return kept_ ? kept_->levels() : anew_levels; }
  /// Where the beams of level 0 arrive; empty, and at other levels: as incident_light() has them.
  const std::vector<BeamPlace>& places() const { return places_; }

  /// The object's vertices are elsewhere: answers wait for follow().
  void shape_changed() { behind_ = true; }
  /// Whether there is more to follow().
  bool is_behind() const { return behind_; }
  /// Catches up with the object's shape, as fast as `shape` asks. Whether what was kept follows;
  /// else it is made anew. Throws InputError where the model does not answer for this shape.
  bool follow(const ShapeQuestion& shape, Progress& progress);

  /// `error`: of a model that states it with its answer.
  struct Answer : forward::LiveModel::Answer {
    std::optional<double> error;
  };
  Answer solve(const forward::LightOfChannels& light, int level, Progress& progress);
  /// As LiveModel::measured_error().
  std::optional<double> measured_error(const forward::LightOfChannels& light, int level,
                                       const forward::ExitanceOfChannels& fine,
                                       const forward::ExitanceOfChannels& coarse) const;
  /// Of its three channels under this light.
  std::vector<forward::ObjectFeatures> features(const forward::LightOfChannels& light) const;

 private:
  /// A coarse answer, and one within the tolerance.
  static constexpr int anew_levels = 2;
  Answer solve_anew(const forward::LightOfChannels& light, int level, Progress& progress);
  void place_beams();

  const WorldObject& lit_;
  forward::LiveBody object_;
  std::unique_ptr<forward::ObjectModel> model_;
  forward::ObjectOptions options_;
  std::unique_ptr<forward::LiveModel> kept_;
  std::vector<BeamPlace> places_;
  bool behind_ = false;
};

}  // namespace kappamu::render

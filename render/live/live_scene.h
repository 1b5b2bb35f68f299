// A scene whose lights and shapes move and whose materials are edited: what does not depend on them
// is prepared once, and every question is answered by the objects' exitance, coarsely at first,
// then finer up to the tolerance asked for.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/options/options.h"
#include "core/progress.h"
#include "forward/choice/object_features.h"
#include "forward/live_model.h"
#include "render/live/live_answer.h"
#include "render/live/live_models.h"
#include "render/live/live_picture.h"
#include "render/live/live_shapes.h"
#include "render/live/sky_light.h"
#include "render/scene/scene.h"
#include "render/scene/world.h"

namespace kappamu::render {

class ObjectSolver;

struct LiveOptions {
  std::optional<std::string> model;  ///< in the registry; none: by the error and the time of each
  std::optional<double> tolerance;   ///< relative error of the exitance; none: the scene's
  std::string device = "auto";
  std::uint64_t seed = 1;
  OptionValues parameters{};  ///< the model's own
};

class LiveScene {
 public:
  /// Reads what the scene names; models are prepared where they first answer. Throws InputError as
  /// World does.
  LiveScene(
      const Scene& scene, const LiveOptions& options, std::vector<std::string>& warnings,
      const ShapesKnown& shapes_known = [](const World&) {});
  ~LiveScene();

  /// As it is drawn and picked: shapes are those of the last show().
  const World& world() const { return world_; }
  /// Gives the world the shapes of an answer. Of the thread that reads world(), as answer() may be
  /// at work in another.
  void show(const LiveAnswer& answer);
  double tolerance() const { return tolerance_; }

  /// As exactly as keeps up with lights that move: by the model and level of the least error that
  /// answer within a tenth of a second, or the fastest; while shapes move, by the first model that
  /// keeps what it can. Media stay until others are asked for. Throws InputError for the first
  /// model where it does not answer for these objects. A spot or a
  /// projector inside an object lights nothing.
  LiveAnswer answer(const LiveQuestion& question, Progress& progress);
  /// A better answer to the last question, or the same one with more known of its error; none: it
  /// is within the tolerance, nothing comes nearer, or shapes move.
  std::optional<LiveAnswer> refined(Progress& progress);
  /// The last answer's picture as `kappamu render` makes it, each with twice the rays of the one
  /// before; none: it has all that `view` asks for, or there is none, of shapes that move and of
  /// fur.
  std::optional<Picture> traced(const PictureView& view, Progress& progress);

 private:
  /// Of [M] 5.5: nothing is kept.
  static constexpr const char* anew_mode = "on the fly";
  /// A model at one of its levels.
  using Step = std::pair<std::string, int>;
  /// What is known of a step.
  struct Record {
    double milliseconds = 0.0;    ///< of an answer, the shortest
    std::optional<double> error;  ///< of the numerics
  };
  using Solvers = std::vector<std::unique_ptr<ObjectSolver>>;

  World& solved() { return solved_ ? *solved_ : world_; }
  const World& solved() const { return solved_ ? *solved_ : world_; }

  std::vector<std::string> candidates() const;
  /// Of the shapes as they are. None where the model refuses the objects; `refused_` has the
  /// reason.
  const Solvers* solvers_of(const std::string& model, Progress& progress);
  void expect_able(const std::string& model) const;
  Solvers make_solvers(const std::string& model, Progress& progress) const;
  static bool keep(const Solvers& solvers);
  Step first_step(Progress& progress);
  Step moving_step(Progress& progress);
  std::optional<Step> next_step(Progress& progress);
  std::optional<Step> better_model(Progress& progress);
  Step answering_step(Progress& progress, std::string& refused);

  void take_media(const LiveQuestion& question);
  void take_lights();
  std::string take_model(const std::string& model, Progress& progress);
  std::string take_shapes(const ShapeQuestion& shape);
  void part_worlds(Progress& progress);
  void light_environment(double rays, Progress& progress);
  std::vector<forward::LightOfChannels> light_objects(const Solvers& solvers, int level,
                                                      const LightSources& sources,
                                                      Progress& progress);
  LiveAnswer solve(const Step& step, Progress& progress);
  void state_errors(const Step& step, LiveAnswer& answer);
  std::optional<double> model_error(const std::string& model) const;
  void describe_surfaces(const LightSources& sources, LiveAnswer& answer);

  World world_;
  std::unique_ptr<World> solved_;  ///< that answers are of, once a shape has moved
  LiveShapes shapes_;
  ShapeQuestion asked_shape_;
  std::string mode_;  ///< of the answer at work
  LiveOptions options_;
  double tolerance_ = 0.0;
  std::optional<std::string> chosen_;  ///< model that a person wants
  std::map<std::string, Solvers> solvers_;
  std::map<std::string, std::string> refused_;  ///< models, and why
  std::map<Step, Record> records_;
  std::set<Step> impossible_;  ///< that these objects do not have

  std::vector<Light> lights_;
  SkyLight sky_;

  std::vector<forward::LightOfChannels> incident_;  ///< of the last answer
  std::vector<std::vector<forward::ObjectFeatures>> features_;
  std::optional<LiveAnswer> last_;
  bool answered_ = false;  ///< the last question, by `last_`
  /// Of each object; none: not known of its medium and shape, or of the lights and all shapes.
  std::vector<std::shared_ptr<const BelowSurface>> below_;
  std::vector<std::optional<Arriving>> arriving_;
  LivePicture picture_;
  bool homogeneous_ = true;  ///< all objects
  bool lit_inside_ = false;  ///< light begins inside objects
  bool furry_ = false;
};

}  // namespace kappamu::render

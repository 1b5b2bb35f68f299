// A scene whose lights move and whose volumes are edited: what does not depend on them is prepared
// once, and every question is answered by the objects' exitance.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/options/options.h"
#include "core/progress.h"
#include "render/light/environment.h"
#include "render/picture/shading.h"
#include "render/scene/scene.h"
#include "render/scene/world.h"

namespace kappamu::render {

struct LiveOptions {
  std::optional<std::string> model;  ///< in the registry; none: the first of live_models()
  std::optional<double> tolerance;   ///< of models that refine; none: 0.1
  std::string device = "auto";
  std::uint64_t seed = 1;
  OptionValues parameters{};  ///< the model's own
};

/// Those with the ability `live` that can answer for these objects: first those for boxes or
/// homogeneous objects alone, which are faster, then the others, each in the registry's order.
std::vector<std::string> live_models(const World& world);

/// How [M] 5.5 answers: links kept from shape to shape, or all made anew.
enum class FollowBy { update, renewal };

/// Which shapes objects have.
struct ShapeQuestion {
  std::map<std::size_t, std::vector<Deformation>> of{};  ///< of each object that has others now
  /// More shapes follow at once: light is taken at the middles of triangles, the sky's as it was,
  /// and what `most_ms` do not suffice for is left to the next answer. Otherwise the answer is in
  /// full, and a shape that crosses itself is refused.
  bool moving = false;
  double most_ms = 30.0;
  FollowBy by = FollowBy::update;
};

/// What light comes from where, what the objects are made of, and what shape they have.
struct LiveQuestion {
  std::vector<Light> lights;  ///< the scene's, those with a place or direction moved as one likes
  /// Of objects that are edited. Where a homogeneous one becomes a volume and the model answers for
  /// homogeneous ones alone, the first of live_models() takes its place.
  std::map<std::size_t, ObjectMedia> media;
  std::string model{};  ///< that answers from now on; "": as before
  ShapeQuestion shape{};
};

/// One answer; what it cost is wall time.
struct LiveAnswer {
  std::vector<ObjectExitance> exitance;  ///< one per object
  double light_ms = 0.0, model_ms = 0.0;
  double shape_ms = 0.0;  ///< moving vertices, and what the model needs to follow
  /// Of objects whose vertices are others than in the answer before, as they are now.
  std::map<std::size_t, std::vector<Eigen::Vector3d>> moved{};
  bool model_changed = false;  ///< `model` answers from now on, as another had to give up the shape
  std::string shape_refused{};  ///< why shapes are as they were; empty: they are those asked for
  std::string mode = "static";  ///< or "incremental", or "on the fly" ([M] 5.5)
  bool caught_up = true;        ///< not, where most_ms was too little
  double total_ms() const { return shape_ms + light_ms + model_ms; }
  /// What an earlier answer says that this one must say where nobody has seen the earlier one.
  void take_over(LiveAnswer& earlier);
  std::string model;    ///< that answered
  std::string refused;  ///< why the model asked for did not; empty: it did
  /// Worst relative error that the model estimates of its numerics. A model that keeps what it can
  /// from light to light has it measured, for the first lights answered.
  double error_estimate = 0.0;
  int iterations = 0;     ///< of the linear solver; 0 where there is none
  double residual = 0.0;  ///< that it left, relative; 0 where a model does not state it
  bool converged = true;
};

class LiveScene {
 public:
  /// Reads what the scene names and prepares its models. Throws InputError as World does, and
  /// for a model that does not answer for these objects.
  LiveScene(const Scene& scene, const LiveOptions& options, std::vector<std::string>& warnings);
  ~LiveScene();

  /// As it is drawn and picked: shapes are those of the last show().
  const World& world() const { return world_; }
  /// Gives the world the shapes of an answer. Of the thread that reads world(), as answer() may be
  /// at work in another.
  void show(const LiveAnswer& answer);
  const std::string& model() const { return model_; }  ///< not while answer() is at work

  /// The scene's environment stays as it is. A light inside an object lights nothing. Media stay
  /// until others are asked for.
  LiveAnswer answer(const LiveQuestion& question, Progress& progress);

 private:
  struct Solver;

  void start(const std::string& model, const OptionValues& parameters);
  void set_media(std::size_t object, const ObjectMedia& media);
  void set_shapes(const ShapeQuestion& shape, LiveAnswer& answer);
  void follow(std::size_t object, std::vector<Eigen::Vector3d> vertices, const ShapeQuestion& shape,
              LiveAnswer& answer);
  void light_from_sky(std::size_t object);
  World& solved() { return solved_ ? *solved_ : world_; }

  World world_;
  std::unique_ptr<World> solved_;  ///< that answers are of, once a shape has moved
  std::optional<Environment> environment_;
  /// Of each object: of the vertices as they are, and as last accepted.
  std::vector<std::vector<Deformation>> shape_, accepted_;
  std::vector<char> rough_;  ///< per object: its light is that of a shape that moves
  std::string model_;
  OptionValues parameters_;  ///< of that model
  LiveOptions options_;
  /// Irradiance of the environment on each object's triangles, R, G, B; empty: none.
  std::vector<std::array<std::vector<double>, 3>> diffuse_;
  std::vector<std::unique_ptr<Solver>> solvers_;
};

}  // namespace kappamu::render

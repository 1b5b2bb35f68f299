// What is asked of a scene that is looked at, and what it answers.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/live/live_shapes.h"
#include "render/live/surface_light.h"
#include "render/picture/shading.h"
#include "render/scene/scene.h"

namespace kappamu::render {

/// What light comes from where, what the objects are made of, and what shape they have.
struct LiveQuestion {
  std::vector<Light> lights;  ///< the scene's, changed as one likes
  /// Of objects that are edited. Where a homogeneous one becomes a volume, models for homogeneous
  /// ones alone answer no more.
  std::map<std::size_t, ObjectMedia> media;
  std::string model{};  ///< that answers from now on; "": as before
  ShapeQuestion shape{};
};

/// One answer; what it cost is wall time.
struct LiveAnswer {
  std::vector<ObjectExitance> exitance;  ///< one per object
  std::vector<SurfaceLight> surface{};   ///< one per object
  /// Of the first sources of `surface`: a place and 1, or the direction towards it and 0.
  std::vector<Eigen::Vector4d> sources{};
  double light_ms = 0.0, model_ms = 0.0;
  double surface_ms = 0.0;  ///< of `surface`
  double shape_ms = 0.0;    ///< moving vertices, and what the model needs to follow
  /// Of objects whose vertices are others than in the answer before, as they are now.
  std::map<std::size_t, std::vector<Eigen::Vector3d>> moved{};
  std::string shape_refused{};  ///< why shapes are as they were; empty: they are those asked for
  std::string mode = "static";  ///< or "incremental", or "on the fly" ([M] 5.5)
  bool caught_up = true;        ///< not, where most_ms was too little
  std::string model;            ///< that answered
  std::string refused;          ///< why the model asked for did not; empty: it did
  int level = 0;                ///< forward/live_model.h
  std::size_t elements = 0;     ///< cells or triangles, of all objects
  /// Worst relative error of the numerics; none: not known yet. Measured for the first lights
  /// that were answered at this level.
  std::optional<double> error_estimate;
  /// What the model errs by against transport by its law, forward/model_error.h; none: not known
  /// yet, or not measured.
  std::optional<double> model_error;
  int iterations = 0;     ///< of the linear solver; 0 where there is none
  double residual = 0.0;  ///< that it left, relative; 0 where a model does not state it
  bool converged = true;

  double total_ms() const { return shape_ms + light_ms + model_ms + surface_ms; }
  /// Of numerics and model together, as far as they are known.
  std::optional<double> error() const;
  /// What an earlier answer says that this one must say where nobody has seen the earlier one.
  void take_over(LiveAnswer& earlier);
};

}  // namespace kappamu::render

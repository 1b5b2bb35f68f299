// Models of objects by the names users give them, each described by its own folder. Scenes, command
// line, documents, `auto`, the window and tests read these descriptions.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "forward/choice/model_table.h"
#include "forward/model_error.h"

namespace kappamu::forward {

struct Abilities {
  bool heterogeneous = false;   ///< κ and μ that vary
  bool any_shape = true;        ///< else boxes of whole voxels alone
  bool voids = false;           ///< holes enclosed by the body
  bool several_bodies = false;  ///< meshes of several closed surfaces apart
  bool deforming = false;       ///< meshes that move answer without a new start
  bool inner_light = false;     ///< takes light that begins inside the object
  bool live = false;            ///< follows lights in the window
  bool reentry = false;         ///< follows light that leaves and meets the object again
  bool transport = false;       ///< right wherever it is given time: parameter `photons`
  bool chooses = false;         ///< asks the others
};

struct ModelDescription {
  std::string name;    ///< in scenes
  std::string text;    ///< one sentence: what it solves
  std::string limits;  ///< one sentence: where it must not be trusted
  Abilities can;
  std::function<std::unique_ptr<ObjectModel>()> make;  ///< its parameters at their defaults
  /// Errors and costs on objects, which make it a candidate of `auto`; none: not measured.
  const MeasuredModel* measured = nullptr;
  /// What its physics errs by against transport; none: nothing, or not measured.
  const ErrorLaw* errs_by = nullptr;
};

/// In the order they are listed.
const std::deque<ModelDescription>& object_models();
/// One more, for programs with models of their own; before anything else is asked of models. Throws
/// InputError where the name is taken.
void add_object_model(ModelDescription model);
/// Throws InputError, listing the names, for another one.
const ModelDescription& object_model(const std::string& name);
/// The one that solves transport.
const ModelDescription& transport_model();
/// Those that answer by themselves, without the ones that choose among them.
std::vector<std::string> object_model_names();

/// `parameters` are the model's own. Throws InputError as object_model() and ObjectModel::set() do.
std::unique_ptr<ObjectModel> make_object_model(const std::string& name,
                                               ModelError error = ModelError::warned,
                                               const OptionValues& parameters = {});

/// Every ability with its name, the one that a description lists it by.
std::vector<std::string> names_of(const Abilities& abilities);

}  // namespace kappamu::forward

// What `kappamu view --script` plays in place of a person: one command per line, # begins a
// comment.
//
//   lamp N            takes hold of the N-th light, from 1
//   light AZ EL       turns it to these angles [degrees]
//   turn DEGREES      turns an environment about the vertical
//   distance MM       moves it along the line to the objects' centre
//   brightness R G B  its irradiance or radiance
//   model NAME        which model answers
//   orbit DX DY       turns the camera about its target [degrees]
//   exposure E        factor before the tone curve
//   panel on|off      the panel of numbers
//   trace on|off      whether pictures are traced at rest
//   compare unedited|now|off
//                      the scene as its file has it, or as it is now, left of the picture
//   channel all|R|G|B  which channels are shown
//   brush OPERATION kappa|mu|albedo|mean_free_path AMOUNT RADIUS DEPTH
//                      takes a brush in hand [mm]: multiply, add, set or blend
//   paint X Y [X Y ...]
//                      a stroke through points of the picture, from its top left corner [px]
//   preview RECIPE     tries the one edit of a file as `kappamu edit --recipe` takes it
//   deform OBJECT FILE [moving]
//                      the object's deformations, a list as a scene has it; moving: others follow
//   drag pull|dent X0 Y0 X1 Y1 RADIUS
//                      pulls or dents the surface by a drag over the picture [px, mm]
//   tool orbit|brush|shape|fur
//                      what the left button does
//   mouse left|right|middle X0 Y0 X1 Y1
//                      drags from one point of the window to another [px]
//   fur length|density|width|curl|lean|shine|variation|comb_turn VALUE
//                      of all furry objects [mm, degrees]
//   fur root_colour|tip_colour R G B
//   fur_brush comb|length|density|colour RADIUS [VALUE, or R G B]
//                      what dragging over fur does [mm]
//   comb X0 Y0 X1 Y1 RADIUS
//                      combs fur from one point of the picture to another [px, mm]
//   links kept|anew    how answers follow a shape
//   keep, cancel       keeps the edit on trial, or takes it back
//   undo, redo         of edits
//   slice NAME x|y|z N the slice across an axis at a voxel, of a volume such as mu_R
//   photograph N       the run's N-th pattern from 1, photographed and predicted; 0: none
//   save               edited volumes and recipes, as --edits says
//   screenshot NAME    writes the picture as PNG, once it is of the light as it stands
//   quit
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "app/viewer/fur/fur_model.h"
#include "app/viewer/view_state.h"

namespace kappamu::app::script {

struct Lamp {
  int number = 1;
};
struct TurnLight {
  double azimuth_deg = 0.0, elevation_deg = 0.0;
};
struct SetLight {
  enum class What { turn_deg, distance_mm, brightness };
  What what = What::turn_deg;
  double value = 0.0;
  render::Colour colour = render::Colour::Ones();
};
struct ChooseModel {
  std::string name;
};
struct Orbit {
  double right_deg = 0.0, up_deg = 0.0;
};
struct Exposure {
  double factor = 1.0;
};
enum class Panel { on, off };
enum class Trace { on, off };
struct Screenshot {
  std::string name;
};
struct Paint {
  std::vector<double> points;  ///< x, y, x, y, ... [px]
};
struct Channel {
  int number = 0;  ///< as ViewState has it
};
struct Preview {
  render::Edit edit;
};
struct ShowPhotograph {
  int number = 1;
};
struct ShowSlice {
  std::string volume;
  int axis = 2, index = 0;
};
struct Deform {
  std::string object;
  std::vector<render::Deformation> deformations;
  bool moving = false;
};
struct Drag {
  render::DeformKind kind = render::DeformKind::pull;
  Eigen::Vector2d from, to;  ///< [px]
  double radius_mm = 1.0;
};
enum class Links { kept, anew };
struct SetFur {
  double render::Fur::*field = nullptr;  ///< or
  render::Colour render::Fur::*colour = nullptr;
  double value = 0.0;
  render::Colour shade = render::Colour::Zero();
};
struct Mouse {
  int button = 0;            ///< as ImGui has it: left, right, middle
  Eigen::Vector2d from, to;  ///< [px]
};
struct CombFur {
  Eigen::Vector2d from, to;  ///< [px]
  double radius_mm = 1.0;
};
struct Quit {};

using Command =
    std::variant<Lamp, TurnLight, SetLight, ChooseModel, Orbit, Exposure, Panel, Screenshot, Brush,
                 Paint, Channel, Preview, Asked, ShowPhotograph, ShowSlice, Deform, Drag, Links,
                 Trace, SetFur, CombFur, Compared, Tool, Mouse, render::FurStroke, Quit>;

/// Throws InputError naming file and line.
std::vector<Command> read(const std::filesystem::path& file);

}  // namespace kappamu::app::script

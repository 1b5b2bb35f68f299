// Edits of objects' volumes: what is done to κ [mm] and μ [1/mm], and where; a list of edits is a
// recipe (docs/formats.md, "Edits"; docs/edit.schema.json). All lengths in mm, of the volume's own
// frame (core/grid.h) or of the frame of the object that it lies in, as the selection states.
//
// A selection gives every voxel a weight w in [0, 1] by its centre; an operation f turns a
// coefficient v into (1 − w)·v + w·f(v). So edits fade where their selection does.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/grid.h"
#include "core/names.h"
#include "render/deform/deformation.h"
#include "render/edit/light_change.h"
#include "render/hair/fur.h"

namespace kappamu::render {

/// Whose frame a selection's places and lengths are of.
enum class Frame { volume, object };

/// Part of a brush's way over a surface: straight from point to point.
struct Stroke {
  std::vector<Eigen::Vector3d> points_mm;  ///< on the surface
  std::vector<Eigen::Vector3d> inward;     ///< of unit length: one per point, or one for all
};

/// Voxels below a round brush: within `radius_mm` of the axis that leads inwards from a point of a
/// stroke, and at most `depth_mm` along it.
struct BrushSelection {
  std::vector<Stroke> strokes;
  double radius_mm = 1.0;
  double depth_mm = 1.0;
  /// Weight is one up to this share of the radius and falls to zero at the radius as a cosine does.
  double hardness = 0.5;
  /// In the volume's frame: millimetres of the painted object per millimetre of the volume, along
  /// the volume's axes; radius and depth are of the object, into which the volume may be stretched.
  Eigen::Vector3d stretch = Eigen::Vector3d::Ones();
  Frame frame = Frame::volume;
};

/// An image laid over a face, down to a depth. Its columns run along the face's u, its rows against
/// v (row 0 at the largest v); weight is the linear luminance, at most one, of the nearest pixel.
struct TextureSelection {
  std::filesystem::path image;
  Face face = Face::z_plus;
  double depth_mm = 1.0;
};

/// An image thrown on an object's surface from a place, in the object's frame: voxels whose nearest
/// place of the surface is seen from there, at depths in [from, to) below it. Weight is the linear
/// luminance, at most one, of the pixel in which that place is seen.
struct ProjectionSelection {
  std::filesystem::path image;
  Eigen::Vector3d position_mm = Eigen::Vector3d::UnitZ(), target_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();
  double fov_deg = 30.0;  ///< of the image's height
  double from_mm = 0.0, to_mm = 1.0;
};

/// An image laid on an object's surface by its mesh's texture coordinates, again and again beyond
/// [0, 1]²: voxels at depths in [from, to) below it. u runs along the image's columns, v against
/// its rows. Weight is the linear luminance, at most one, of the pixel at the nearest place of the
/// surface.
struct CoordinatesSelection {
  std::filesystem::path image;
  double from_mm = 0.0, to_mm = 1.0;
};

/// Voxels whose depth lies in [from, to): below the nearest of the volume's `faces`, or, in the
/// object's frame, below the object's surface.
struct DepthSelection {
  double from_mm = 0.0, to_mm = 1.0;
  std::vector<Face> faces{all_faces.begin(), all_faces.end()};
  Frame frame = Frame::volume;
};

/// Voxels with centres in the box, its borders included.
struct BoxSelection {
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero(), to_mm = Eigen::Vector3d::Zero();
  Frame frame = Frame::volume;
};

struct WholeSelection {};

using Selection =
    std::variant<WholeSelection, BrushSelection, TextureSelection, ProjectionSelection,
                 DepthSelection, BoxSelection, CoordinatesSelection>;

enum class Operation {
  multiply,  ///< f(v) = a·v
  add,       ///< f(v) = v + a
  set,       ///< f(v) = a
  blend,     ///< f(v) = (1 − share)·v + share·a
  copy,      ///< f(v) = the coefficient of the voxel `offset_mm` away, before the edit
  surface,   ///< of the object's surface: η and roughness
  deform,    ///< of the object's shape: deformations after those before
  fur        ///< of the object's hair
};
/// Names of the file and of the command line.
inline constexpr Names<Operation, 8> operation_names{{{"multiply", Operation::multiply},
                                                      {"add", Operation::add},
                                                      {"set", Operation::set},
                                                      {"blend", Operation::blend},
                                                      {"copy", Operation::copy},
                                                      {"surface", Operation::surface},
                                                      {"deform", Operation::deform},
                                                      {"fur", Operation::fur}}};

/// a of an operation: one number for all channels, or one for each in the order of the edit's
/// `channels`, else of the volume's; none: what it is of stays as it is.
using Amount = std::vector<double>;

struct Edit {
  Operation operation = Operation::multiply;
  Amount kappa, mu;  ///< v is κ [mm], μ [1/mm]
  /// v is a colour, a mean free path (render/material/homogeneous.h); not beside κ and μ.
  Amount albedo, mean_free_path_mm;
  std::string published;  ///< of set and blend: κ and μ of a material of this name
  double share = 1.0;     ///< of blend
  Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();  ///< of copy, to where it copies from
  std::filesystem::path volume;           ///< of copy: that it copies from; empty: the edited one
  std::optional<double> eta, roughness;   ///< of surface
  std::vector<Deformation> deformations;  ///< of deform
  bool instead = false;  ///< of deform: in place of all that the object has before the edit
  FurChange fur;         ///< of fur
  std::vector<std::string> channels;  ///< empty: all
  Selection where;
  bool off = false;  ///< kept in the list, not done

  /// Whether all voxels are treated alike, so that a homogeneous object stays one.
  bool uniform() const {
    return std::holds_alternative<WholeSelection>(where) && operation != Operation::copy;
  }
  /// Whether it is of κ and μ.
  bool of_medium() const { return operation != Operation::surface && !of_form(); }
  /// Whether it is of the object's shape or hair, which no volume has.
  bool of_form() const { return operation == Operation::deform || operation == Operation::fur; }
  /// Those of an object after this edit, unless it is off.
  void deform_on(std::vector<Deformation>& before) const {
    if (off || operation != Operation::deform) return;
    if (instead) before.clear();
    before.insert(before.end(), deformations.begin(), deformations.end());
  }
  /// The object's fur after this edit, unless it is off.
  void change(Fur& before) const {
    if (!off && operation == Operation::fur) fur.change(before);
  }
  /// Whether places are named that only an object has, not a volume by itself.
  bool of_object() const;
};

struct Recipe {
  std::vector<Edit> edits;  ///< in the order in which they are done
  /// Edge of the voxels that a homogeneous object is made of [mm]; none: by itself.
  std::optional<double> voxel_mm;
  LightChanges lights{};  ///< of the scene whose object is edited
};

/// κ and μ are held within these bounds, whatever an edit asks for: positive, finite as floats, and
/// beyond every material.
inline constexpr double smallest_kappa_mm = 1e-4, largest_kappa_mm = 1e4;
inline constexpr double largest_mu_per_mm = 1e4;
/// Below, there is no scattering to speak of.
inline constexpr double smallest_albedo = 1e-6;

/// Throws InputError naming file, field and fix. Names of images are relative to the file's folder.
Recipe read_recipe(const std::filesystem::path& file);

/// Throws InputError naming the field unless read_recipe() takes `edit` as it is.
void require_valid(const Edit& edit);

/// The recipe as text of a file in `folder`.
std::string recipe_json(const Recipe& recipe, const std::filesystem::path& folder);

/// Images and volumes that the edits name.
std::vector<std::filesystem::path> files_of(const Recipe& recipe);

}  // namespace kappamu::render

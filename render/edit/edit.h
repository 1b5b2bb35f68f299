// Edits of measured volumes: what is done to κ [mm] and μ [1/mm], and where; a list of edits is a
// recipe (docs/formats.md, "Edits"; docs/edit.schema.json). All lengths in mm of the volume's own
// frame (core/grid.h).
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

namespace kappamu::render {

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
  /// Millimetres of the painted object per millimetre of the volume, along the volume's axes:
  /// radius and depth are of the object, into which the volume may be stretched.
  Eigen::Vector3d stretch = Eigen::Vector3d::Ones();
};

/// An image laid over a face, down to a depth. Its columns run along the face's u, its rows against
/// v (row 0 at the largest v); weight is the linear luminance, at most one, of the nearest pixel.
struct TextureSelection {
  std::filesystem::path image;
  Face face = Face::z_plus;
  double depth_mm = 1.0;
};

/// Voxels whose distance to the nearest of `faces` lies in [from, to).
struct DepthSelection {
  double from_mm = 0.0, to_mm = 1.0;
  std::vector<Face> faces{all_faces.begin(), all_faces.end()};
};

/// Voxels with centres in the box, its borders included.
struct BoxSelection {
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero(), to_mm = Eigen::Vector3d::Zero();
};

struct WholeSelection {};

using Selection =
    std::variant<WholeSelection, BrushSelection, TextureSelection, DepthSelection, BoxSelection>;

enum class Operation {
  multiply,  ///< f(v) = a·v
  add,       ///< f(v) = v + a
  set,       ///< f(v) = a
  blend,     ///< f(v) = (1 − share)·v + share·a
  copy       ///< f(v) = the coefficient of the voxel `offset_mm` away, before the edit
};

struct Edit {
  Operation operation = Operation::multiply;
  std::optional<double> kappa, mu;  ///< a; a coefficient without one stays as it is
  double share = 1.0;               ///< of blend
  Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();  ///< of copy, to where it copies from
  std::vector<std::string> channels;                    ///< empty: all
  Selection where;
};

struct Recipe {
  std::vector<Edit> edits;  ///< in the order in which they are done
};

/// κ and μ are held within these bounds, whatever an edit asks for: positive, finite as floats, and
/// beyond every material.
inline constexpr double smallest_kappa_mm = 1e-4, largest_kappa_mm = 1e4;
inline constexpr double largest_mu_per_mm = 1e4;

/// Names of the file and of the command line: "multiply", ...
std::string to_string(Operation operation);

/// Throws InputError naming file, field and fix. Names of images are relative to the file's folder.
Recipe read_recipe(const std::filesystem::path& file);

/// Throws InputError naming the field unless read_recipe() takes `edit` as it is.
void require_valid(const Edit& edit);

/// The recipe as text of a file in `folder`.
std::string recipe_json(const Recipe& recipe, const std::filesystem::path& folder);

}  // namespace kappamu::render

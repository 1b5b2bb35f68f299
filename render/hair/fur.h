// Hair on an object's skin as a scene states it (docs/fur.md), strokes of a brush over it, and what
// an edit changes of it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/names.h"
#include "render/colour.h"

namespace kappamu::render {

/// A brush led over the skin: from each point on to the next it combs hair that way, or leads
/// length, density or colour half of the way to its own, less towards the edge of its radius.
struct FurStroke {
  enum class Of { comb, length, density, colour };

  Of of = Of::comb;
  std::vector<Eigen::Vector3d> points_mm;  ///< two at least, on the undeformed object, in its frame
  double radius_mm = 2.0;
  double amount = 0.5;           ///< of length and density, 0 to 1
  Colour colour{0.9, 0.4, 0.2};  ///< of colour

  /// Whether `other` is led by the same brush.
  bool same_brush(const FurStroke& other) const {
    return of == other.of && radius_mm == other.radius_mm && amount == other.amount &&
           (colour == other.colour).all();
  }
};
inline constexpr Names<FurStroke::Of, 4> fur_brushes{{{"comb", FurStroke::Of::comb},
                                                      {"length", FurStroke::Of::length},
                                                      {"density", FurStroke::Of::density},
                                                      {"colour", FurStroke::Of::colour}}};

struct Fur {
  double length_mm = 1.0;         ///< of the longest hairs, along the normal
  std::optional<double> tile_mm;  ///< width of the tile that repeats; none: twice the length
  double width = 1.0;             ///< factor on the hairs' widths, at most 1
  double density = 1.0;           ///< factor on a tile's 55,000 hairs
  double curl = 0.3;              ///< tip's largest distance from a straight hair, over its length
  double lean = 0.4;              ///< along the comb: displacement over height
  Eigen::Vector3d comb = -Eigen::Vector3d::UnitY();  ///< in the object's frame, laid on the skin
  double comb_turn_deg = 0.0;                        ///< of the comb about the outward normal
  Colour root_colour{0.25, 0.15, 0.08}, tip_colour{0.85, 0.65, 0.40};
  double variation = 0.2;                  ///< of the colour between hairs, up to
  std::string reflectance = "kajiya-kay";  ///< or "marschner", or "even"
  double shine = 0.3;                      ///< share of the highlights
  bool fins = true;                        ///< at silhouettes
  int bands = 5, rays = 1024;              ///< of the transfer
  std::uint64_t seed = 1;
  /// Images by the mesh's texture coordinates (render/fur/coat.h): factors on length, density and
  /// colour; red and green of the comb's are its direction along and across `comb`, 0.5 is none.
  std::optional<std::filesystem::path> length_map, density_map, colour_map, comb_map;
  std::vector<FurStroke> strokes;  ///< after the images, in this order

  double tile() const { return tile_mm.value_or(2.0 * length_mm); }
};

/// Fields of one number, with their bounds.
struct FurNumber {
  const char* name;
  double Fur::*of;
  double smallest, largest;
};
inline constexpr FurNumber fur_numbers[] = {{"length_mm", &Fur::length_mm, 1e-6, 1e6},
                                            {"width", &Fur::width, 0.01, 1.0},
                                            {"density", &Fur::density, 0.0, 20.0},
                                            {"curl", &Fur::curl, 0.0, 4.0},
                                            {"lean", &Fur::lean, 0.0, 4.0},
                                            {"comb_turn_deg", &Fur::comb_turn_deg, -360.0, 360.0},
                                            {"variation", &Fur::variation, 0.0, 1.0},
                                            {"shine", &Fur::shine, 0.0, 1.0}};
inline constexpr std::size_t fur_number_count = std::size(fur_numbers);
/// Width of a tile over the hairs' length.
inline constexpr double least_tile = 0.1, largest_tile = 20.0;

/// What an edit changes; none: it stays.
struct FurChange {
  std::optional<double> numbers[fur_number_count];  ///< as fur_numbers
  std::optional<Colour> root_colour, tip_colour;
  std::optional<std::string> reflectance;
  std::vector<FurStroke> strokes;  ///< after those before

  bool empty() const;
  /// A stated width of the tile follows the length where it would be out of its bounds.
  void change(Fur& fur) const;
};
/// What `after`, whose strokes go on from those of `before`, changes of it.
FurChange change_between(const Fur& before, const Fur& after);

/// In a few words.
std::string described(const FurChange& change);

}  // namespace kappamu::render

// A collimated beam in a column of cells between two parallel faces that it meets at right angles.
// At each face the share R of what arrives is reflected, so that the beam goes to and fro.
//
// Cell k has the optical thickness x_k. A passage leaves p = e^(−Σ x) of its power. Of what enters,
// the passages away from the entry sum to D = 1/(1 − R²p²), those back to U = R p D, and cell k
// takes
//     c_k = (D l_k + U r_k)(1 − e^(−x_k)),
// l_k and r_k being what a passage from the entry, or from the far face, brings to the cell.
// Everything is per power that enters: Σ c + unscattered = 1.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace kappamu::forward {

class BeamColumn {
 public:
  /// `reflectance` R of both faces, 0 ≤ R < 1.
  explicit BeamColumn(double reflectance) : reflectance_(reflectance) {}

  /// x_k ≥ 0 from the entry to the far face, infinite where nothing passes. All that follows is of
  /// these.
  void set(std::span<const double> optical_thickness);

  /// What comes to cell k from the entry's side, and from the far one.
  double away(std::size_t k) const { return away_[k]; }
  double back(std::size_t k) const { return back_[k + 1]; }
  double collided(std::size_t k) const { return (away(k) + back(k)) * share_[k]; }
  /// Leaves by the far face, and by the one that it entered by.
  double leaves_far() const { return (1.0 - reflectance_) * away_.back(); }
  double leaves_near() const { return (1.0 - reflectance_) * back_.front(); }

  /// δc along δx. [cell]
  void change(std::span<const double> of_thickness, std::span<double> of_collided) const;
  /// Σ_k weight_k ∂c_k/∂x_j: the transpose of change(). [cell]
  void gradient(std::span<const double> weight, std::span<double> by_thickness) const;

 private:
  double reflectance_;
  double series_ = 0.0;        ///< 2R²p²D = −∂ log D/∂x_k
  std::vector<double> share_;  ///< 1 − e^(−x_k) [cell]
  std::vector<double> away_;   ///< D l: passes each cell's end [cell + 1]
  std::vector<double> back_;   ///< U r: likewise
};

}  // namespace kappamu::forward

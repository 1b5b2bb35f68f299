#include "forward/polygrid/shape/map_cells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/parallel.h"
#include "forward/polygrid/cell_geometry.h"
#include "forward/polygrid/shape/cell_energy.h"
#include "forward/polygrid/shape/limited_bfgs.h"

namespace kappamu::forward {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr int iterations_of_round = 12;
/// Distance of the surface from the outer faces beyond which it draws them, over a cell's edge, and
/// the largest weight of that: stronger, it would squeeze cells into tips.
constexpr double reach_beyond = 0.3, strongest_reach = 30.0;
/// Samples of the surface looked at in a round, per outer corner.
constexpr std::size_t samples_per_corner = 10;
/// A determinant (1 for the target cell) above which a corner counts as not inverted, and the least
/// ε.
constexpr double not_inverted = 1e-3, least_epsilon = 1e-2;

/// Points that are looked at one after the other, each from the last one's answer on.
constexpr std::size_t samples_of_part = 256;

/// Calls work(i) for i in [0, count), those of a part of samples_of_part in order.
template <class Work>
void for_parts(std::size_t count, const Work& work) {
  for_pieces(count, samples_of_part, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) work(i);
  });
}

/// What draws an outer corner: a plane.
struct Anchor {
  Vector3d point{0.0, 0.0, 0.0}, normal{0.0, 0.0, 0.0};
  int triangle = 0;  ///< of the surface, the closest in the last round
  double weight = 1.0;
};

class CellMap {
 public:
  CellMap(LayeredLattice& lattice, const MapTarget& target, const std::function<void()>& report)
      : lattice_(lattice),
        grid_(lattice.grid),
        target_(target),
        report_(report),
        first_(lattice.first_outer()),
        anchors_(grid_.corner.size() - first_) {
    const auto layer = static_cast<double>(grid_.boundary_cell.size());
    const double core = static_cast<double>(grid_.cell.size()) - layer;
    edge_ = std::cbrt(target.volume / (core + layer_thickness * layer));
    TargetCell cube;
    cube.inverse_edge.setConstant(1.0 / edge_);
    cells_.assign(grid_.cell.size(), cube);
    for (std::size_t k = 0; k < grid_.boundary_cell.size(); ++k) {
      cells_[static_cast<std::size_t>(grid_.boundary_cell[k])]
          .inverse_edge[grid_.boundary_side[k] / 2] /= layer_thickness;
    }
    energies_.emplace(grid_.cell_corners, cells_, grid_.corner.size());
  }

  double least() const { return energies_->least_determinant(grid_.corner); }

  void round(double pull, int power) {
    find_anchors();
    reach_what_is_left_away(pull);
    relax(pull, power);
    ++rounds_;
  }

  /// Outer corners go to the closest points of the surface, halfway or less where a cell would
  /// suffer.
  void put_onto_surface() {
    constexpr double unharmed = 0.25;  // scaled Jacobian, above which a cell may lose half
    constexpr int halvings = 8, passes = 12;
    const std::vector<Vector3d> old = grid_.corner;
    std::vector<double> allowed(grid_.boundary_cell.size());
    for (std::size_t k = 0; k < allowed.size(); ++k) {
      const double now = scaled_jacobian(grid_, static_cast<std::size_t>(grid_.boundary_cell[k]));
      allowed[k] = std::min(now, std::max(unharmed, 0.5 * now));
    }
    std::vector<double> step(anchors_.size(), 1.0);
    find_anchors();
    for (int pass = 0; pass < passes; ++pass) {
      for (std::size_t c = first_; c < old.size(); ++c) {
        grid_.corner[c] = old[c] + step[c - first_] * (anchors_[c - first_].point - old[c]);
      }
      bool unharmed_all = true;
      for (std::size_t k = 0; k < allowed.size(); ++k) {
        const auto cell = static_cast<std::size_t>(grid_.boundary_cell[k]);
        if (scaled_jacobian(grid_, cell) >= allowed[k]) continue;
        unharmed_all = false;
        for (const int c : grid_.cell_corners[cell]) {
          if (static_cast<std::size_t>(c) < first_) continue;
          double& length = step[static_cast<std::size_t>(c) - first_];
          length = pass < halvings ? length / 2.0 : 0.0;
        }
      }
      if (unharmed_all) return;
    }
    grid_.corner = old;
  }

 private:
  void find_anchors() {
    constexpr double on_surface = 0.1;  // edges: closer, the direction to it is not to be relied on
    for_parts(anchors_.size(), [&](std::size_t k) {
      const Vector3d& x = grid_.corner[first_ + k];
      const int near = rounds_ > 0                ? anchors_[k].triangle
                       : k % samples_of_part == 0 ? 0
                                                  : anchors_[k - 1].triangle;
      const ClosestPoint::Found found = target_.surface.from(x, near);
      anchors_[k] = {found.point,
                     found.distance > on_surface * edge_
                         ? Vector3d((x - found.point) / found.distance)
                         : target_.surface.smooth_normal(found),
                     found.triangle, 1.0};
    });
  }

  void reach_what_is_left_away(double pull) {
    const TriangleMesh faces = surface_of_grid(grid_);
    const ClosestPoint closest(faces);
    std::vector<double> farthest(anchors_.size(), reach_beyond * edge_);
    const std::size_t stride =
        1 +
        target_.samples.size() / (samples_per_corner * std::max<std::size_t>(1, anchors_.size()));
    of_sample_.resize((target_.samples.size() + stride - 1) / stride);
    for_parts(of_sample_.size(), [&](std::size_t s) {
      // Faces keep their numbers from round to round.
      const int near = rounds_ > 0                ? of_sample_[s].triangle
                       : s % samples_of_part == 0 ? 0
                                                  : of_sample_[s - 1].triangle;
      of_sample_[s] = closest.from(target_.samples[s * stride], near, reach_beyond * edge_);
    });
    for (std::size_t s = 0; s < of_sample_.size(); ++s) {
      const ClosestPoint::Found& found = of_sample_[s];
      if (found.distance <= reach_beyond * edge_) continue;
      const Vector3d& sample = target_.samples[s * stride];
      const auto& t = faces.triangles[static_cast<std::size_t>(found.triangle)];
      const auto off = [&](int v) {
        return (grid_.corner[static_cast<std::size_t>(v)] - sample).squaredNorm();
      };
      const int v =
          *std::min_element(t.begin(), t.end(), [&](int a, int b) { return off(a) < off(b); });
      const std::size_t k = static_cast<std::size_t>(v) - first_;
      if (found.distance <= farthest[k]) continue;
      farthest[k] = found.distance;
      anchors_[k].point = sample;
      anchors_[k].normal = (sample - grid_.corner[static_cast<std::size_t>(v)]).normalized();
      anchors_[k].weight = std::min(1.0, strongest_reach / pull);
    }
  }

  void relax(double pull, int power) {
    CellEnergy energy;
    energy.power = power;
    // While a corner is inverted, ε of its size keeps the energy finite, and shrinks with it.
    const double least_now = least();
    if (least_now < not_inverted) {
      energy.epsilon = std::max(least_epsilon, 0.5 * std::abs(least_now));
    }
    std::vector<Vector3d>& corner = grid_.corner;
    VectorXd x =
        Eigen::Map<const VectorXd>(corner[0].data(), 3 * static_cast<Index>(corner.size()));
    std::vector<Vector3d> slope(corner.size(), Vector3d::Zero());
    const auto function = [&](const VectorXd& at, VectorXd& gradient) {
      report_();
      Eigen::Map<VectorXd>(corner[0].data(), at.size()) = at;
      double value = (*energies_)(energy, corner, slope);
      for (std::size_t k = 0; k < anchors_.size(); ++k) {
        const Anchor& anchor = anchors_[k];
        const double off = anchor.normal.dot(corner[first_ + k] - anchor.point) / edge_;
        value += anchor.weight * pull * off * off;
        slope[first_ + k] += 2.0 * anchor.weight * pull * off / edge_ * anchor.normal;
      }
      gradient = Eigen::Map<const VectorXd>(slope[0].data(), at.size());
      return value;
    };
    minimise(function, x, iterations_of_round, 0.05 * edge_);
    Eigen::Map<VectorXd>(corner[0].data(), x.size()) = x;
  }

  LayeredLattice& lattice_;
  Polygrid& grid_;
  const MapTarget& target_;
  const std::function<void()>& report_;
  std::size_t first_;  ///< outer corner
  double edge_ = 1.0;  ///< of a target cell [mm]
  std::vector<TargetCell> cells_;
  std::optional<CellEnergies> energies_;
  int rounds_ = 0;
  std::vector<Anchor> anchors_;                 ///< of the outer corners
  std::vector<ClosestPoint::Found> of_sample_;  ///< closest faces of the last round
};

}  // namespace

bool map_cells(LayeredLattice& lattice, const MapTarget& target, const MapEffort& effort,
               const std::function<void()>& report) {
  CellMap map(lattice, target, report);
  for (int round = 0; round < effort.rounds; ++round) {
    const double share = static_cast<double>(round) / std::max(1, effort.rounds - 1);
    map.round(effort.first_pull * std::pow(effort.last_pull / effort.first_pull, share),
              effort.power);
  }
  if (!(map.least() > 0.0)) return false;
  if (effort.onto_surface) map.put_onto_surface();
  return true;
}

}  // namespace kappamu::forward

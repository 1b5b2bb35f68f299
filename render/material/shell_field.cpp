#include "render/material/shell_field.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"

namespace kappamu::render {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Of the block's thickness: where shell and core pass into each other.
constexpr double transition = 0.25;
/// Pieces of the core: radius over the block's shortest edge, and over the lattice's.
constexpr double core_radius = 0.48, radius_of_lattice = 0.9;
constexpr double core_sharpness = 4.0;
/// Share of the weight below which a piece is left out.
constexpr double negligible = 1e-4;

/// Half a turn about y, which brings the face z- to z+.
io::VolumeSet turned(io::VolumeSet block) {
  for (Medium& medium : block.media) {
    for (Volume<double>* volume : {&medium.kappa, &medium.mu}) {
      const Volume<double> before = *volume;
      const GridShape& s = before.shape();
      for (int z = 0; z < s.nz; ++z) {
        for (int y = 0; y < s.ny; ++y) {
          for (int x = 0; x < s.nx; ++x) (*volume)(x, y, z) = before(s.nx - 1 - x, y, s.nz - 1 - z);
        }
      }
    }
  }
  return block;
}

/// 1 below 0, 0 above 1, smooth between.
double fade(double at) {
  const double t = std::clamp(at, 0.0, 1.0);
  return 1.0 - t * t * (3.0 - 2.0 * t);
}

}  // namespace

/// Scores of voxels under weights: Σ w m + (Σ w (s − m)) / sqrt(Σ w²) with Σ w = 1, m being the
/// mean of what a voxel was drawn from.
class ShellField::Mixture {
 public:
  explicit Mixture(const NormalScores& scores) : scores_(scores) {}

  /// `layer`: the voxel was drawn from that layer; none: from the whole block.
  void add(double weight, std::size_t voxel, std::optional<int> layer) {
    weight_ += weight;
    squares_ += weight * weight;
    const std::span<const float> scores = scores_.scores(voxel);
    for (std::size_t v = 0; v < scores.size(); ++v) {
      const double mean = layer ? scores_.layer_mean(v, *layer) : 0.0;
      mean_[v] += weight * mean;
      deviation_[v] += weight * (scores[v] - mean);
    }
  }
  double score(std::size_t v) const {
    return mean_[v] / weight_ + deviation_[v] / std::sqrt(squares_);
  }

 private:
  const NormalScores& scores_;
  double weight_ = 0.0, squares_ = 0.0;
  std::array<double, 6> mean_{}, deviation_{};
};

ShellField::ShellField(const io::VolumeSet& block, const Shell& shell, const TriangleMesh& mesh)
    : scores_(shell.outside == Shell::Outside::z_minus ? turned(block) : block), shell_(shell) {
  voxel_ = shell.scale * block.shape().voxel_mm;
  thickness_ = voxel_ * block.shape().nz;
  const ChartOptions options{voxel_, shell.up, shell.seed};
  chart_ = shell.texture_size_mm
               ? make_texture_chart(mesh, scores_, *shell.texture_size_mm, options)
               : make_surface_chart(mesh, scores_, options);
  if (shell.core != Shell::Core::mean_values) return;
  for (const FaceChart::Anchor& anchor : chart_->anchors()) {
    Mixture one(scores_);
    one.add(1.0, face_voxel(anchor.at_mm, 0), std::nullopt);
    below_.push_back(mixed(one));
  }
}

std::size_t ShellField::face_voxel(const Vector2d& at_mm, int z) const {
  const GridShape& shape = scores_.shape();
  return shape.index(std::clamp(static_cast<int>(at_mm.x() / voxel_), 0, shape.nx - 1),
                     std::clamp(static_cast<int>(at_mm.y() / voxel_), 0, shape.ny - 1), z);
}

bool ShellField::of_point_alone(double shallow, double /*deep*/) const {
  return shallow >=
         (shell_.core == Shell::Core::mean_values ? (1.0 + transition) * thickness_ : thickness_);
}

ColourCoefficients ShellField::at(const Place& place) const {
  const double rim = transition * thickness_;
  Mixture mixture(scores_);
  if (shell_.core == Shell::Core::mean_values) {
    const double share = fade((place.depth - thickness_) / rim);
    if (share == 0.0) return interpolated(place.point);
    add_shell(place, 1.0, mixture);
    ColourCoefficients result = mixed(mixture);
    if (share == 1.0) return result;
    const ColourCoefficients core = interpolated(place.point);
    for (std::size_t c = 0; c < result.size(); ++c) {
      result[c].kappa += (1.0 - share) * (core[c].kappa - result[c].kappa);
      result[c].mu += (1.0 - share) * (core[c].mu - result[c].mu);
    }
    return result;
  }
  const double share = fade((place.depth - thickness_ + rim) / rim);
  if (share > 0.0) add_shell(place, share, mixture);
  if (share < 1.0) add_core(place.point, 1.0 - share, mixture);
  return mixed(mixture);
}

ColourCoefficients ShellField::mixed(const Mixture& mixture) const {
  ColourCoefficients result;
  for (std::size_t v = 0; v < scores_.count(); v += 2) {
    result[v / 2] = {scores_.value(v, mixture.score(v)),
                     scores_.value(v + 1, mixture.score(v + 1))};
  }
  if (scores_.count() == 2) result[1] = result[2] = result[0];
  return result;
}

/// `share` of the whole mixture's weight.
void ShellField::add_shell(const Place& place, double share, Mixture& mixture) const {
  const GridShape& shape = scores_.shape();
  const int layer = std::min(static_cast<int>(place.depth / voxel_), shape.nz - 1);
  const int z = shape.nz - 1 - layer;
  const FacePlaces places = chart_->places(place);
  double sum = 0.0;
  for (const FacePlace& at : places.all()) sum += at.weight;
  for (const FacePlace& at : places.all()) {
    if (at.weight < negligible * sum) continue;
    mixture.add(share * at.weight / sum, face_voxel(at.at_mm, z), z);
  }
}

/// Balls of the block about the points of a cubic lattice, each drawn anywhere in it, unturned.
void ShellField::add_core(const Vector3d& point, double share, Mixture& mixture) const {
  const GridShape& shape = scores_.shape();
  const Vector3d extent = voxel_ * Vector3d(shape.nx, shape.ny, shape.nz);
  const double radius = core_radius * extent.minCoeff(), lattice = radius / radius_of_lattice;
  const Vector3d base = (point / lattice).array().floor();
  std::array<double, 27> weight{};
  std::array<std::size_t, 27> voxel{};
  double sum = 0.0;
  for (int k = 0; k < 27; ++k) {
    const Vector3d cell = base + Vector3d(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
    const Vector3d way = point - lattice * (cell + Vector3d::Constant(0.5));
    const double central = 1.0 - way.squaredNorm() / (radius * radius);
    if (central <= 0.0) continue;
    const auto i = static_cast<std::size_t>(k);
    weight[i] = std::pow(central, 2.0 * core_sharpness);
    sum += weight[i];
    std::uint64_t key = shell_.seed + 0x5EED;
    for (const double part : cell)
      key = key_of({key, static_cast<std::uint64_t>(static_cast<std::int64_t>(part))});
    Vector3d at;
    for (const int axis : {0, 1, 2}) {
      key = mix(key);
      at[axis] = radius + uniform(key) * (extent[axis] - 2.0 * radius) + way[axis];
    }
    const auto index = [&](int axis, int count) {
      return std::clamp(static_cast<int>(at[axis] / voxel_), 0, count - 1);
    };
    voxel[i] = shape.index(index(0, shape.nx), index(1, shape.ny), index(2, shape.nz));
  }
  for (std::size_t i = 0; i < weight.size(); ++i) {
    if (weight[i] > negligible * sum) mixture.add(share * weight[i] / sum, voxel[i], std::nullopt);
  }
}

/// Weights are solid angles over distances.
ColourCoefficients ShellField::interpolated(const Vector3d& point) const {
  ColourCoefficients sum{};
  double weights = 0.0;
  const std::span<const FaceChart::Anchor> anchors = chart_->anchors();
  for (std::size_t k = 0; k < anchors.size(); ++k) {
    const FaceChart::Anchor& anchor = anchors[k];
    const Vector3d way = anchor.point - point;
    const double squared = way.squaredNorm();
    const double weight = std::max(0.0, way.dot(anchor.normal)) / (squared * squared);
    if (weight == 0.0) continue;
    const ColourCoefficients& there = below_[k];
    for (std::size_t c = 0; c < sum.size(); ++c) {
      sum[c].kappa += weight * there[c].kappa;
      sum[c].mu += weight * there[c].mu;
    }
    weights += weight;
  }
  if (weights == 0.0) return below_.front();
  for (Coefficients& channel : sum) {
    channel.kappa /= weights;
    channel.mu /= weights;
  }
  return sum;
}

}  // namespace kappamu::render

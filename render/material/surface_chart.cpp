// Round pieces of a block laid over a surface.
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <vector>

#include "core/error.h"
#include "core/mesh/box_tree.h"
#include "core/numbers/at.h"
#include "core/random.h"
#include "forward/polygrid/closest_point.h"
#include "render/material/face_chart.h"

namespace kappamu::render {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Radius of a piece, over the face's shorter edge and over the object's longest.
constexpr double radius_of_face = 1.0 / 3.0, radius_of_object = 0.25;
constexpr double spacing_of_radius = 0.625;
/// Points tried for centres, per square of the spacing.
constexpr double tries = 16.0;
constexpr double smallest_facing = 0.02;
constexpr int candidates = 24;

struct Piece {
  Vector3d centre, normal, x, y;  ///< a right-handed frame, the normal outward
  Vector2d at_mm{0.0, 0.0};       ///< of its centre on the block's face

  /// Where a point of the surface lies, from the centre: its distance and direction.
  Vector2d chart(const Vector3d& point) const {
    const Vector3d way = point - centre;
    const Vector2d flat(way.dot(x), way.dot(y));
    const double length = flat.norm();
    return length > 0.0 ? Vector2d(flat * (way.norm() / length)) : flat;
  }
};

/// Centres of pieces by the cells of a lattice, for those near a point.
class Near {
 public:
  explicit Near(double cell) : cell_(cell) {}
  void add(const Vector3d& point, int piece) { cells_[key(index(point))].push_back(piece); }
  /// Of the cells up to one cell's edge away.
  template <class Act>
  void visit(const Vector3d& point, const Act& act) const {
    const Eigen::Vector3i middle = index(point);
    for (int k = 0; k < 27; ++k) {
      const auto found =
          cells_.find(key(middle + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)));
      if (found == cells_.end()) continue;
      for (const int piece : found->second) act(piece);
    }
  }

 private:
  Eigen::Vector3i index(const Vector3d& point) const {
    return (point / cell_).array().floor().cast<int>();
  }
  static std::uint64_t key(const Eigen::Vector3i& i) {
    const auto part = [](int value) { return static_cast<std::uint64_t>(value + (1 << 20)); };
    return part(i.x()) << 42U | part(i.y()) << 21U | part(i.z());
  }
  double cell_;
  std::unordered_map<std::uint64_t, std::vector<int>> cells_;
};

class SurfaceChart : public FaceChart {
 public:
  SurfaceChart(const TriangleMesh& mesh, const NormalScores& scores, const ChartOptions& options)
      : scores_(scores), options_(options) {
    const GridShape& shape = scores.shape();
    face_ = options.voxel_mm * Vector2d(shape.nx, shape.ny);
    radius_ = std::min(radius_of_face * face_.minCoeff(),
                       radius_of_object * bounding_box(mesh).sizes().maxCoeff());
    if (std::min(shape.nx, shape.ny) < 6) {
      throw InputError("the volume's face is " + std::to_string(shape.nx) + " x " +
                       std::to_string(shape.ny) +
                       " voxels, too few to lay pieces of it over a surface; 6 x 6 are needed");
    }
    Near near(radius_);
    scatter_centres(mesh, near);
    for (int i = 0; i < static_cast<int>(pieces_.size()); ++i) choose_place(i, near);
    build_tree();
    for (const Piece& piece : pieces_) {
      if (anchors_.size() < most_anchors)
        anchors_.push_back({piece.centre, piece.normal, piece.at_mm});
    }
  }

  FacePlaces places(const Place& place) const override {
    FacePlaces found;
    tree_->visit([&](const Eigen::AlignedBox3d& box) { return box.contains(place.surface); },
                 [&](int i) {
                   const Piece& piece = pieces_[at(i)];
                   const Vector2d from_centre = piece.chart(place.surface);
                   const double central = 1.0 - from_centre.squaredNorm() / (radius_ * radius_);
                   if (central <= 0.0) return;
                   const double facing = std::max(place.normal.dot(piece.normal), smallest_facing);
                   found.add({std::pow(central * central * facing, piece_sharpness),
                              piece.at_mm + from_centre});
                 });
    return found;
  }

  std::span<const Anchor> anchors() const override { return anchors_; }

 private:
  /// Random points of the surface, each kept unless one before it is too near and faces alike.
  void scatter_centres(const TriangleMesh& mesh, Near& near) {
    const Surface surface = surface_of(mesh);
    const forward::ClosestPoint closest(mesh);
    std::vector<double> below(surface.size());
    double area = 0.0;
    for (std::size_t t = 0; t < below.size(); ++t) below[t] = area += surface.area[t];
    const double spacing = spacing_of_radius * radius_;
    const double count = std::ceil(tries * area / (spacing * spacing)) + 64.0;
    constexpr double most = 2e7;
    if (count > most) {
      throw InputError("the object is so large for the volume that " +
                       std::to_string(static_cast<long long>(count / tries)) +
                       " pieces of its face would cover it; make size_mm smaller, or scale larger");
    }
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(count); ++i) {
      const auto random = [&](std::uint64_t k) { return uniform(key_of({options_.seed, i, k})); };
      const auto found = std::lower_bound(below.begin(), below.end(), random(0) * area);
      const auto t = std::min(static_cast<std::size_t>(found - below.begin()), below.size() - 1);
      const double root = std::sqrt(random(1)), share = random(2);
      forward::ClosestPoint::Found place;
      place.triangle = static_cast<int>(t);
      place.weights = {1.0 - root, root * (1.0 - share), root * share};
      place.point.setZero();
      for (int k = 0; k < 3; ++k)
        place.point += place.weights[k] * mesh.vertices[at(mesh.triangles[t][at(k)])];
      add_centre(place.point, closest.smooth_normal(place), spacing, near);
    }
  }

  void add_centre(const Vector3d& point, const Vector3d& normal, double spacing, Near& near) {
    bool free = true;
    near.visit(point, [&](int other) {
      const Piece& piece = pieces_[at(other)];
      free = free && ((piece.centre - point).norm() >= spacing || piece.normal.dot(normal) < 0.2);
    });
    if (!free) return;
    Piece piece;
    piece.centre = point;
    piece.normal = normal;
    Vector3d up = options_.up - options_.up.dot(normal) * normal;
    // Where the surface faces along `up`, its direction along the surface is none.
    if (up.norm() < 0.05 * options_.up.norm()) up = normal.unitOrthogonal();
    piece.y = up.normalized();
    piece.x = piece.y.cross(normal);
    near.add(point, static_cast<int>(pieces_.size()));
    pieces_.push_back(piece);
  }

  void choose_place(int index, const Near& near) {
    Piece& piece = pieces_[at(index)];
    std::vector<int> laid;
    near.visit(piece.centre, [&](int other) {
      const Piece& there = pieces_[at(other)];
      if (other < index && (there.centre - piece.centre).norm() < radius_ &&
          there.normal.dot(piece.normal) > 0.5)
        laid.push_back(other);
    });
    std::sort(laid.begin(), laid.end());
    Vector2d best = Vector2d::Zero();
    double least = std::numeric_limits<double>::infinity();
    for (std::uint64_t trial = 0; trial < (laid.empty() ? 1 : candidates); ++trial) {
      const auto random = [&](std::uint64_t k) {
        return uniform(key_of({options_.seed, static_cast<std::uint64_t>(index), trial, k, 7}));
      };
      piece.at_mm =
          Vector2d::Constant(radius_) +
          Vector2d(random(0), random(1)).cwiseProduct(face_ - Vector2d::Constant(2.0 * radius_));
      const double misfit = misfit_to(piece, laid);
      if (misfit >= least) continue;
      least = misfit;
      best = piece.at_mm;
    }
    piece.at_mm = best;
  }

  /// Sum of squared differences of scores half way to the pieces laid before.
  double misfit_to(const Piece& piece, const std::vector<int>& laid) const {
    const GridShape& shape = scores_.shape();
    double sum = 0.0;
    for (const int other : laid) {
      const Piece& there = pieces_[at(other)];
      const Vector3d middle = 0.5 * (piece.centre + there.centre);
      const Vector3d across = (there.centre - piece.centre).cross(piece.normal).normalized();
      for (int k = -2; k <= 2; ++k) {
        const Vector3d point = middle + 0.2 * k * radius_ * across;
        for (const int z : {shape.nz - 1, shape.nz / 2}) {
          const std::size_t one = voxel(piece.at_mm + piece.chart(point), z);
          const std::size_t two = voxel(there.at_mm + there.chart(point), z);
          for (std::size_t v = 0; v < scores_.count(); ++v)
            sum += std::pow(scores_.scores(one)[v] - scores_.scores(two)[v], 2);
        }
      }
    }
    return sum;
  }

  std::size_t voxel(const Vector2d& at_mm, int z) const {
    const GridShape& shape = scores_.shape();
    return shape.index(std::clamp(static_cast<int>(at_mm.x() / options_.voxel_mm), 0, shape.nx - 1),
                       std::clamp(static_cast<int>(at_mm.y() / options_.voxel_mm), 0, shape.ny - 1),
                       z);
  }

  void build_tree() {
    std::vector<Eigen::AlignedBox3d> boxes;
    for (const Piece& piece : pieces_) {
      boxes.emplace_back(piece.centre - Vector3d::Constant(radius_),
                         piece.centre + Vector3d::Constant(radius_));
    }
    tree_ = std::make_unique<BoxTree>(boxes);
  }

  const NormalScores& scores_;
  ChartOptions options_;
  Vector2d face_;
  double radius_ = 0.0;  ///< of pieces [mm]
  std::vector<Piece> pieces_;
  std::unique_ptr<BoxTree> tree_;
  std::vector<Anchor> anchors_;
};

}  // namespace

std::unique_ptr<FaceChart> make_surface_chart(const TriangleMesh& mesh, const NormalScores& scores,
                                              const ChartOptions& options) {
  return std::make_unique<SurfaceChart>(mesh, scores, options);
}

}  // namespace kappamu::render

#include "forward/dipole/hierarchy/cluster_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/error.h"
#include "core/parallel.h"

namespace kappamu::forward::dipole {

namespace {

/// Clusters of this level are refitted independently of each other.
constexpr int task_level = 6;
/// A cluster has triangles of two sides where the farthest corner of its box is this many radii
/// away, or this many radii of a disc of its area: a square aslant has 2.1 of both.
constexpr float most_radii = 2.2F, most_disc_radii = 4.0F;

Eigen::Array4f packed(const Eigen::Vector3f& v, float last) {
  return {v.x(), v.y(), v.z(), last};
}

}  // namespace

ClusterTree::ClusterTree(const TriangleMesh& mesh) {
  const std::size_t count = mesh.triangles.size();
  check(count > 0, "a hierarchy needs triangles");
  while ((count >> depth_) > leaf_triangles) ++depth_;
  std::vector<Eigen::Vector3f> centroid;
  centroid.reserve(count);
  for (const auto& t : mesh.triangles) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const int v : t) sum += mesh.vertices[static_cast<std::size_t>(v)];
    centroid.emplace_back((sum / 3.0).cast<float>());
  }
  order_.resize(count);
  for (std::size_t leaf = 0; leaf <= std::size_t{1} << depth_; ++leaf) {
    first_.push_back(static_cast<int>((count * leaf) >> depth_));
  }
  std::iota(order_.begin(), order_.end(), 0);
  split(centroid, 0, 0);
  refit(mesh);
}

void ClusterTree::split(const std::vector<Eigen::Vector3f>& centroid, int level, std::size_t i) {
  if (level == depth_) return;
  const auto at = [&](std::size_t position) {
    return order_.begin() + static_cast<std::ptrdiff_t>(position);
  };
  const auto first = at(begin(level, i)), last = at(begin(level, i + 1));
  const auto middle = at(begin(level + 1, 2 * i + 1));
  Eigen::AlignedBox3f box;
  for (auto t = first; t != last; ++t) box.extend(centroid[static_cast<std::size_t>(*t)]);
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const auto less = [&](int a, int b) {
    return centroid[static_cast<std::size_t>(a)][axis] <
           centroid[static_cast<std::size_t>(b)][axis];
  };
  if (level + 1 == depth_) {
    std::sort(first, last, less);
    first_[2 * i + 1] = last_cut(centroid, axis, 2 * i);
    return;
  }
  if (first != last) std::nth_element(first, middle, last, less);
  split(centroid, level + 1, 2 * i);
  split(centroid, level + 1, 2 * i + 1);
}

int ClusterTree::last_cut(const std::vector<Eigen::Vector3f>& centroid, int axis,
                          std::size_t leaf) const {
  const auto at = [&](int p) {
    return centroid[static_cast<std::size_t>(order_[static_cast<std::size_t>(p)])][axis];
  };
  int cut = first_[leaf + 1];
  for (int p = first_[leaf] + 1; p < first_[leaf + 2]; ++p) {
    if (at(p) - at(p - 1) > at(cut) - at(cut - 1)) cut = p;
  }
  return cut;
}

void ClusterTree::check_same(const TriangleMesh& mesh) const {
  if (mesh.triangles.size() != triangles()) {
    throw InputError("the hierarchy was built for " + std::to_string(triangles()) +
                     " triangles but the mesh has " + std::to_string(mesh.triangles.size()) +
                     "; build it anew where the topology changes");
  }
}

void ClusterTree::refit(const TriangleMesh& mesh) {
  check_same(mesh);
  const std::size_t count = order_.size();
  point_.resize(count);
  spread_.resize(2 * count);
  corner_.resize(3 * count);
  cluster_.resize((std::size_t{2} << depth_) - 1);
  weight_.resize(cluster_.size());
  box_.resize(cluster_.size());
  // Subtrees on their own, then the clusters above them.
  const int level = std::min(task_level, depth_);
  for_rows(1 << level, [&](int row) {
    const auto task = static_cast<std::size_t>(row);
    for (std::size_t p = begin(level, task); p < begin(level, task + 1); ++p) {
      refit_triangle(mesh, p);
    }
    for (int l = depth_; l >= level; --l) {
      const std::size_t width = std::size_t{1} << (l - level), first = (std::size_t{1} << l) - 1;
      for (std::size_t i = task * width; i < (task + 1) * width; ++i) {
        if (l == depth_) {
          refit_leaf(first + i, begin(l, i), begin(l, i + 1));
        } else {
          refit_cluster(first + i);
        }
      }
    }
  });
  for (std::size_t k = (std::size_t{1} << level) - 1; k-- > 0;) refit_cluster(k);
}

void ClusterTree::refit_triangle(const TriangleMesh& mesh, std::size_t p) {
  const auto& t = mesh.triangles[static_cast<std::size_t>(order_[p])];
  Eigen::Vector3f v[3];
  for (std::size_t c = 0; c < 3; ++c) {
    v[c] = mesh.vertices[static_cast<std::size_t>(t[c])].cast<float>();
    corner_[3 * p + c] = packed(v[c], 0.0F);
  }
  const Eigen::Vector3f centre = (v[0] + v[1] + v[2]) / 3.0F;
  point_[p] = packed(centre, 0.5F * (v[1] - v[0]).cross(v[2] - v[0]).norm());
  Eigen::Matrix3f m = Eigen::Matrix3f::Zero();
  for (const Eigen::Vector3f& corner : v) {
    m += (corner - centre) * (corner - centre).transpose() / 12.0F;
  }
  spread_[2 * p] = {m(0, 0), m(1, 1), m(2, 2), 0.0F};
  spread_[2 * p + 1] = {m(0, 1), m(0, 2), m(1, 2), std::sqrt(2.0F * m.trace())};
}

void ClusterTree::refit_leaf(std::size_t k, std::size_t first, std::size_t last) {
  cluster_[k] = point_[first];
  weight_[k].setZero();
  box_[k].setEmpty();
  for (std::size_t p = first; p < last; ++p) {
    const float area = point_[p][3];
    add(k, point_[p], {area, area * spread_[2 * p].head<3>().sum()});
    box_[k].extend(Eigen::Vector3f(point_[p].head<3>()));
  }
  set_radius(k);
}

void ClusterTree::refit_cluster(std::size_t k) {
  cluster_[k] = cluster_[2 * k + 1];
  weight_[k] = weight_[2 * k + 1];
  add(k, cluster_[2 * k + 2], weight_[2 * k + 2]);
  box_[k] = box_[2 * k + 1].merged(box_[2 * k + 2]);
  set_radius(k);
}

void ClusterTree::add(std::size_t k, const Eigen::Array4f& centre, const Eigen::Array2f& weight) {
  const float whole = weight_[k][0] + weight[0], share = whole > 0.0F ? weight[0] / whole : 0.0F;
  const Eigen::Array3f apart = centre.head<3>() - cluster_[k].head<3>();
  weight_[k][1] += weight[1] + weight_[k][0] * share * apart.square().sum();
  weight_[k][0] = whole;
  cluster_[k].head<3>() += share * apart;
}

void ClusterTree::set_radius(std::size_t k) {
  const float area = std::max(weight_[k][0], 1e-30F);
  float& radius = cluster_[k][3] = std::sqrt(2.0F * weight_[k][1] / area);
  const Eigen::Array3f centre = cluster_[k].head<3>();
  const float farthest =
      (box_[k].max().array() - centre).max(centre - box_[k].min().array()).matrix().norm();
  const float disc = std::sqrt(area / std::numbers::pi_v<float>);
  if (farthest > most_radii * radius || farthest > most_disc_radii * disc) {
    radius = std::max(radius, farthest);
  }
}

}  // namespace kappamu::forward::dipole

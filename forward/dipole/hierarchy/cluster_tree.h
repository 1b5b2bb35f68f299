// Any triangle mesh as a hierarchy of clusters: a complete binary tree over a permutation of the
// triangles, cut at the median of the centroids along the longest axis. Cluster k has the children
// 2k + 1 and 2k + 2. The last cut is at the widest gap between centroids instead where that is most
// of their extent, so that leaves seldom have triangles of two sides of the object. The tree is
// built once; where vertices move, only centres and extents are renewed.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace kappamu::forward::dipole {

/// Triangles of a leaf, on average, at most one more.
inline constexpr std::size_t leaf_triangles = 2;

class ClusterTree {
 public:
  explicit ClusterTree(const TriangleMesh& mesh);
  /// The same triangles with other vertices. Throws InputError where their number differs.
  /// The reference of refit.cl.
  void refit(const TriangleMesh& mesh);
  void check_same(const TriangleMesh& mesh) const;
  /// Clusters alone, as they were refitted elsewhere.
  void set_clusters(std::vector<Eigen::Array4f> cluster) { cluster_ = std::move(cluster); }

  int depth() const { return depth_; }  ///< leaves are on this level
  std::size_t clusters() const { return cluster_.size(); }
  std::size_t triangles() const { return order_.size(); }
  std::size_t first_leaf() const { return (std::size_t{1} << depth_) - 1; }
  bool leaf(std::size_t k) const { return k >= first_leaf(); }
  /// Of the positions in the permutation that cluster i of a level holds; i + 1: their end.
  std::size_t begin(int level, std::size_t i) const {
    return static_cast<std::size_t>(first_[i << (depth_ - level)]);
  }
  /// The first position of each leaf, and the end of the last.
  const std::vector<int>& first() const { return first_; }

  /// Triangle of the mesh at each position.
  const std::vector<int>& order() const { return order_; }
  /// Per cluster: centre of area x, y, z and radius √(2 ⟨d²⟩), that of a disc with the same mean
  /// squared distance [mm]. Cutting at the median leaves a few clusters with triangles of two
  /// sides of the object; their radius is the distance of the farthest corner of their box, so that
  /// the one or two triangles far from the centre are not taken by its series.
  const std::vector<Eigen::Array4f>& cluster() const { return cluster_; }
  /// Per position: centroid [mm] and area [mm²].
  const std::vector<Eigen::Array4f>& point() const { return point_; }
  /// Per position, two: mean of (x², y², z², ·) and (xy, xz, yz, radius) about the centroid [mm²],
  /// [mm].
  const std::vector<Eigen::Array4f>& spread() const { return spread_; }
  /// Per position, three corners [mm].
  const std::vector<Eigen::Array4f>& corner() const { return corner_; }

 private:
  void split(const std::vector<Eigen::Vector3f>& centroid, int level, std::size_t i);
  /// Between two leaves, whose triangles are in order along the axis.
  int last_cut(const std::vector<Eigen::Vector3f>& centroid, int axis, std::size_t leaf) const;
  void refit_triangle(const TriangleMesh& mesh, std::size_t position);
  void refit_leaf(std::size_t k, std::size_t first, std::size_t last);
  void refit_cluster(std::size_t k);
  /// Adds a part to cluster k: its centre, and its area with Σ area · d² about that.
  void add(std::size_t k, const Eigen::Array4f& centre, const Eigen::Array2f& weight);
  void set_radius(std::size_t k);

  int depth_ = 0;
  std::vector<int> order_, first_;
  std::vector<Eigen::Array4f> cluster_, point_, spread_, corner_;
  std::vector<Eigen::AlignedBox3f> box_;  ///< per cluster, of its centroids
  std::vector<Eigen::Array2f> weight_;    ///< per cluster: area [mm²], Σ area · d² [mm⁴]
};

}  // namespace kappamu::forward::dipole

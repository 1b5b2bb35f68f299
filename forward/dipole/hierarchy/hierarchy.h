// The dipole's surface integral over a triangle mesh, M(x_o) = Σ_k E_k ∫_k R_d(|x_i − x_o|) dA_i
// ([T] 3.9), by a hierarchical boundary element method after [M] on an OpenCL device: irradiance is
// pulled up a tree of clusters, gathered over links and pushed down. Where [M] links by one point
// sample and hands constants down, clusters here carry moments to the second order and links make
// Taylor series to the second order, so that a tenth of the links reach 1 %. Form factors of
// triangles near their receiver are edge integrals. Cost is log-linear in the triangles.
//
// [M]'s modes: light alone changes (static: exitance() again), material or geometry with it
// (incremental: update(), links kept while they are good enough), all from nothing (on the fly:
// renew()). Lengths in mm.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "device/context.h"
#include "forward/dipole/hierarchy/links.h"
#include "forward/dipole/hierarchy/profile_table.h"

namespace kappamu::forward::dipole {

/// Of a GPU: work-items that share one receiver's lists.
inline constexpr std::size_t items_together = 32;

struct HierarchyOptions {
  float opening = 0.68F;  ///< of the oracle: error falls with about its third power
  float slack = 1.2F;     ///< kept links may exceed the opening by this factor
  /// Links that one update() moves at most; others wait for the next, those farthest from the
  /// oracle being moved first ([M] 5.5 bounds the form factors of a frame).
  std::size_t most_changes = std::numeric_limits<std::size_t>::max();
  /// How work is divided where it is not the device's own way: that of a GPU runs anywhere.
  std::optional<device::Kind> form = {};
};

class Hierarchy {
 public:
  /// `profiles`: one to four, a lane each; the last also serves the lanes after it.
  Hierarchy(device::Context& context, const TriangleMesh& mesh, std::span<const Profile> profiles,
            const HierarchyOptions& options = {});

  /// Other material, or vertices moved as well; links stay where they are good enough still, and
  /// move in the hierarchy otherwise. Throws InputError where the number of triangles differs.
  void update(std::span<const Profile> profiles);
  void update(const TriangleMesh& mesh, std::span<const Profile> profiles);
  /// The same with all links made anew.
  void renew(const TriangleMesh& mesh, std::span<const Profile> profiles);
  void set_opening(float opening);
  void set_most_changes(std::size_t most) { options_.most_changes = most; }

  /// Exitance at the centroids from the transmitted irradiance on each triangle, in the mesh's
  /// order.
  std::vector<Eigen::Array4f> exitance(std::span<const Eigen::Array4f> irradiance);

  std::size_t links() const { return links_; }
  std::size_t near_pairs() const { return near_pairs_; }   ///< of leaves
  Links links_made() const;                                ///< those that the device has
  Oracle oracle(float opening) const;                      ///< of the present profiles
  const LinkChanges& changes() const { return changes_; }  ///< of the last update()
  std::vector<Eigen::Array4f> clusters() const;            ///< as ClusterTree::cluster()

 private:
  void set_mesh(const TriangleMesh& mesh);
  void set_profiles(std::span<const Profile> profiles);
  void relink();
  bool link_levels();  ///< false where the pools were too small, which have grown
  void grow(device::Buffer& pool);
  void upload_links();
  /// `on_cpu`: work-items that a processor's core walks at once.
  device::Range items(std::size_t count, std::size_t on_cpu) const;
  /// Of a GPU: a work-group for each receiver.
  static device::Range groups(int receivers);

  device::Context& context_;
  HierarchyOptions options_;
  ClusterTree tree_;                            ///< its clusters are those of the last update()
  std::vector<std::array<int, 3>> corners_of_;  ///< per triangle of the mesh, as uploaded
  double farthest_ = 0.0;                       ///< two points of the mesh at most [mm]
  ProfileTable table_;
  std::size_t links_ = 0, near_pairs_ = 0;
  std::optional<Links> kept_;  ///< the device's, from the first update() after they were made
  LinkChanges changes_;
  bool gpu_ = false;
  int subtree_ = 0;  ///< levels below the root of a subtree that one work-item takes
  device::Program* program_ = nullptr;
  device::Buffer first_, order_, index_, vertex_, cluster_, weight_, box_;
  device::Buffer point_, spread_, corner_, profile_table_;
  device::Buffer cluster_range_, emitter_, leaf_range_, near_, left_range_, left_, used_;
  device::Buffer irradiance_, power_, moments_, series_, exitance_;
};

}  // namespace kappamu::forward::dipole

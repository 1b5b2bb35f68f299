#include "forward/dipole/hierarchy/hierarchy.h"

#include <algorithm>

#include "core/error.h"

namespace kappamu::forward {
extern const device::KernelSource hierarchy_cl;
}

namespace kappamu::forward::dipole {

namespace {

constexpr std::size_t moments_per_cluster = 10;
/// Share of the opening for one triangle's moments, whose third ones do not vanish as a cluster's
/// nearly do.
constexpr float triangle_share = 0.8F;
/// Work-items of a group; a CPU walks them one after the other.
constexpr std::size_t cpu_group = 64, gpu_group = 64;
/// Levels below the root of a subtree that one work-item takes; a GPU has more items than leaves.
constexpr int cpu_subtree = 8, gpu_subtree = 0;

/// Writes `values` to the buffer, which grows where it is too small.
template <class T>
void upload(device::Context& context, const std::vector<T>& values, device::Buffer& buffer) {
  const std::size_t bytes = values.size() * sizeof(T);
  if (buffer.bytes() < std::max<std::size_t>(bytes, 1)) {
    buffer = context.allocate(std::max(bytes + bytes / 4, sizeof(T)));
  }
  if (bytes > 0) context.write(buffer, values.data(), bytes);
}

}  // namespace

Hierarchy::Hierarchy(device::Context& context, const TriangleMesh& mesh,
                     std::span<const Profile> profiles, const HierarchyOptions& options)
    : context_(context),
      options_(options),
      tree_(mesh),
      subtree_(context.info().kind == device::Kind::gpu ? gpu_subtree : cpu_subtree),
      program_(
          &context.program(hierarchy_cl, "-DTABLE_BITS=" + std::to_string(table_bits) +
                                             " -DSUBTREE_LEVELS=" + std::to_string(subtree_))) {
  const std::size_t vector = sizeof(Eigen::Array4f), triangles = tree_.triangles();
  irradiance_ = context.allocate(triangles * vector);
  power_ = context.allocate(triangles * vector);
  exitance_ = context.allocate(triangles * vector);
  moments_ = context.allocate(tree_.clusters() * moments_per_cluster * vector);
  series_ = context.allocate(tree_.clusters() * moments_per_cluster * vector);
  upload(context_, tree_.order(), order_);
  renew(mesh, profiles);
}

device::Range Hierarchy::items(std::size_t count, std::size_t on_cpu) const {
  const std::size_t group =
      context_.info().kind == device::Kind::gpu ? gpu_group : std::min(on_cpu, count);
  return {count, 1, group, 1};
}

Oracle Hierarchy::oracle(float opening) const {
  return {opening, table_.smooth, table_.decay, table_.least_decay};
}

void Hierarchy::set_mesh(const TriangleMesh& mesh) {
  tree_.refit(mesh);
  farthest_ = 1.01 * bounding_box(mesh).diagonal().norm();
  upload(context_, tree_.cluster(), cluster_);
  upload(context_, tree_.point(), point_);
  upload(context_, tree_.spread(), spread_);
  upload(context_, tree_.corner(), corner_);
}

void Hierarchy::set_profiles(std::span<const Profile> profiles) {
  table_ = tabulate(profiles, farthest_);
  upload(context_, table_.entries, profile_table_);
}

void Hierarchy::relink() {
  links_ = link(tree_, oracle(options_.opening));
  changes_ = {};
  upload_links();
}

void Hierarchy::upload_links() {
  upload(context_, links_.of_cluster, cluster_range_);
  upload(context_, links_.emitter, emitter_);
  upload(context_, links_.of_leaf, leaf_range_);
  upload(context_, links_.near, near_);
}

void Hierarchy::set_opening(float opening) {
  options_.opening = opening;
  relink();
}

void Hierarchy::update(std::span<const Profile> profiles) {
  set_profiles(profiles);
  changes_ = dipole::update(links_, tree_, oracle(options_.slack * options_.opening),
                            oracle(options_.opening), options_.most_changes);
  if (changes_.demoted + changes_.promoted > 0) upload_links();
}

void Hierarchy::update(const TriangleMesh& mesh, std::span<const Profile> profiles) {
  set_mesh(mesh);
  update(profiles);
}

void Hierarchy::renew(const TriangleMesh& mesh, std::span<const Profile> profiles) {
  set_mesh(mesh);
  set_profiles(profiles);
  relink();
}

std::vector<Eigen::Array4f> Hierarchy::exitance(std::span<const Eigen::Array4f> irradiance) {
  check(irradiance.size() == tree_.triangles(), "one irradiance per triangle");
  const int triangles = static_cast<int>(tree_.triangles()), depth = tree_.depth();
  const int levels = std::min(subtree_, depth), roots = 1 << (depth - levels);
  context_.write(irradiance_, irradiance.data(), irradiance.size_bytes());
  const device::Range subtrees = items(static_cast<std::size_t>(roots), 1);
  context_.launch(*program_, "pull_subtrees", subtrees, roots, levels, triangles, depth, order_,
                  irradiance_, point_, spread_, cluster_, power_, moments_);
  const auto of_level = [&](int width) {
    return items(static_cast<std::size_t>(width), cpu_group);
  };
  for (int width = roots / 2; width > 0; width /= 2) {
    context_.launch(*program_, "pull", of_level(width), width, cluster_, moments_);
  }
  for (int width = 1; width <= roots; width *= 2) {
    context_.launch(*program_, "push", of_level(width), width, table_.smooth2, profile_table_,
                    cluster_range_, emitter_, cluster_, moments_, series_);
  }
  context_.launch(*program_, "evaluate_subtrees", subtrees, roots, levels, triangles, depth,
                  table_.smooth2, table_.smooth, triangle_share * options_.opening, table_.decay,
                  profile_table_, cluster_range_, emitter_, leaf_range_, near_, order_, point_,
                  spread_, corner_, cluster_, power_, moments_, series_, exitance_);
  std::vector<Eigen::Array4f> result(irradiance.size());
  context_.read(exitance_, result.data(), result.size() * sizeof(Eigen::Array4f));
  return result;
}

}  // namespace kappamu::forward::dipole

#include "forward/dipole/hierarchy/hierarchy.h"

#include <algorithm>
#include <array>
#include <string>

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
/// Of a processor: receivers that a work-item links at most, items of a level for each core at
/// least, and places that an item takes of a pool at once for each of its receivers. Cores would
/// wait for each other at every receiver, and gaps between the items' places slow the sum down.
constexpr std::size_t most_receivers = 64, items_a_core = 16;
constexpr int places_a_receiver = 8;
/// Places of a pool of links for each triangle, at first; and the most bytes of one.
constexpr std::size_t first_links = 16, most_pool_bytes = std::size_t{1} << 32;
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
      gpu_(options.form.value_or(context.info().kind) == device::Kind::gpu),
      subtree_(gpu_ ? gpu_subtree : cpu_subtree),
      program_(
          &context.program(hierarchy_cl, "-DTABLE_BITS=" + std::to_string(table_bits) +
                                             " -DSUBTREE_LEVELS=" + std::to_string(subtree_) +
                                             " -DTOGETHER=" + std::to_string(items_together))) {
  const std::size_t vector = sizeof(Eigen::Array4f), triangles = tree_.triangles();
  point_ = context.allocate(triangles * vector);
  spread_ = context.allocate(2 * triangles * vector);
  corner_ = context.allocate(3 * triangles * vector);
  cluster_ = context.allocate(tree_.clusters() * vector);
  weight_ = context.allocate(tree_.clusters() * sizeof(Eigen::Array2f));
  box_ = context.allocate(2 * tree_.clusters() * vector);
  irradiance_ = context.allocate(triangles * vector);
  power_ = context.allocate(triangles * vector);
  exitance_ = context.allocate(triangles * vector);
  moments_ = context.allocate(tree_.clusters() * moments_per_cluster * vector);
  series_ = context.allocate(tree_.clusters() * moments_per_cluster * vector);
  const std::size_t clusters = tree_.clusters(), leaves = clusters - tree_.first_leaf();
  cluster_range_ = context.allocate(clusters * sizeof(LinkRange));
  left_range_ = context.allocate(clusters * sizeof(LinkRange));
  leaf_range_ = context.allocate(leaves * sizeof(LinkRange));
  for (device::Buffer* pool : {&emitter_, &near_, &left_}) {
    *pool = context.allocate(first_links * triangles * sizeof(int));
  }
  used_ = context.allocate(5 * sizeof(int));
  upload(context_, tree_.order(), order_);
  upload(context_, tree_.first(), first_);
  renew(mesh, profiles);
}

device::Range Hierarchy::items(std::size_t count, std::size_t on_cpu) const {
  return {count, 1, gpu_ ? gpu_group : std::min(on_cpu, count), 1};
}

device::Range Hierarchy::groups(int receivers) {
  return {static_cast<std::size_t>(receivers) * items_together, 1, items_together, 1};
}

Oracle Hierarchy::oracle(float opening) const {
  return {opening, table_.smooth, table_.decay, table_.least_decay};
}

void Hierarchy::set_mesh(const TriangleMesh& mesh) {
  tree_.check_same(mesh);
  farthest_ = 1.01 * bounding_box(mesh).diagonal().norm();
  if (mesh.triangles != corners_of_) {
    corners_of_ = mesh.triangles;
    upload(context_, corners_of_, index_);
  }
  std::vector<Eigen::Array3f> vertices;
  vertices.reserve(mesh.vertices.size());
  for (const Eigen::Vector3d& v : mesh.vertices) vertices.emplace_back(v.cast<float>());
  upload(context_, vertices, vertex_);
  const int depth = tree_.depth(), levels = std::min(subtree_, depth);
  const int roots = 1 << (depth - levels);
  context_.launch(*program_, "refit_subtrees", items(static_cast<std::size_t>(roots), 1), roots,
                  levels, first_, order_, index_, vertex_, point_, spread_, corner_, cluster_,
                  weight_, box_);
  for (int width = roots / 2; width > 0; width /= 2) {
    context_.launch(*program_, "refit", items(static_cast<std::size_t>(width), cpu_group), width,
                    cluster_, weight_, box_);
  }
}

void Hierarchy::set_profiles(std::span<const Profile> profiles) {
  table_ = tabulate(profiles, farthest_);
  upload(context_, table_.entries, profile_table_);
}

void Hierarchy::relink() {
  while (!link_levels()) {
  }
  kept_.reset();
  changes_ = {};
}

bool Hierarchy::link_levels() {
  const Oracle o = oracle(options_.opening);
  device::Buffer* const pools[]{&emitter_, &near_, &left_};
  const auto capacity = [](const device::Buffer& pool) {
    return static_cast<int>(pool.bytes() / sizeof(int));
  };
  context_.zero(used_, used_.bytes());
  for (int width = 1; width <= 1 << tree_.depth(); width *= 2) {
    const auto level = [&](const char* kernel, const device::Range& range, auto... own) {
      context_.launch(*program_, kernel, range, width, own..., static_cast<int>(tree_.first_leaf()),
                      o.opening, o.smooth, o.decay, o.least_decay, capacity(emitter_),
                      capacity(near_), capacity(left_), cluster_, left_range_, left_,
                      cluster_range_, emitter_, leaf_range_, near_, used_);
    };
    if (gpu_) {
      level("link_level_together", groups(width));
    } else {
      const auto receivers = static_cast<std::size_t>(width);
      const std::size_t run = std::clamp<std::size_t>(
          receivers / (items_a_core * context_.info().compute_units), 1, most_receivers);
      level("link_level", items((receivers + run - 1) / run, 1), static_cast<int>(run),
            places_a_receiver * static_cast<int>(run));
    }
  }
  std::array<int, 5> used{};
  context_.read(used_, used.data(), sizeof(used));
  bool fits = true;
  for (std::size_t p = 0; p < std::size(pools); ++p) {
    if (used[p] >= 0 && used[p] <= capacity(*pools[p])) continue;
    fits = false;
    grow(*pools[p]);
  }
  // Lists of a GPU's form leave no places between them.
  links_ = static_cast<std::size_t>(gpu_ ? used[0] : used[3]);
  near_pairs_ = static_cast<std::size_t>(gpu_ ? used[1] : used[4]);
  return fits;
}

/// Makes room in a pool of links for more than the last ones needed.
void Hierarchy::grow(device::Buffer& pool) {
  const std::size_t bytes = 2 * pool.bytes();
  if (bytes > most_pool_bytes) {
    throw InputError("the hierarchy of " + std::to_string(tree_.triangles()) +
                     " triangles needs more than " + std::to_string(most_pool_bytes / sizeof(int)) +
                     " links for this tolerance; raise the tolerance or simplify the mesh");
  }
  pool = {};
  pool = context_.allocate(bytes);
}

Links Hierarchy::links_made() const {
  if (kept_) return *kept_;
  Links links;
  // Lists of the pool follow each other in the order of their owners.
  const auto download = [&](const device::Buffer& ranges, std::size_t owners,
                            const device::Buffer& pool, std::vector<LinkRange>& of,
                            std::vector<int>& list) {
    of.resize(owners);
    context_.read(ranges, of.data(), owners * sizeof(LinkRange));
    context_.look(pool, pool.bytes(), [&](const void* places) {
      const int* const all = static_cast<const int*>(places);
      for (LinkRange& range : of) {
        const int first = static_cast<int>(list.size());
        list.insert(list.end(), all + range.first, all + range.first + range.count);
        range.first = first;
      }
    });
  };
  const std::size_t leaves = tree_.clusters() - tree_.first_leaf();
  download(cluster_range_, tree_.clusters(), emitter_, links.of_cluster, links.emitter);
  download(leaf_range_, leaves, near_, links.of_leaf, links.near);
  put_in_order(links, tree_);
  return links;
}

std::vector<Eigen::Array4f> Hierarchy::clusters() const {
  std::vector<Eigen::Array4f> clusters(tree_.clusters());
  context_.read(cluster_, clusters.data(), clusters.size() * sizeof(Eigen::Array4f));
  return clusters;
}

void Hierarchy::upload_links() {
  upload(context_, kept_->of_cluster, cluster_range_);
  upload(context_, kept_->emitter, emitter_);
  upload(context_, kept_->of_leaf, leaf_range_);
  upload(context_, kept_->near, near_);
  links_ = kept_->emitter.size();
  near_pairs_ = kept_->near.size();
}

void Hierarchy::set_opening(float opening) {
  options_.opening = opening;
  relink();
}

void Hierarchy::update(std::span<const Profile> profiles) {
  set_profiles(profiles);
  if (!kept_) kept_ = links_made();
  tree_.set_clusters(clusters());
  const LinkChanges changes =
      dipole::update(*kept_, tree_, oracle(options_.slack * options_.opening),
                     oracle(options_.opening), options_.most_changes);
  if (changes.too_many) {
    relink();
  } else if (changes.demoted + changes.promoted > 0) {
    upload_links();
  }
  changes_ = changes;
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
  const int depth = tree_.depth(), levels = std::min(subtree_, depth);
  const int roots = 1 << (depth - levels);
  context_.write(irradiance_, irradiance.data(), irradiance.size_bytes());
  const device::Range subtrees = items(static_cast<std::size_t>(roots), 1);
  context_.launch(*program_, "pull_subtrees", subtrees, roots, levels, first_, order_, irradiance_,
                  point_, spread_, cluster_, power_, moments_);
  const auto of_level = [&](int width) {
    return items(static_cast<std::size_t>(width), cpu_group);
  };
  for (int width = roots / 2; width > 0; width /= 2) {
    context_.launch(*program_, "pull", of_level(width), width, cluster_, moments_);
  }
  for (int width = 1; width <= roots; width *= 2) {
    context_.launch(*program_, gpu_ ? "push_together" : "push",
                    gpu_ ? groups(width) : of_level(width), width, table_.smooth2, profile_table_,
                    cluster_range_, emitter_, cluster_, moments_, series_);
  }
  const float of_triangles = triangle_share * options_.opening;
  if (gpu_) {
    context_.launch(*program_, "evaluate_together", groups(roots), roots, table_.smooth2,
                    table_.smooth, of_triangles, table_.decay, profile_table_, first_, leaf_range_,
                    near_, order_, point_, spread_, corner_, cluster_, power_, series_, exitance_);
  } else {
    context_.launch(*program_, "evaluate_subtrees", subtrees, roots, levels, table_.smooth2,
                    table_.smooth, of_triangles, table_.decay, profile_table_, first_,
                    cluster_range_, emitter_, leaf_range_, near_, order_, point_, spread_, corner_,
                    cluster_, power_, moments_, series_, exitance_);
  }
  std::vector<Eigen::Array4f> result(irradiance.size());
  context_.read(exitance_, result.data(), result.size() * sizeof(Eigen::Array4f));
  return result;
}

}  // namespace kappamu::forward::dipole

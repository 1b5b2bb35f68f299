// Volumes from OpenVDB files.
#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <set>

#include "core/error.h"
#include "core/file_name.h"
#include "io/text_stream.h"
#include "io/volume/vdb_content.h"
#include "io/volume/volume_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

constexpr double tolerance = 1e-6;  // of a voxel: transforms may come from 32-bit floats

/// The grids of one file by name, and reading them as volumes.
class VdbReader {
 public:
  explicit VdbReader(const fs::path& file) : file_(file) {
    try {
      const VdbContent content = read_vdb_content(file);
      metadata_ = content.metadata;
      for (const auto& grid : content.grids) {
        const std::string name = grid->getName();
        if (!grids_.emplace(name, grid).second && is_read(name)) {
          throw InputError(file_.string() + ": has two grids named " + name +
                           "; leave one of them out");
        }
      }
    } catch (const InputError&) {
      throw;
    } catch (const std::exception&) {
      fail("not a complete OpenVDB file; write or copy it again");
    }
  }

  VolumeSet read(std::size_t most_voxels) {
    VolumeSet set;
    find_channels(set);
    find_shape(kappa_name(set.channels.front()));
    for (const std::string& channel : set.channels) check_filled(kappa_name(channel));
    check_voxels(file_, shape_, volumes(), most_voxels);
    for (const std::string& channel : set.channels) {
      set.media.push_back({volume(kappa_name(channel)), volume(mu_name(channel))});
    }
    read_extra(set, "std_kappa_", set.kappa_std);
    read_extra(set, "std_mu_", set.mu_std);
    read_extra(set, "resolution_kappa_", set.kappa_resolution);
    read_extra(set, "resolution_mu_", set.mu_resolution);
    read_extra(set, "sensitivity_", set.sensitivity);
    if (auto eta = metadata_->getMetadata<openvdb::DoubleMetadata>(eta_name)) {
      set.eta = eta->value();
    }
    const std::string prefix = provenance_prefix;
    for (auto it = metadata_->beginMeta(); it != metadata_->endMeta(); ++it) {
      if (it->first.starts_with(prefix)) {
        set.metadata[it->first.substr(prefix.size())] = it->second->str();
      }
    }
    validate(set, file_.string());
    return set;
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    throw InputError(file_.string() + ": " + why);
  }
  std::string kappa_name(const std::string& channel) const {
    return plain_names_ ? "kappa" : "kappa_" + channel;
  }
  std::string mu_name(const std::string& channel) const {
    return plain_names_ ? "mu" : "mu_" + channel;
  }

  /// In the order the file's metadata give, if it gives one; else R, G, B first, then by name.
  void find_channels(VolumeSet& set) {
    std::set<std::string> found;
    for (const auto& [name, grid] : grids_) {
      if (name.starts_with("kappa_")) found.insert(name.substr(6));
    }
    if (!found.empty() && grids_.contains("kappa")) {
      fail("has grids kappa and kappa_" + *found.begin() + "; leave one of them out");
    }
    plain_names_ = grids_.contains("kappa");
    if (plain_names_) found.insert("grey");
    if (found.empty()) fail("has no float grid named kappa or kappa_<channel>" + its_grids());
    for (const auto& [name, grid] : grids_) {
      if (plain_names_ || !name.starts_with("mu_") || found.contains(name.substr(3))) continue;
      fail("has grid " + shown_name(name) + " but no float grid " +
           shown_name(kappa_name(name.substr(3))));
    }
    std::vector<std::string> order{"R", "G", "B"};
    if (auto text = metadata_->getMetadata<openvdb::StringMetadata>("channels")) {
      std::istringstream words = text_reader(text->value());
      order.assign(std::istream_iterator<std::string>(words), {});
    }
    for (const std::string& name : order) {
      if (found.erase(name) != 0) set.channels.push_back(name);
    }
    set.channels.insert(set.channels.end(), found.begin(), found.end());
    for (const std::string& channel : set.channels) {
      require_plain_name(channel, file_.string() + ": the channel of a grid kappa_<channel>");
      if (!grids_.contains(mu_name(channel))) {
        fail("has grid " + kappa_name(channel) + " but no float grid " + mu_name(channel));
      }
    }
  }

  std::string its_grids() const {
    constexpr std::size_t most = 10;
    std::string list;
    std::size_t count = 0;
    for (const auto& [name, grid] : grids_) {
      if (++count > most) return list + ", ...";
      list += (list.empty() ? "; its grids are " : ", ") + shown_name(name);
    }
    return list;
  }

  /// Of floats or doubles.
  const openvdb::GridBase& numbers(const std::string& name) const {
    const openvdb::GridBase& grid = *grids_.at(name);
    if (grid.getGridClass() == openvdb::GRID_LEVEL_SET) {
      fail("grid " + name + " is a level set, of distances; give a fog volume");
    }
    if (!grid.isType<openvdb::FloatGrid>() && !grid.isType<openvdb::DoubleGrid>()) {
      fail("grid " + name + " is of type " + grid.valueType() + "; write it as a float grid");
    }
    return grid;
  }

  /// Which axis of the index each axis of the world is, and whether they run against each other;
  /// returns the voxel's edge.
  double find_axes(const std::string& name) {
    const openvdb::math::Transform& transform = first_->transform();
    const double edge = transform.voxelSize()[0];
    bool good = transform.isLinear() && edge > 0.0 && std::isfinite(edge);
    std::set<int> found;
    for (int along = 0; along < 3 && good; ++along) {
      openvdb::Vec3d unit(0.0);
      unit[along] = 1.0;
      const openvdb::Vec3d step = transform.baseMap()->applyJacobian(unit);
      int axis = 0;
      for (int a = 1; a < 3; ++a) axis = std::abs(step[a]) > std::abs(step[axis]) ? a : axis;
      openvdb::Vec3d straight(0.0);
      straight[axis] = step[axis] > 0.0 ? edge : -edge;
      good = (step - straight).length() <= tolerance * edge && found.insert(axis).second;
      index_axis_[static_cast<std::size_t>(axis)] = along;
      backwards_[static_cast<std::size_t>(axis)] = step[axis] < 0.0;
    }
    if (!good) {
      fail("grid " + name +
           " must have cubic voxels along the world axes; its transform turns, stretches or bends "
           "them otherwise");
    }
    return edge;
  }

  /// Of a voxel of the set, counted along the world's axes.
  openvdb::Coord index_of(const std::array<int, 3>& voxel) const {
    openvdb::Coord index;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int along = index_axis_[axis];
      index[along] =
          backwards_[axis] ? box_.max()[along] - voxel[axis] : box_.min()[along] + voxel[axis];
    }
    return index;
  }

  void find_shape(const std::string& name) {
    first_ = &numbers(name);
    const double edge = find_axes(name);
    box_ = first_->evalActiveVoxelBoundingBox();
    if (box_.empty()) fail("grid " + name + " has no active voxels");
    for (int axis = 0; axis < 3; ++axis) {
      constexpr std::int64_t largest_extent = 1 << 16;
      if (std::int64_t{box_.max()[axis]} - box_.min()[axis] >= largest_extent) {
        fail("grid " + name + " does not fill its box, which is longer than 65536 voxels");
      }
    }
    const openvdb::Coord cells = box_.dim();
    shape_ = {cells[index_axis_[0]], cells[index_axis_[1]], cells[index_axis_[2]], edge};
    if (auto exact = metadata_->getMetadata<openvdb::DoubleMetadata>("voxel_mm")) {
      if (std::abs(exact->value() - edge) <= tolerance * edge) {
        shape_.voxel_mm = exact->value();
      }
    }
  }

  static bool is_read(const std::string& name) {
    constexpr std::array beginnings{"kappa_", "mu_", "std_", "resolution_", "sensitivity_"};
    return name == "kappa" || name == "mu" ||
           std::any_of(beginnings.begin(), beginnings.end(),
                       [&](const char* beginning) { return name.starts_with(beginning); });
  }
  /// How many of the file's grids become volumes.
  std::size_t volumes() const {
    return static_cast<std::size_t>(std::count_if(
        grids_.begin(), grids_.end(), [](const auto& grid) { return is_read(grid.first); }));
  }

  /// Counted from the tree, where a few tiles stand for any number of voxels: a stray active voxel
  /// far away makes the box large, not the count.
  void check_filled(const std::string& name) const {
    const openvdb::Index64 active = numbers(name).activeVoxelCount();
    if (active == shape_.cells()) return;
    fail("grid " + name + " does not fill its box: " + std::to_string(active) + " of " +
         std::to_string(shape_.cells()) + " voxels are active; give each voxel a value");
  }

  Volume<double> volume(const std::string& name) const {
    const openvdb::GridBase& grid = numbers(name);
    if (grid.transform() != first_->transform()) {
      fail("grid " + name + " has another transform than " + first_->getName());
    }
    const openvdb::CoordBBox active = grid.evalActiveVoxelBoundingBox();
    if (!active.empty() && !box_.isInside(active)) {
      fail("grid " + name + " reaches beyond " + first_->getName());
    }
    if (grid.isType<openvdb::FloatGrid>()) {
      return values(static_cast<const openvdb::FloatGrid&>(grid));
    }
    return values(static_cast<const openvdb::DoubleGrid&>(grid));
  }

  template <class Grid>
  Volume<double> values(const Grid& grid) const {
    Volume<double> result(shape_);
    const auto accessor = grid.getConstAccessor();
    for (int z = 0; z < shape_.nz; ++z) {
      for (int y = 0; y < shape_.ny; ++y) {
        for (int x = 0; x < shape_.nx; ++x) {
          result(x, y, z) = accessor.getValue(index_of({x, y, z}));
        }
      }
    }
    return result;
  }

  void read_extra(const VolumeSet& set, const std::string& prefix,
                  std::vector<Volume<double>>& volumes) const {
    for (const std::string& channel : set.channels) {
      if (grids_.contains(prefix + channel)) volumes.push_back(volume(prefix + channel));
    }
  }

  fs::path file_;
  openvdb::MetaMap::Ptr metadata_;
  std::map<std::string, openvdb::GridBase::Ptr> grids_;
  bool plain_names_ = false;
  const openvdb::GridBase* first_;   ///< its box and transform are the set's
  openvdb::CoordBBox box_;           ///< of its indices
  std::array<int, 3> index_axis_{};  ///< of each axis of the world
  std::array<bool, 3> backwards_{};
  GridShape shape_;
};

}  // namespace

VolumeSet read_vdb(const fs::path& file, std::size_t most_voxels) {
  start_openvdb();
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    throw InputError("cannot read " + file.string() + ": there is no such file");
  }
  return VdbReader(file).read(most_voxels);
}

}  // namespace kappamu::io

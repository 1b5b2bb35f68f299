#include "render/edit/voxel_edit.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>

#include "core/error.h"
#include "core/optics.h"
#include "io/volume/volume_file.h"
#include "render/edit/selection.h"
#include "render/material/published_materials.h"

namespace kappamu::render {

namespace {

/// Relative refractive index of a volume that states none.
constexpr double usual_eta = 1.3;

VoxelValue value_of(const io::VolumeSet& set, std::size_t channel, std::size_t voxel) {
  return {set.media[channel].kappa[voxel], set.media[channel].mu[voxel],
          set.kappa_std.empty() ? 0.0 : set.kappa_std[channel][voxel],
          set.mu_std.empty() ? 0.0 : set.mu_std[channel][voxel]};
}

/// The channels that `edit` is for, by their place in the set, in the edit's own order.
std::vector<std::size_t> channels_of(const Edit& edit, const io::VolumeSet& set) {
  std::vector<std::size_t> places;
  for (const std::string& name : edit.channels.empty() ? set.channels : edit.channels) {
    const auto found = std::find(set.channels.begin(), set.channels.end(), name);
    if (found != set.channels.end()) {
      const auto place = static_cast<std::size_t>(found - set.channels.begin());
      if (std::count(places.begin(), places.end(), place) == 0) places.push_back(place);
      continue;
    }
    std::string all;
    for (const std::string& channel : set.channels) all += (all.empty() ? "" : ", ") + channel;
    throw InputError("the volume has no channel " + name +
                     ", which an edit names; its channels: " + all);
  }
  return places;
}

/// A coefficient and its deviation.
struct Quantity {
  double value = 0.0, deviation = 0.0;
};

/// f of edit.h.
Quantity operated(const Edit& edit, double a, const Quantity& v) {
  switch (edit.operation) {
    case Operation::multiply:
      return {a * v.value, a * v.deviation};
    case Operation::add:
      return {v.value + a, v.deviation};
    case Operation::set:
      return {a, 0.0};
    case Operation::blend:
      return {(1.0 - edit.share) * v.value + edit.share * a, (1.0 - edit.share) * v.deviation};
    case Operation::copy:
    case Operation::surface:
    case Operation::deform:
    case Operation::fur:
      break;
  }
  return v;
}

/// The amounts of an edit, by the place of the channel in channels_of().
double one_of(const Amount& amount, std::size_t place) {
  return amount.size() == 1 ? amount[0] : amount[place];
}

void expect_one_each(const Edit& edit, std::size_t channels) {
  for (const Amount* amount : {&edit.kappa, &edit.mu, &edit.albedo, &edit.mean_free_path_mm}) {
    if (amount->size() <= 1 || amount->size() == channels) continue;
    throw InputError("an edit states " + std::to_string(amount->size()) + " numbers for " +
                     std::to_string(channels) + " channels; write one for all or one for each");
  }
}

/// `edit` with κ and μ of the material that it names, of channels that are named R, G, B.
Edit resolved(Edit edit, const std::vector<std::string>& channels) {
  if (edit.published.empty()) return edit;
  const HomogeneousMaterial material = published_material(edit.published);
  for (const std::string& channel : channels) {
    const std::size_t place = std::string("RGB").find(channel);
    if (channel.size() != 1 || place == std::string::npos) {
      throw InputError("an edit names the material " + edit.published +
                       ", whose channels are R, G and B; the volume has a channel " + channel);
    }
    edit.kappa.push_back(material.kappa_mm[static_cast<Eigen::Index>(place)]);
    edit.mu.push_back(material.mu_per_mm[static_cast<Eigen::Index>(place)]);
  }
  return edit;
}

class Editing {
 public:
  Editing(const Edit& edit, const io::VolumeSet& set, const EditedBody* body)
      : edit_(edit), set_(set), body_(body) {
    if (edit.of_object() && body == nullptr) select(edit.where, set.shape());  // says why not
    for (const std::size_t c : channels_of(edit_, set_)) {
      places_.push_back(c);
      names_.push_back(set.channels[c]);
    }
    edit_ = resolved(edit_, names_);
    expect_one_each(edit_, places_.size());
    if (!edit.albedo.empty() || !edit.mean_free_path_mm.empty()) {
      robin_A_ = boundary_constants(set.eta.value_or(usual_eta)).A;
    }
    if (edit.operation == Operation::copy) prepare_copy();
  }

  VoxelDifference difference() {
    VoxelDifference result;
    result.channels.resize(set_.channels.size());
    if (!edit_.of_medium()) return result;
    const std::vector<SelectedVoxel> selected = select(edit_.where, set_.shape(), body_);
    for (std::size_t place = 0; place < places_.size(); ++place) {
      const std::size_t c = places_[place];
      for (const SelectedVoxel& voxel : selected) {
        const VoxelValue before = value_of(set_, c, voxel.voxel);
        const VoxelValue after = changed(place, voxel, before);
        if (after.kappa == before.kappa && after.mu == before.mu) continue;
        result.channels[c].push_back({voxel.voxel, before, after});
      }
    }
    result.held = held_;
    return result;
  }

 private:
  void prepare_copy() {
    if (!edit_.volume.empty()) other_ = io::read_volume(io::find_volume(edit_.volume));
    for (const std::string& name : names_) {
      const io::VolumeSet& from = other_ ? *other_ : set_;
      const auto found = std::find(from.channels.begin(), from.channels.end(), name);
      if (found == from.channels.end()) {
        throw InputError(edit_.volume.string() + ": has no channel " + name +
                         ", which an edit copies from it");
      }
      from_.push_back(static_cast<std::size_t>(found - from.channels.begin()));
    }
  }

  VoxelValue changed(std::size_t place, const SelectedVoxel& at, const VoxelValue& before) {
    if (!edit_.albedo.empty() || !edit_.mean_free_path_mm.empty()) {
      return changed_terms(place, at.weight, before);
    }
    const Quantity kappa{before.kappa, before.kappa_std}, mu{before.mu, before.mu_std};
    Quantity new_kappa = kappa, new_mu = mu;
    if (edit_.operation == Operation::copy) {
      const std::optional<std::size_t> from = source(at.voxel);
      if (!from) return before;
      const VoxelValue other = value_of(other_ ? *other_ : set_, from_[place], *from);
      new_kappa = {other.kappa, other.kappa_std};
      new_mu = {other.mu, other.mu_std};
    } else {
      if (!edit_.kappa.empty()) new_kappa = operated(edit_, one_of(edit_.kappa, place), kappa);
      if (!edit_.mu.empty()) new_mu = operated(edit_, one_of(edit_.mu, place), mu);
    }
    new_kappa = mixed(kappa, new_kappa, at.weight);
    new_mu = mixed(mu, new_mu, at.weight);
    return held(new_kappa, new_mu);
  }

  /// In an artist's terms; each term's deviation is its ratio to the value.
  VoxelValue changed_terms(std::size_t place, double weight, const VoxelValue& before) {
    const ArtistTerms terms = artist_terms(before.kappa, before.mu, robin_A_);
    const auto ratio = [](double deviation, double value) {
      return value > 0.0 ? deviation / value : 0.0;
    };
    Quantity albedo{terms.albedo, ratio(before.mu_std, before.mu)};
    Quantity path{terms.mean_free_path_mm, ratio(before.kappa_std, before.kappa)};
    const auto operate = [&](const Amount& amount, Quantity& v) {
      if (amount.empty()) return;
      Quantity after = operated(edit_, one_of(amount, place), v);
      if (edit_.operation == Operation::multiply) after.deviation = v.deviation;
      v = mixed(v, after, weight);
    };
    operate(edit_.albedo, albedo);
    operate(edit_.mean_free_path_mm, path);
    const auto bounded = [&](double value, double smallest, double largest) {
      if (value < smallest || value > largest) ++held_;
      return std::clamp(value, smallest, largest);
    };
    const DiffusionTerms after =
        diffusion_terms({bounded(albedo.value, smallest_albedo, 1.0),
                         bounded(path.value, 3.0 * smallest_kappa_mm, 3.0 * largest_kappa_mm)},
                        robin_A_);
    return held({after.kappa_mm, path.deviation * after.kappa_mm},
                {after.mu_per_mm, albedo.deviation * after.mu_per_mm});
  }

  static Quantity mixed(const Quantity& before, const Quantity& after, double weight) {
    return {(1.0 - weight) * before.value + weight * after.value,
            (1.0 - weight) * before.deviation + weight * after.deviation};
  }

  VoxelValue held(const Quantity& kappa, const Quantity& mu) {
    const auto within = [&](double value, double smallest, double largest) {
      if (value < smallest || value > largest) ++held_;
      return std::clamp(value, smallest, largest);
    };
    return {within(kappa.value, smallest_kappa_mm, largest_kappa_mm),
            within(mu.value, 0.0, largest_mu_per_mm), kappa.deviation, mu.deviation};
  }

  /// Where a voxel's copy comes from, to the nearest voxel; nothing beyond the volume.
  std::optional<std::size_t> source(std::size_t voxel) const {
    const GridShape& s = set_.shape();
    const auto nx = static_cast<std::size_t>(s.nx), ny = static_cast<std::size_t>(s.ny);
    const Eigen::Vector3d centre =
        s.voxel_mm * Eigen::Vector3d(static_cast<double>(voxel % nx) + 0.5,
                                     static_cast<double>(voxel / nx % ny) + 0.5,
                                     static_cast<double>(voxel / (nx * ny)) + 0.5);
    std::optional<Eigen::Vector3d> from = centre + edit_.offset_mm;
    if (edit_.of_object()) {
      const Eigen::Vector3d in_object = body_->object_from_volume() * centre + edit_.offset_mm;
      from = other_ ? in_object : body_->in_volume(in_object);
    }
    if (!from) return std::nullopt;
    const GridShape& of = other_ ? other_->shape() : s;
    // Offsets of whole voxels may end a rounding short of one.
    const Eigen::Array3d at = (from->array() / of.voxel_mm + 1e-9).floor();
    if ((at < 0.0).any() || at.x() >= of.nx || at.y() >= of.ny || at.z() >= of.nz) {
      return std::nullopt;
    }
    return of.index(static_cast<int>(at.x()), static_cast<int>(at.y()), static_cast<int>(at.z()));
  }

  Edit edit_;
  const io::VolumeSet& set_;
  const EditedBody* body_;
  std::vector<std::size_t> places_;  ///< of the edit's channels, in the set
  std::vector<std::string> names_;   ///< of the edit's channels
  double robin_A_ = 1.0;
  std::optional<io::VolumeSet> other_;  ///< that is copied from
  std::vector<std::size_t> from_;       ///< of the edit's channels, in that
  std::size_t held_ = 0;
};

}  // namespace

std::size_t VoxelDifference::voxels() const {
  std::vector<std::uint32_t> all, here, joined;  // in order, as select() has them
  for (const auto& channel : channels) {
    here.clear();
    for (const Change& change : channel) here.push_back(change.voxel);
    joined.clear();
    std::set_union(all.begin(), all.end(), here.begin(), here.end(), std::back_inserter(joined));
    all.swap(joined);
  }
  return all.size();
}

VoxelDifference difference_of(const Edit& edit, const io::VolumeSet& set, const EditedBody* body) {
  return Editing(edit, set, body).difference();
}

}  // namespace kappamu::render

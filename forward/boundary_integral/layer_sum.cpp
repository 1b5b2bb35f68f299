#include "forward/boundary_integral/layer_sum.h"

#include "core/numbers/median.h"
#include "forward/boundary_integral/panels/panel_potentials.h"
#include "forward/boundary_integral/summation/equivalent_surface.h"

namespace kappamu::forward::boundary_integral {

namespace {

/// A box may hold this many times leaf_panels where its panels are alike; where some are this many
/// times larger than the median, they are what keeps it from being split.
constexpr int crowd = 2;
constexpr double large = 2.0;

std::vector<Eigen::Vector3d> centres(const std::vector<Panel>& panels) {
  std::vector<Eigen::Vector3d> result;
  for (const Panel& panel : panels) result.push_back(panel.centre);
  return result;
}

}  // namespace

std::vector<Panel> fitted_to_boxes(std::vector<Panel> panels) {
  for (bool changed = true; changed;) {
    std::vector<Place> places;
    for (const Panel& panel : panels) places.push_back({panel.centre, rule_reach * panel.radius});
    const Octree tree = make_octree(places, {}, leaf_panels);
    std::vector<bool> parted(panels.size(), false);
    for (const Box& box : tree.boxes) {
      if (!box.leaf() || box.sources() <= crowd * leaf_panels) continue;
      std::vector<double> radii;
      for (int k = box.first_source; k < box.end_source; ++k) {
        radii.push_back(
            panels[static_cast<std::size_t>(tree.source[static_cast<std::size_t>(k)])].radius);
      }
      const double limit = large * upper_median(radii);
      for (int k = box.first_source; k < box.end_source; ++k) {
        const int panel = tree.source[static_cast<std::size_t>(k)];
        if (panels[static_cast<std::size_t>(panel)].radius > limit)
          parted[static_cast<std::size_t>(panel)] = true;
      }
    }
    changed = false;
    std::vector<Panel> result;
    for (std::size_t k = 0; k < panels.size(); ++k) {
      if (!parted[k]) {
        result.push_back(panels[k]);
        continue;
      }
      const auto parts = split(panels[k]);
      result.insert(result.end(), parts.begin(), parts.end());
      changed = true;
    }
    panels = std::move(result);
  }
  return panels;
}

FastSum layer_sum(const std::vector<Panel>& panels, const Layers& layers) {
  SumSources sources;
  SumElements targets;
  sources.points = 3;
  sources.centre = targets.centre = targets.at = centres(panels);
  for (const Panel& panel : panels) {
    for (const Eigen::Vector3d& point : rule_points(panel)) {
      sources.at.push_back(point);
      sources.charge.push_back(layers.single_layer * panel.area / 3.0);
      if (layers.double_layer != 0.0) {
        sources.dipole.push_back(layers.double_layer * panel.area / 3.0 * panel.normal);
      }
    }
  }
  const auto near = [&panels, layers](int target, int source) -> std::optional<double> {
    const Panel& panel = panels[static_cast<std::size_t>(source)];
    const Eigen::Vector3d& x = panels[static_cast<std::size_t>(target)].centre;
    const double reach = near_radii * panel.radius;
    if ((x - panel.centre).squaredNorm() > reach * reach) return std::nullopt;
    const PanelPotentials exact = panel_potentials(panel, x, layers.decay);
    return layers.single_layer * exact.single_layer +
           (target == source ? 0.0 : layers.double_layer * exact.double_layer);
  };
  return FastSum(std::move(sources), std::move(targets), near,
                 {layers.decay, layers.order, leaf_panels, FastSum::Keep::matrices});
}

}  // namespace kappamu::forward::boundary_integral

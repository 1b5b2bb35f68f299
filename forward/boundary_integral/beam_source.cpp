#include "forward/boundary_integral/beam_source.h"

#include <algorithm>
#include <cmath>

#include "forward/boundary_integral/layer_sum.h"
#include "forward/boundary_integral/panels/panel_potentials.h"
#include "forward/light/beam_path.h"

namespace kappamu::forward::boundary_integral {

namespace {

/// Gauss points on [0, 1].
constexpr std::array<double, 4> node{0.0694318442029737, 0.3300094782075719, 0.6699905217924281,
                                     0.9305681557970263};
constexpr std::array<double, 4> weight{0.1739274225687269, 0.3260725774312731, 0.3260725774312731,
                                       0.1739274225687269};
/// The first interval, of the smallest panel's radius on the triangle that the beam meets.
constexpr double first_interval = 0.5;
/// Optical depth beyond which the light left (1e-6) needs no fine intervals.
constexpr double deep = 14.0;
/// Of a beam, what is followed no further.
constexpr double negligible = 1e-8;

/// Ends of intervals that double from `first` at 0 to the middle, and halve to `last` at the end.
std::vector<double> graded(double length, double first, double last) {
  std::vector<double> rising{0.0}, falling{length};
  for (double t = first; t < 0.5 * length; t *= 2.0) rising.push_back(t);
  for (double t = last; t < 0.5 * length; t *= 2.0) falling.push_back(length - t);
  rising.insert(rising.end(), falling.rbegin(), falling.rend());
  return rising;
}

/// Points along a chord; takes what collides from `left`. `first` and `last`: its intervals at the
/// ends.
void add_chord(const Chord& chord, double first, double last, double sigma_t, double albedo,
               double& left, BeamSource& source) {
  const double entering = left;
  if (sigma_t * chord.length > deep) last = chord.length;
  const std::vector<double> ends = graded(chord.length, first, last);
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
    const double collide = -std::expm1(-sigma_t * (ends[k + 1] - ends[k]));
    const double share = entering * std::exp(-sigma_t * ends[k]) * collide;
    source.powers.scattered += albedo * share;
    source.powers.absorbed += (1.0 - albedo) * share;
    left -= share;
    for (std::size_t g = 0; g < node.size(); ++g) {
      const double t = ends[k] - std::log1p(-node[g] * collide) / sigma_t;
      source.at.push_back(chord.from + t * chord.direction);
      source.power.push_back(albedo * share * weight[g]);
    }
    if (sigma_t * ends[k] > deep) break;
  }
}

}  // namespace

BeamSource beam_source(const ObjectProblem& problem, const std::vector<Beam>& beams,
                       const std::vector<Panel>& panels) {
  const Coefficients medium = problem.medium.smallest();
  const double sigma_t = 1.0 / (3.0 * medium.kappa);
  const double albedo = 1.0 - std::min(1.0, medium.mu / sigma_t);
  std::vector<double> radius(problem.mesh.triangles.size(), 1e300);
  for (const Panel& panel : panels) {
    double& r = radius[static_cast<std::size_t>(panel.sample)];
    r = std::min(r, panel.radius);
  }
  const MeshWalls walls(problem);
  BeamSource source;
  for (const Beam& beam : beams) {
    BeamPath path(walls, beam);
    double left = beam.power * path.transmitted();
    const double least = negligible * left;
    source.powers.entering += left;
    double first = first_interval * radius[static_cast<std::size_t>(beam.triangle)];
    for (std::size_t k = 0; left > least; ++k) {
      const Chord* chord = path.chord(k, walls);
      if (chord == nullptr) break;
      const double end = first_interval * radius[static_cast<std::size_t>(chord->meets)];
      add_chord(*chord, first, end, sigma_t, albedo, left, source);
      const double leaves = chord->leaves * left;
      source.powers.unscattered += leaves;
      left -= leaves;
      first = end;
    }
    source.powers.unscattered += left;
  }
  return source;
}

Eigen::VectorXd beam_potentials(const BeamSource& source, const std::vector<Panel>& panels,
                                const Coefficients& medium, int order) {
  if (source.at.empty()) return Eigen::VectorXd::Zero(static_cast<Eigen::Index>(panels.size()));
  const double decay = std::sqrt(medium.mu / medium.kappa);
  SumSources points;
  points.centre = points.at = source.at;
  points.charge.assign(source.at.size(), 1.0);
  SumElements targets;
  for (const Panel& panel : panels) targets.centre.push_back(panel.centre);
  targets.at = targets.centre;
  const auto near = [&](int target, int point) -> std::optional<double> {
    const Panel& panel = panels[static_cast<std::size_t>(target)];
    const Eigen::Vector3d& y = source.at[static_cast<std::size_t>(point)];
    const double reach = near_radii * panel.radius;
    if ((y - panel.centre).squaredNorm() > reach * reach) return std::nullopt;
    return panel_potentials(panel, y, decay).single_layer / panel.area;
  };
  const FastSum sum(std::move(points), std::move(targets), near,
                    {decay, order, leaf_panels, FastSum::Keep::nothing});
  return sum(Eigen::Map<const Eigen::VectorXd>(source.power.data(),
                                               static_cast<Eigen::Index>(source.power.size())) /
             medium.kappa);
}

}  // namespace kappamu::forward::boundary_integral

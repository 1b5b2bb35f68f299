#include "forward/polygrid/polygrid_diffusion.h"

#include <algorithm>
#include <cmath>

#include "forward/embedded/equations/row_ranges.h"
#include "forward/light_entry.h"
#include "forward/polygrid/beams.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Vector3d;

constexpr int most_points = 4;  ///< along an edge of a cell

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

std::vector<Coefficients> coefficients_of_cells(const Polygrid& grid, const ObjectMedium& medium) {
  if (medium.homogeneous()) {
    return std::vector<Coefficients>(grid.cell.size(), medium.at(Vector3d::Zero()));
  }
  std::vector<Coefficients> result(grid.cell.size());
  embedded::for_row_ranges(result.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const CellCorners at = corners_of(grid, k);
      Eigen::AlignedBox3d box;
      for (const Vector3d& corner : at) box.extend(corner);
      const double points = std::ceil(box.sizes().maxCoeff() / *medium.voxel_mm());
      const int n = static_cast<int>(std::clamp(points, 1.0, static_cast<double>(most_points)));
      Coefficients sum;
      for (int z = 0; z < n; ++z) {
        for (int y = 0; y < n; ++y) {
          for (int x = 0; x < n; ++x) {
            const std::array<double, 8> shape =
                shape_functions((Vector3d(x, y, z).array() + 0.5) / n);
            Vector3d p = Vector3d::Zero();
            for (std::size_t c = 0; c < 8; ++c) p += shape[c] * at[c];
            const Coefficients here = medium.at(p);
            sum.kappa += here.kappa;
            sum.mu += here.mu;
          }
        }
      }
      result[k] = {sum.kappa / (n * n * n), sum.mu / (n * n * n)};
    }
  });
  return result;
}

PolygridDiffusion::PolygridDiffusion(Polygrid grid, const TriangleMesh& mesh,
                                     const Surface& surface, double eta, const std::string& device)
    : grid_(std::move(grid)),
      constants_(boundary_constants(eta)),
      equations_(grid_, constants_.A),
      hierarchy_(equations_, grid_),
      map_(grid_, mesh, surface),
      solver_(make_linear_solver(equations_, hierarchy_, device)) {}

PolygridDiffusion::~PolygridDiffusion() = default;

void PolygridDiffusion::set_media(std::span<const ObjectMedium* const> media) {
  of_cell_.clear();
  absorption_.clear();
  std::vector<MediumValues> values;
  for (const ObjectMedium* medium : media) {
    of_cell_.push_back(coefficients_of_cells(grid_, *medium));
    absorption_.push_back(equations_.absorption(of_cell_.back()));
    values.push_back(equations_.values(of_cell_.back()));
  }
  solver_->set_media(values);
}

std::vector<double> PolygridDiffusion::load_of(const ObjectProblem& problem,
                                               const ObjectLight& light, std::size_t channel,
                                               double remainder, ObjectBalance& balance) const {
  std::vector<double> load(equations_.unknowns(), 0.0);
  add_beams(grid_, map_, problem, light, of_cell_[channel], remainder, load, balance);
  if (light.diffuse.empty()) return load;
  // E_t enters through q = 4 E_t/(1 − R_φ).
  const double transmitted = diffuse_transmittance(constants_);
  const double per_entering = 4.0 / (1.0 - constants_.r_phi) / (2.0 * constants_.A);
  const std::vector<double> incident = map_.loads(light.diffuse);
  for (std::size_t i = 0; i < load.size(); ++i) {
    load[i] += per_entering * transmitted * incident[i];
    balance.entering += transmitted * incident[i];
  }
  return load;
}

std::vector<PolygridAnswer> PolygridDiffusion::solve(std::span<const ObjectProblem> problems,
                                                     const PolygridAccuracy& accuracy) {
  std::vector<PolygridAnswer> answers(problems.size());
  std::vector<Load> loads;
  for (std::size_t c = 0; c < problems.size(); ++c) {
    answers[c].balance.resize(problems[c].lights.size());
    for (std::size_t l = 0; l < problems[c].lights.size(); ++l) {
      loads.push_back({c, load_of(problems[c], problems[c].lights[l], c, accuracy.beam_remainder,
                                  answers[c].balance[l])});
    }
  }
  report_ = solver_->solve(loads, fluence_, accuracy.linear_tolerance, accuracy.most_iterations);

  const double transmitted = diffuse_transmittance(constants_);
  const double per_fluence = 1.0 / (2.0 * constants_.A);
  const double per_entering = 1.0 - 4.0 / (1.0 - constants_.r_phi) * per_fluence;
  std::size_t at = 0;
  for (std::size_t c = 0; c < problems.size(); ++c) {
    for (std::size_t l = 0; l < problems[c].lights.size(); ++l, ++at) {
      const ObjectLight& light = problems[c].lights[l];
      ObjectBalance& balance = answers[c].balance[l];
      std::vector<double> exitance = map_.on_triangles(fluence_[at]);
      for (double& value : exitance) value *= per_fluence;
      balance.exiting = per_fluence * dot(equations_.boundary_share(), fluence_[at]);
      balance.absorbed += dot(absorption_[c], fluence_[at]);
      if (!light.diffuse.empty()) {
        for (std::size_t t = 0; t < exitance.size(); ++t) {
          exitance[t] += per_entering * transmitted * light.diffuse[t];
        }
        for (const double incident : map_.loads(light.diffuse)) {
          balance.exiting += per_entering * transmitted * incident;
        }
      }
      answers[c].exitance.insert(answers[c].exitance.end(), exitance.begin(), exitance.end());
    }
  }
  return answers;
}

}  // namespace kappamu::forward::polygrid

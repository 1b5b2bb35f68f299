#include "forward/embedded/embedded_operator.h"

#include <bit>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "core/processor_time.h"
#include "forward/embedded/equations/fields.h"
#include "forward/embedded/equations/levels.h"
#include "forward/embedded/solver_choice.h"
#include "forward/light_entry.h"

namespace kappamu::forward::embedded {

namespace {

/// Every leaf that the object has a part in is of this level.
Octree uniform_tree(const TriangleMesh& mesh, const RayCaster& rays, int level) {
  Octree tree(mesh);
  tree.refine_surface(level);
  for (;;) {
    std::vector<int> coarse;
    for (const int leaf : object_leaves(tree, mesh, rays)) {
      if (tree.cube(leaf).level < level) coarse.push_back(leaf);
    }
    if (coarse.empty()) return tree;
    tree.refine(coarse, std::vector<int>(coarse.size(), 1));
  }
}

struct NodeFields final : BatchField {
  explicit NodeFields(int patterns, std::size_t unknowns)
      : value(static_cast<std::size_t>(patterns), std::vector<double>(unknowns, 0.0)) {}
  int patterns() const override { return static_cast<int>(value.size()); }
  std::vector<std::vector<double>> value;  ///< [pattern][unknown]
};

const std::vector<std::vector<double>>& values(const BatchField& field) {
  return dynamic_cast<const NodeFields&>(field).value;
}
std::vector<std::vector<double>>& values(BatchField& field) {
  return dynamic_cast<NodeFields&>(field).value;
}

double product(const Element& element, const std::array<double, 8>& a,
               const std::array<double, 8>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t j = 0; j < 8; ++j) sum += element(i, j) * a[i] * b[j];
  }
  return sum;
}

class EmbeddedOperator final : public DiffusionOperator {
 public:
  EmbeddedOperator(const TriangleMesh& mesh, const RayCaster& rays, int level, double eta,
                   std::string device)
      : constants_(boundary_constants(eta)), device_(std::move(device)) {
    mesh_ = cut_mesh(uniform_tree(mesh, rays, level), mesh, rays);
    nodes_ = NodeSpace(mesh_.cubes);
    const GridShape shape = voxels_about(mesh, level);
    space_ = block_space(shape, Face::z_minus);
    space_.fraction.assign(shape.cells(), 0.0F);
    for (std::size_t k = 0; k < mesh_.cubes.size(); ++k) {
      const auto& at = mesh_.cubes[k].at;
      voxel_.push_back(
          shape.index(static_cast<int>(at[0]), static_cast<int>(at[1]), static_cast<int>(at[2])));
      space_.fraction[voxel_[k]] = static_cast<float>(mesh_.fraction(k));
    }
    area_.assign(mesh.triangles.size(), 0.0);
    for (const CutMesh::Piece& piece : mesh_.pieces) {
      for (const float weight : piece.weight) {
        area_[static_cast<std::size_t>(piece.triangle)] += static_cast<double>(weight);
      }
    }
  }

  const MediumSpace& space() const override { return space_; }
  std::size_t light_size() const override { return area_.size(); }
  std::size_t exitance_size() const override { return area_.size(); }
  std::string backend() const override { return "embedded, " + device_; }

  void set_medium(std::vector<double> kappa, std::vector<double> mu) override {
    solver_.reset();
    coefficients_.assign(1, {});
    for (const std::size_t i : voxel_) {
      if (!(kappa[i] > 0.0 && mu[i] >= 0.0)) {
        throw InputError("medium: kappa must be positive and mu not negative inside the object");
      }
      coefficients_[0].push_back({kappa[i], mu[i]});
    }
    levels_ = make_levels(mesh_.cubes, cube_elements(mesh_, coefficients_, constants_.A));
    solver_ = make_linear_solver(levels_, 8, device_);
  }
  std::unique_ptr<BatchField> make_field(int patterns) const override {
    return std::make_unique<NodeFields>(patterns, nodes_.unknowns());
  }

  void load(std::span<const double> light, BatchField& b) const override {
    add_loads(light, b, [&](std::size_t, double e) { return entering_flux() * e; });
  }
  void load_transpose(const BatchField& lambda, std::span<double> light) const override {
    for_means(lambda, [&](std::size_t at, std::size_t t, double mean) {
      light[at] = entering_flux() * area_[t] * mean;
    });
  }
  void exitance(const BatchField& phi, std::span<const double> light,
                std::span<double> out) const override {
    // M = (φ − q)/(2A) + E_t.
    const double reflected = diffuse_transmittance(constants_) - entering_flux();
    for_means(phi, [&](std::size_t at, std::size_t, double mean) {
      out[at] = mean / (2.0 * constants_.A) + reflected * light[at];
    });
  }
  void exitance_transpose(std::span<const double> weights, BatchField& b) const override {
    add_loads(weights, b, [&](std::size_t t, double w) {
      return area_[t] > 0.0 ? w / (2.0 * constants_.A * area_[t]) : 0.0;
    });
  }

  SolveReport solve(const BatchField& b, BatchField& phi,
                    const SolveOptions& options) const override;
  void add_gradient(const SolvedBatch& at, const BatchField& lambda,
                    std::span<const double> weights, CoefficientPair& gradient) const override;
  void linearise(const SolvedBatch& at, const CoefficientPair& direction, BatchField& b,
                 std::span<double> exitance_change) const override;

 private:
  /// What enters of an irradiance, as a load: q/(2A).
  double entering_flux() const {
    return diffuse_transmittance(constants_) * constants_.q_per_entering() / (2.0 * constants_.A);
  }
  /// `to` = ∫ flux(t, value) N dA of each pattern's values per triangle.
  template <class Flux>
  void add_loads(std::span<const double> per_triangle, BatchField& to, const Flux& flux) const {
    std::vector<double> fluxes(area_.size());
    for (std::size_t m = 0; m < values(to).size(); ++m) {
      for (std::size_t t = 0; t < fluxes.size(); ++t) {
        fluxes[t] = flux(t, per_triangle[m * fluxes.size() + t]);
      }
      values(to)[m].assign(nodes_.unknowns(), 0.0);
      add_surface_load(mesh_, nodes_, fluxes, values(to)[m]);
    }
  }
  /// use(place in an array [pattern][triangle], triangle, mean over it).
  template <class Use>
  void for_means(const BatchField& field, const Use& use) const {
    for (std::size_t m = 0; m < values(field).size(); ++m) {
      const std::vector<double> means =
          triangle_means(mesh_, nodes_, values(field)[m], area_.size());
      for (std::size_t t = 0; t < means.size(); ++t) use(m * means.size() + t, t, means[t]);
    }
  }
  ElementIntegrals integrals(std::size_t cube) const {
    const auto cut = static_cast<std::size_t>(mesh_.cut[cube]);
    return mesh_.cut[cube] < 0 ? whole_integrals()
                               : element_integrals(mesh_.volume[cut], mesh_.surface[cut]);
  }

  BoundaryConstants constants_;
  std::string device_;
  CutMesh mesh_;
  NodeSpace nodes_;
  MediumSpace space_;
  std::vector<std::size_t> voxel_;  ///< of each cube
  std::vector<double> area_;        ///< of each triangle [mm²]
  std::vector<std::vector<Coefficients>> coefficients_;
  Levels levels_;
  std::unique_ptr<LinearSolver> solver_;
};

SolveReport EmbeddedOperator::solve(const BatchField& b, BatchField& phi,
                                    const SolveOptions& options) const {
  check(solver_ != nullptr, "set_medium must come before the first use of the solver");
  const Stopwatch watch;
  std::vector<Load> loads;
  for (const std::vector<double>& power : values(b)) loads.push_back({0, power});
  const CgReport found =
      solver_->solve(loads, values(phi), {options.tolerance, options.max_iterations});
  SolveReport report;
  report.termination = found.converged ? Termination::converged : Termination::ran_out;
  report.iterations = found.iterations;
  report.residual = found.residual;
  report.seconds = watch.seconds();
  report.message =
      found.converged ? "the residual is within the tolerance" : "the iterations were used up";
  return report;
}

/// λᵀ(b − A φ) and its derivatives by κ h λᵀ S φ and μ h³ λᵀ M φ of each cube: light and exitance
/// have none.
void EmbeddedOperator::add_gradient(const SolvedBatch& at, const BatchField& lambda,
                                    std::span<const double> /*weights*/,
                                    CoefficientPair& gradient) const {
  for_rows(static_cast<int>(voxel_.size()), [&](int row) {
    const auto k = static_cast<std::size_t>(row);
    const ElementIntegrals element = integrals(k);
    double stiffness = 0.0, mass = 0.0;
    for (std::size_t m = 0; m < values(lambda).size(); ++m) {
      const auto a = corner_values(nodes_, k, values(lambda)[m]);
      const auto b = corner_values(nodes_, k, values(at.phi)[m]);
      stiffness += product(element.stiffness, a, b);
      mass += product(element.mass, a, b);
    }
    const double h = mesh_.h(k);
    gradient.log_kappa[voxel_[k]] -= coefficients_[0][k].kappa * h * stiffness;
    gradient.log_mu[voxel_[k]] -= coefficients_[0][k].mu * h * h * h * mass;
  });
}

void EmbeddedOperator::linearise(const SolvedBatch& at, const CoefficientPair& direction,
                                 BatchField& b, std::span<double> exitance_change) const {
  std::fill(exitance_change.begin(), exitance_change.end(), 0.0);
  for (std::vector<double>& load : values(b)) load.assign(nodes_.unknowns(), 0.0);
  for (std::size_t k = 0; k < voxel_.size(); ++k) {
    const ElementIntegrals element = integrals(k);
    const double h = mesh_.h(k);
    const double stiffness = coefficients_[0][k].kappa * h * direction.log_kappa[voxel_[k]];
    const double mass = coefficients_[0][k].mu * h * h * h * direction.log_mu[voxel_[k]];
    for (std::size_t m = 0; m < values(b).size(); ++m) {
      const auto phi = corner_values(nodes_, k, values(at.phi)[m]);
      std::array<double, 8> power{};
      for (std::size_t i = 0; i < 8; ++i) {
        for (std::size_t j = 0; j < 8; ++j) {
          power[i] -= (stiffness * element.stiffness(i, j) + mass * element.mass(i, j)) * phi[j];
        }
      }
      add_load(nodes_, k, power, values(b)[m]);
    }
  }
}

class ObjectOperators final : public OperatorFactory {
 public:
  ObjectOperators(TriangleMesh mesh, std::shared_ptr<const RayCaster> rays)
      : mesh_(std::move(mesh)), rays_(std::move(rays)) {}

  MadeOperator make(const GridSetup& setup, const SeenFaces& /*seen*/, const std::string& device,
                    Precision /*precision*/) const override {
    const auto n = static_cast<unsigned>(setup.shape.nx);
    const int level = std::bit_width(n) - 1;
    if (setup.shape.nx < 2 || !std::has_single_bit(n) ||
        !(setup.shape == voxels_about(mesh_, level))) {
      throw InputError("an object is fitted on the voxels of its root cube, 2^n along each edge");
    }
    if (setup.source != SourceModel::boundary || setup.convention != Convention::physical) {
      throw InputError(
          "an object is fitted under diffuse light in the physical convention: the load of a "
          "collimated beam has no derivative by kappa there");
    }
    return {std::make_unique<EmbeddedOperator>(mesh_, *rays_, level, setup.eta, device), ""};
  }
  std::size_t memory(const GridSetup& setup, int patterns, int fields, int at_once,
                     Precision /*precision*/) const override {
    // A cube with its share of the levels [bytes], measured, and fields of doubles.
    constexpr std::size_t per_cube = 2050;
    return setup.shape.cells() *
           (per_cube + sizeof(double) * static_cast<std::size_t>(patterns * fields + 4 * at_once));
  }

 private:
  TriangleMesh mesh_;
  std::shared_ptr<const RayCaster> rays_;
};

}  // namespace

std::shared_ptr<const OperatorFactory> object_operators(const TriangleMesh& mesh,
                                                        std::shared_ptr<const RayCaster> rays) {
  return std::make_shared<ObjectOperators>(mesh, std::move(rays));
}

GridShape voxels_about(const TriangleMesh& mesh, int level) {
  const int n = 1 << level;
  return {n, n, n, Octree(mesh).edge_mm() / n};
}

}  // namespace kappamu::forward::embedded

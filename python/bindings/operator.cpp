// The diffusion operator of a block for people who bring their own inverse: solutions, products,
// and the derivative of the exitance by κ, μ and light. The only file of the bindings that names
// the solver's interface (forward/grid).
#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

#include "core/numbers/coefficient_bounds.h"
#include "forward/grid/derivatives.h"
#include "forward/grid/grid_physics.h"
#include "forward/grid/grid_solver.h"
#include "inverse/fit/describe_options.h"
#include "python/bindings/bind.h"
#include "python/bindings/calls.h"

namespace kappamu::python {

namespace {

using Doubles = py::array_t<double>;
using Field = std::unique_ptr<forward::BatchField>;

/// Throws kappamu.NotConverged.
void require_converged(const forward::SolveReport& report) {
  if (report.termination == forward::Termination::converged) return;
  const py::gil_scoped_acquire acquire;
  const py::object type = py::module_::import("kappamu.errors").attr("NotConverged");
  PyErr_SetObject(type.ptr(), type(report.message).ptr());
  throw py::error_already_set();
}

/// One system A φ = b. κ and μ are copied: derivatives are taken long after the call, of what was
/// solved. One thread works at a time.
class Operator {
 public:
  Operator(forward::GridSetup setup, const std::string& device, forward::Precision precision,
           forward::SolveOptions options)
      : options_(options) {
    forward::SolverChoice choice = [&] {
      const Released released;
      return forward::make_grid_solver(setup, device, precision);
    }();
    solver_ = std::move(choice.solver);
    if (!choice.warning.empty()) py::module_::import("kappamu.errors").attr("warn")(choice.warning);
  }

  const forward::GridSetup& setup() const { return solver_->setup(); }
  const GridShape& shape() const { return setup().shape; }
  std::string backend() const { return solver_->backend(); }
  std::mutex& mutex() { return mutex_; }
  const forward::GridSolver& solver() const { return *solver_; }
  const forward::SolveOptions& options() const { return options_; }
  std::span<const double> kappa() const { return kappa_; }
  std::span<const double> mu() const { return mu_; }

  void set_medium(const py::object& kappa_given, const py::object& mu_given) {
    const Doubles kappa = numbers<double>(kappa_given, "kappa");
    const Doubles mu = numbers<double>(mu_given, "mu");
    require_shape(kappa, extents(shape()), "kappa", "[z][y][x] of the operator");
    require_shape(mu, extents(shape()), "mu", "[z][y][x] of the operator");
    {
      const std::span<const double> k = view(kappa), m = view(mu);
      const Released released;
      require_usual_medium(k, m);
      const std::scoped_lock lock(mutex_);
      solver_->set_medium(k, m);
    }
    kappa_ = copy(kappa);
    mu_ = copy(mu);
    ++media_;
  }
  void require_usual_medium(std::span<const double> kappa, std::span<const double> mu) const {
    const auto usual = [](std::span<const double> values, double least) {
      return std::all_of(values.begin(), values.end(),
                         [=](double v) { return v >= least && v <= most_coefficient; });
    };
    if (usual(kappa, least_kappa) && usual(mu, 0.0)) return;
    // Rare: hand the volumes to the one function that words the sentence.
    validate(Medium{Volume<double>(shape(), std::vector<double>(kappa.begin(), kappa.end())),
                    Volume<double>(shape(), std::vector<double>(mu.begin(), mu.end()))},
             "medium");
  }
  /// How often the medium has been set: solutions are of one.
  int media() const { return media_; }
  void require_medium() const {
    if (kappa_.empty())
      throw KeyedError("kappa", "the operator has no medium yet; call set_medium first");
  }

  /// `given` [M][z][y][x], or [z][y][x], as a field.
  Field field_of(const py::object& given, const std::string& key) const {
    const Doubles array = numbers<double>(given, key);
    const int patterns = array.ndim() == 4 ? static_cast<int>(array.shape(0)) : 1;
    require_patterns(patterns, key);
    require_shape(array, array.ndim() == 3 ? extents(shape()) : extents(patterns, shape()), key,
                  "[M][z][y][x]");
    Field field = solver_->make_field(patterns);
    solver_->fill(*field, view(array));
    return field;
  }
  /// A field as an array of its own.
  Doubles array_of(const forward::BatchField& field) const {
    Doubles array(extents(field.patterns(), shape()));
    solver_->read(field, view_to_fill(array));
    return array;
  }
  /// Maps of a face, [M][v][u] or [v][u], and how many.
  std::pair<Doubles, int> maps_of(const py::object& given, Face face,
                                  const std::string& key) const {
    const Doubles array = numbers<double>(given, key);
    const FaceShape of_face = face_shape(shape(), face);
    const int patterns = array.ndim() == 3 ? static_cast<int>(array.shape(0)) : 1;
    require_patterns(patterns, key);
    require_shape(array,
                  array.ndim() == 2 ? std::vector<py::ssize_t>{of_face.nv, of_face.nu}
                                    : extents(patterns, of_face),
                  key, "[M][v][u] of face " + to_string(face));
    return {array, patterns};
  }

  /// Irradiance on the lit face: finite, and of a size that floats hold. Differences of light are
  /// negative in places.
  std::pair<Doubles, int> irradiance_of(const py::object& given) const {
    const auto light = maps_of(given, setup().lit_face, "irradiance");
    double brightest = 0.0;
    for (const double e : view(light.first)) {
      if (!std::isfinite(e)) throw KeyedError("irradiance", "irradiance must be finite everywhere");
      brightest = std::max(brightest, std::abs(e));
    }
    require_usual("irradiance", [&] { require_usual_light(brightest, "the operator"); });
    return light;
  }

  Doubles solve(const py::object& load, const py::object& start) {
    require_medium();
    const Field b = field_of(load, "load");
    const Field phi =
        start.is_none() ? solver_->make_field(b->patterns()) : field_of(start, "start");
    if (phi->patterns() != b->patterns())
      throw KeyedError("start", "start must have as many patterns as load");
    forward::SolveReport report;
    {
      const Released released;
      const std::scoped_lock lock(mutex_);
      report = solver_->solve(*b, *phi, options_);
    }
    require_converged(report);
    return array_of(*phi);
  }
  Doubles apply(const py::object& fluence) {
    require_medium();
    const Field phi = field_of(fluence, "fluence");
    const Field y = solver_->make_field(phi->patterns());
    {
      const Released released;
      const std::scoped_lock lock(mutex_);
      solver_->apply(*phi, *y);
    }
    return array_of(*y);
  }
  Doubles load(const py::object& irradiance) {
    require_medium();
    const auto [light, patterns] = irradiance_of(irradiance);
    const Field b = solver_->make_field(patterns);
    solver_->light_source(view(light), *b);
    return array_of(*b);
  }
  Doubles exitance(const py::object& fluence, const std::string& face_name) {
    require_medium();
    const Face face = named(face_names, face_name, "face");
    if (setup().source == forward::SourceModel::boundary && face == setup().lit_face)
      throw KeyedError("face",
                       "under the boundary source the lit face's exitance depends on the light, "
                       "too; take it from illuminate()");
    const Field phi = field_of(fluence, "fluence");
    Doubles out(extents(phi->patterns(), face_shape(shape(), face)));
    solver_->exitance(*phi, face, {}, view_to_fill(out));
    return out;
  }
  Doubles exitance_transposed(const py::object& weights, const std::string& face_name) {
    require_medium();
    const Face face = named(face_names, face_name, "face");
    const auto [psi, patterns] = maps_of(weights, face, "weights");
    const Field b = solver_->make_field(patterns);
    solver_->exitance_adjoint(face, view(psi), *b);
    return array_of(*b);
  }

 private:
  std::unique_ptr<forward::GridSolver> solver_;
  forward::SolveOptions options_;
  std::vector<double> kappa_, mu_;  ///< none until there is a medium
  int media_ = 0;
  std::mutex mutex_;
};

/// The block under light: the fluence stays where it was solved.
class Light {
 public:
  Light(std::shared_ptr<Operator> op, const py::object& irradiance) : op_(std::move(op)) {
    op_->require_medium();
    const auto [light, patterns] = op_->irradiance_of(irradiance);
    irradiance_ = copy(light);
    medium_ = op_->media();
    phi_ = op_->solver().make_field(patterns);
    forward::SolveReport report;
    {
      const std::span<const double> e = irradiance_;
      const Released released;
      const std::scoped_lock lock(op_->mutex());
      const Field b = op_->solver().make_field(patterns);
      op_->solver().light_source(e, *b);
      report = op_->solver().solve(*b, *phi_, op_->options());
    }
    require_converged(report);
    iterations_ = report.iterations;
  }

  int iterations() const { return iterations_; }
  int medium() const { return medium_; }
  Doubles fluence() const { return op_->array_of(*phi_); }

  Doubles exitance(const std::string& face_name) const {
    require_same_medium();
    const Face face = named(face_names, face_name, "face");
    Doubles out(extents(phi_->patterns(), face_shape(op_->shape(), face)));
    op_->solver().exitance(*phi_, face, light_of(face), view_to_fill(out));
    return out;
  }

  /// ∂/∂κ, ∂/∂μ [z][y][x] and ∂/∂E [M][v][u] of Σ weights · exitance(face).
  py::tuple gradient(const py::object& weights, const std::string& face_name) const {
    require_same_medium();
    const Face face = named(face_names, face_name, "face");
    const auto [psi, patterns] = op_->maps_of(weights, face, "weights");
    if (patterns != phi_->patterns())
      throw KeyedError("weights", "weights must have as many patterns as irradiance");
    const forward::GridSolver& solver = op_->solver();
    const std::span<const double> e = irradiance_, w = view(psi);
    Doubles by_light(extents(patterns, face_shape(op_->shape(), op_->setup().lit_face)));
    const std::span<double> by_light_values = view_to_fill(by_light);
    forward::SolveReport report;
    forward::CoefficientPair by_log;
    {
      const Released released;
      const std::scoped_lock lock(op_->mutex());
      const Field b = solver.make_field(patterns);
      const Field lambda = solver.make_field(patterns);
      solver.exitance_adjoint(face, w, *b);
      report = solver.solve(*b, *lambda, op_->options());
      by_log = by_logarithms(face, w, *lambda);
      derive_by_light(face, w, *lambda, by_light_values);
      to_coefficients(by_log);
    }
    require_converged(report);
    return py::make_tuple(take(std::move(by_log.log_kappa), extents(op_->shape())),
                          take(std::move(by_log.log_mu), extents(op_->shape())), by_light);
  }

 private:
  void require_same_medium() const {
    if (medium_ != op_->media())
      throw KeyedError("kappa",
                       "the operator has another medium since this light was solved; call "
                       "illuminate again");
  }
  std::span<const double> light_of(Face face) const {
    return face == op_->setup().lit_face ? std::span<const double>(irradiance_)
                                         : std::span<const double>();
  }

  forward::CoefficientPair by_logarithms(Face face, std::span<const double> weights,
                                         const forward::BatchField& lambda) const {
    const forward::GridSolver& solver = op_->solver();
    const std::size_t cells = face_shape(op_->shape(), face).cells();
    std::vector<double> exitance(weights.size());
    solver.exitance(*phi_, face, light_of(face), exitance);
    // Light that the lit face reflects diffusely: no conductance multiplies it.
    const double apart = face == op_->setup().lit_face
                             ? forward::exitance_per_irradiance(op_->setup(), solver.constants())
                             : 0.0;
    forward::AdjointSums sums;
    sums.products = solver.pair_products(lambda, *phi_);
    sums.columns = solver.column_products(lambda, irradiance_);
    sums.observed.assign(cells, 0.0);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const double entered = apart == 0.0 ? 0.0 : apart * irradiance_[i];
      sums.observed[i % cells] += weights[i] * (exitance[i] - entered);
    }
    // A μ of 0 has no logarithm; its derivative is the limit.
    constexpr double least = 1e-100;
    const std::span<const double> mu = op_->mu();
    if (std::all_of(mu.begin(), mu.end(), [](double m) { return m >= least; }))
      return assemble(face, mu, sums);
    std::vector<double> positive(mu.begin(), mu.end());
    for (double& m : positive) m = std::max(m, least);
    return assemble(face, positive, sums);
  }
  forward::CoefficientPair assemble(Face face, std::span<const double> mu,
                                    const forward::AdjointSums& sums) const {
    forward::CoefficientPair gradient{std::vector<double>(mu.size()),
                                      std::vector<double>(mu.size())};
    forward::add_gradient(op_->setup(), op_->solver().constants(), {&face, 1}, op_->kappa(), mu,
                          sums, gradient);
    for (std::size_t i = 0; i < mu.size(); ++i) gradient.log_mu[i] /= mu[i];
    return gradient;
  }
  void to_coefficients(forward::CoefficientPair& gradient) const {
    const std::span<const double> kappa = op_->kappa();
    for (std::size_t i = 0; i < kappa.size(); ++i) gradient.log_kappa[i] /= kappa[i];
  }

  /// (∂b/∂E)ᵀ λ: each voxel's load per irradiance of its column, summed along the column; on the
  /// lit face also what its exitance has of the light itself.
  void derive_by_light(Face face, std::span<const double> weights,
                       const forward::BatchField& lambda, std::span<double> out) const {
    const forward::GridSolver& solver = op_->solver();
    const GridShape& shape = op_->shape();
    const Face lit = op_->setup().lit_face;
    const FaceShape of_face = face_shape(shape, lit);
    const Field unit = solver.make_field(1);
    solver.light_source(std::vector<double>(of_face.cells(), 1.0), *unit);
    std::vector<double> load(shape.cells());
    solver.read(*unit, load);
    std::vector<double> adjoint(shape.cells() * static_cast<std::size_t>(lambda.patterns()));
    solver.read(lambda, adjoint);
    const int depth = shape.extent(axis_of(lit));
    for (int m = 0; m < lambda.patterns(); ++m) {
      const double* const of_pattern = adjoint.data() + static_cast<std::size_t>(m) * shape.cells();
      for (int v = 0; v < of_face.nv; ++v) {
        for (int u = 0; u < of_face.nu; ++u) {
          double sum = 0.0;
          for (int k = 0; k < depth; ++k) {
            const std::size_t cell = face_cell(shape, lit, u, v, k);
            sum += load[cell] * of_pattern[cell];
          }
          out[(static_cast<std::size_t>(m) * of_face.nv + v) * of_face.nu + u] = sum;
        }
      }
    }
    if (face == lit) add_direct(weights, out);
  }
  void add_direct(std::span<const double> weights, std::span<double> out) const {
    const forward::GridSolver& solver = op_->solver();
    const FaceShape of_face = face_shape(op_->shape(), op_->setup().lit_face);
    const Field dark = solver.make_field(phi_->patterns());
    std::vector<double> per_irradiance(out.size());
    solver.exitance(*dark, op_->setup().lit_face, std::vector<double>(out.size(), 1.0),
                    per_irradiance);
    check(per_irradiance.size() % of_face.cells() == 0, "maps do not fit the lit face");
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += weights[i] * per_irradiance[i];
  }

  std::shared_ptr<Operator> op_;
  std::vector<double> irradiance_;  ///< what was solved for, whatever becomes of the caller's
  Field phi_;
  int medium_ = 0;
  int iterations_ = 0;
};

std::shared_ptr<Operator> make_operator(const std::array<int, 3>& zyx, const py::dict& options) {
  const auto text = [&](const char* key) { return value_of_key<std::string>(options, key); };
  forward::GridSetup setup;
  setup.shape = {zyx[2], zyx[1], zyx[0], value_of_key<double>(options, "voxel_mm")};
  setup.eta = value_of_key<double>(options, "eta");
  setup.lit_face = named(face_names, text("lit_face"), "lit_face");
  setup.sides = named(sides_names, text("sides"), "sides");
  setup.source = named(source_names, text("source"), "source");
  setup.convention = named(inverse::convention_names, text("convention"), "convention");
  const forward::SolveOptions solve = solve_options(options);
  require_usual("voxel_mm", [&] { require_usual_voxel(setup.shape.voxel_mm, "voxel_mm"); });
  forward::validate(setup);
  return std::make_shared<Operator>(setup, text("device"),
                                    named(inverse::precision_names, text("precision"), "precision"),
                                    solve);
}

}  // namespace

void bind_operator(py::module_& module) {
  py::class_<Operator, std::shared_ptr<Operator>>(module, "Operator")
      .def(py::init(&make_operator))
      .def_property_readonly("backend", &Operator::backend)
      .def_property_readonly("media", &Operator::media)
      .def("set_medium", &Operator::set_medium)
      .def("solve", &Operator::solve)
      .def("apply", &Operator::apply)
      .def("load", &Operator::load)
      .def("exitance", &Operator::exitance)
      .def("exitance_transposed", &Operator::exitance_transposed);
  py::class_<Light>(module, "Light")
      .def(py::init<std::shared_ptr<Operator>, const py::object&>())
      .def_property_readonly("iterations", &Light::iterations)
      .def_property_readonly("medium", &Light::medium)
      .def("fluence", &Light::fluence)
      .def("exitance", &Light::exitance)
      .def("gradient", &Light::gradient);
}

}  // namespace kappamu::python

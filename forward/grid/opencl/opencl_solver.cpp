#include "forward/grid/opencl/opencl_solver.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/processor_time.h"
#include "device/buffer_pool.h"
#include "forward/grid/grid_physics.h"
#include "forward/grid/opencl/deposit_beam.h"
#include "forward/grid/opencl/device_gradient.h"
#include "forward/grid/opencl/face_index.h"
#include "forward/grid/opencl/field_sums.h"
#include "forward/grid/opencl/multigrid/batched_cg.h"
#include "forward/grid/opencl/multigrid/grid_hierarchy.h"
#include "forward/grid/opencl/opencl_field.h"
#include "forward/grid/opencl/solver_memory.h"
#include "forward/grid/opencl/trusted_kernels.h"
#include "forward/grid/solve_verdict.h"

namespace kappamu::forward {

namespace {

/// To be written on every cell.
OpenclField& cast(BatchField& field) {
  auto* own = dynamic_cast<OpenclField*>(&field);
  check(own != nullptr, "a field of another backend was given to the OpenCL solver");
  own->zero = false;
  return *own;
}
const OpenclField& cast(const BatchField& field) {
  const auto* own = dynamic_cast<const OpenclField*>(&field);
  check(own != nullptr, "a field of another backend was given to the OpenCL solver");
  return *own;
}

class OpenclSolver final : public GridSolver {
 public:
  OpenclSolver(const GridSetup& setup, device::Context& context, const OpenclOptions& options)
      : setup_(setup),
        context_(context),
        options_(options),
        layout_(options.layout.value_or(layout_of(context.info()))),
        format_(format_of(context.info(), options.precision)),
        kernels_(context, format_, layout_, options),
        pool_(context),
        sums_(context, format_, setup, kernels_, pool_) {
    validate(setup_);
    constants_ = constants_of(setup_);
    most_lanes_ = std::min(lanes_that_fit(setup_, context_.info(), format_, layout_),
                           options.most_lanes.value_or(full_lanes));
    hierarchy_.emplace(context_, format_, layout_, setup_, constants_.A);
    deposit_ = context_.allocate(cells() * format_.real_bytes());
    if (context_.info().fp64) on_device_.emplace(*this);
  }

  const GridSetup& setup() const override { return setup_; }
  const BoundaryConstants& constants() const override { return constants_; }
  std::string backend() const override {
    return context_.info().name + (format_.single ? " (single precision)" : " (double precision)");
  }

  void set_medium(std::span<const double> kappa, std::span<const double> mu) override {
    validate_medium(setup_.shape, kappa, mu);
    // Fields of one pattern have their size: later these places serve such fields.
    const device::Buffer k = take_scalars(), m = take_scalars();
    upload(context_, format_, kappa, k);
    upload(context_, format_, mu, m);
    assemble(k, m);
  }

  std::unique_ptr<BatchField> make_field(int patterns) const override {
    check(patterns >= 1, "a field needs at least one pattern");
    auto field = std::make_unique<OpenclField>();
    field->total = patterns;
    field->blocks = cut_into_blocks(patterns, most_lanes_);
    for (Block& block : field->blocks) {
      block.values = pool_.take(field_bytes(block));
    }
    field->zero = true;
    return field;
  }

  void fill(BatchField& field, std::span<const double> values) const override {
    check(values.size() == cells() * static_cast<std::size_t>(field.patterns()),
          "fill: wrong number of values");
    OpenclField& own = cast(field);
    for (const Block& block : own.blocks) {
      write_block(context_, format_, block, cells(), values);
    }
    own.zero = std::all_of(values.begin(), values.end(), [](double v) { return v == 0.0; });
  }

  void read(const BatchField& field, std::span<double> values) const override {
    check(values.size() == cells() * static_cast<std::size_t>(field.patterns()),
          "read: wrong number of values");
    for (const Block& block : to_read(field).blocks) {
      read_block(context_, format_, block, cells(), values);
    }
  }

  void light_source(std::span<const double> irradiance, BatchField& b) const override {
    const Face lit = setup_.lit_face;
    if (setup_.source == SourceModel::boundary) {
      set_on_face(lit, irradiance, boundary_q_per_irradiance(setup_, constants_), cast(b));
      return;
    }
    need_medium();
    const GridShape& s = setup_.shape;
    const std::vector<double> power =
        scaled(irradiance, constants_.normal_transmittance * voxel_area());
    const std::array<int, 3> a = column_strides(s, lit);
    for (const Block& block : cast(b).blocks) {
      const LaneKernels& k = kernels_(block.lanes);
      const Block light = face_block(lit, block, power);
      context_.launch(k.common(), "deposit", k.rows(s), s.nx, s.ny, s.nz, a[0], a[1], a[2],
                      deposit_, light.values, block.values);
    }
  }

  void exitance_adjoint(Face face, std::span<const double> weights, BatchField& b) const override {
    set_on_face(face, weights, exitance_per_flux(setup_) / voxel_area(), cast(b));
  }

  void apply(const BatchField& phi, BatchField& y) const override {
    need_medium();
    const OpenclField& in = to_read(phi);
    const OpenclField& out = cast(y);
    check(in.total == out.total, "apply: fields of different batches");
    for (std::size_t i = 0; i < in.blocks.size(); ++i) {
      cg().apply(kernels_(in.blocks[i].lanes), in.blocks[i].values, out.blocks[i].values);
    }
  }

  void interpolate(const BatchField& coarse, const GridShape& shape, int first,
                   BatchField& phi) const override;
  SolveReport solve(const BatchField& b, BatchField& phi,
                    const SolveOptions& options) const override;

  void exitance(const BatchField& phi, Face face, std::span<const double> irradiance,
                std::span<double> out) const override {
    need_medium();
    const OpenclField& field = to_read(phi);
    const std::size_t samples = face_shape(setup_.shape, face).cells();
    check(out.size() == samples * static_cast<std::size_t>(field.total),
          "exitance: wrong number of outputs");
    const bool entering = face == setup_.lit_face && setup_.source == SourceModel::boundary;
    check(!entering || irradiance.size() == out.size(), "exitance: the lit face needs irradiance");
    const double scale = exitance_per_flux(setup_) / voxel_area();
    const double q = entering ? boundary_q_per_irradiance(setup_, constants_) : 0.0;
    const double apart = entering ? exitance_per_irradiance(setup_, constants_) : 0.0;
    const std::vector<double> dark(entering ? 0 : out.size(), 0.0);
    for (const Block& block : field.blocks) {
      const LaneKernels& k = kernels_(block.lanes);
      const Block light =
          face_block(face, block, entering ? irradiance : std::span<const double>(dark));
      const Block result = face_block(face, block, {});
      on_face(face, [&](auto&&... place) {
        with_reals(
            [&](auto s, auto qq, auto e) {
              context_.launch(k.common(), "exitance", k.items(samples), place..., s, qq, e,
                              light.values, block.values, result.values);
            },
            scale, q, apart);
      });
      read_block(context_, format_, result, samples, out);
    }
  }

  PairProducts pair_products(const BatchField& lambda, const BatchField& phi) const override {
    return sums_.pair_products(to_read(lambda), to_read(phi));
  }
  std::vector<double> column_products(const BatchField& lambda,
                                      std::span<const double> irradiance) const override {
    return sums_.column_products(to_read(lambda), irradiance);
  }
  std::vector<double> weighted_sums(const BatchField& phi,
                                    std::span<const double> weight) const override {
    return sums_.weighted_sums(to_read(phi), weight);
  }
  void change_source(const EquationsChange& change, const BatchField& phi,
                     std::span<const double> irradiance, BatchField& b) const override;
  GridOnDevice* on_device() override { return on_device_ ? &*on_device_ : nullptr; }

 private:
  /// Medium and gradient in the memory of the device.
  class OnDevice final : public GridOnDevice {
   public:
    explicit OnDevice(OpenclSolver& solver)
        : solver_(solver),
          gradient_(solver.context_, solver.format_, solver.setup_, solver.constants_) {}

    device::Context& context() const override { return solver_.context_; }
    void set_medium(const device::Buffer& logs) override {
      const device::Buffer kappa = solver_.take_scalars(), mu = solver_.take_scalars();
      gradient_.set_coefficients(logs, kappa, mu);
      solver_.assemble(kappa, mu);
    }
    CoefficientPair medium() const override { return gradient_.medium(); }
    void add_gradient(const BatchField& lambda, const BatchField& phi,
                      std::span<const double> irradiance, std::span<const Face> seen,
                      std::span<const double> observed,
                      const device::Buffer& gradient) const override {
      const FieldSums& sums = solver_.sums_;
      const OpenclField& adjoint = solver_.to_read(lambda);
      gradient_.add(sums.products(adjoint, solver_.to_read(phi)), sums.columns(adjoint, irradiance),
                    seen, observed, gradient);
    }

   private:
    OpenclSolver& solver_;
    DeviceGradient gradient_;
  };

  std::size_t cells() const { return setup_.shape.cells(); }
  double voxel_area() const { return setup_.shape.voxel_mm * setup_.shape.voxel_mm; }
  std::size_t field_bytes(const Block& block) const {
    return cells() * static_cast<std::size_t>(block.lanes) * format_.real_bytes();
  }
  /// Its blocks hold what it is.
  const OpenclField& to_read(const BatchField& field) const {
    const OpenclField& own = cast(field);
    for (const Block& block : own.blocks) {
      if (own.zero) context_.zero(block.values, field_bytes(block));
    }
    return own;
  }
  /// One of the solver's numbers for every voxel.
  device::Buffer take_scalars() const { return pool_.take(cells() * format_.real_bytes()); }
  /// Levels and deposit from κ and μ.
  void assemble(const device::Buffer& kappa, const device::Buffer& mu) {
    if (hierarchy_->set_medium(kappa, mu)) cg_.reset();
    if (setup_.source == SourceModel::first_collision) {
      deposit_beam(context_, format_, layout_, setup_, kappa, mu, deposit_);
    }
  }
  void need_medium() const {
    check(hierarchy_->has_medium(), "set_medium must come before the first use of the solver");
  }
  static std::vector<double> scaled(std::span<const double> values, double factor) {
    std::vector<double> result(values.begin(), values.end());
    for (double& v : result) v *= factor;
    return result;
  }

  BatchedCg& cg() const {
    if (!cg_) cg_.emplace(context_, format_, *hierarchy_, layout_, most_lanes_);
    return *cg_;
  }

  Block face_block(Face face, const Block& block, std::span<const double> values) const {
    return block_like(context_, format_, block, face_shape(setup_.shape, face).cells(), values);
  }

  /// Calls f with the doubles as the kernels' reals.
  template <class F, class... T>
  void with_reals(F f, T... values) const {
    if (format_.single) {
      f(static_cast<float>(values)...);
    } else {
      f(values...);
    }
  }

  /// Calls launch with the face's place as grid_surface.cl wants it.
  template <class F>
  void on_face(Face face, F launch) const {
    const FaceIndex f = face_index(setup_.shape, face);
    launch(f.nu, f.nv, f.cell, f.cell_u, f.cell_v, setup_.shape.nx, static_cast<int>(face),
           hierarchy_->finest().stencils);
  }

  /// b = scale G_b values on the face's cells, 0 elsewhere.
  void set_on_face(Face face, std::span<const double> values, double scale, OpenclField& b) const {
    need_medium();
    const std::size_t samples = face_shape(setup_.shape, face).cells();
    check(values.size() == samples * static_cast<std::size_t>(b.total),
          "wrong number of values on face " + to_string(face));
    for (const Block& block : b.blocks) {
      const LaneKernels& k = kernels_(block.lanes);
      context_.zero(block.values, field_bytes(block));
      const Block sample = face_block(face, block, values);
      on_face(face, [&](auto&&... place) {
        with_reals(
            [&](auto s) {
              context_.launch(k.common(), "add_on_face", k.items(samples), place..., s,
                              sample.values, block.values);
            },
            scale);
      });
    }
  }

  GridSetup setup_;
  BoundaryConstants constants_;
  device::Context& context_;
  OpenclOptions options_;
  Layout layout_;
  Format format_;
  int most_lanes_ = 1;
  std::optional<Hierarchy> hierarchy_;
  device::Buffer deposit_;  ///< first-collision fraction of each voxel
  // Made on first use: which lanes are needed depends on the batches that come.
  mutable TrustedKernels kernels_;
  mutable device::BufferPool pool_;
  FieldSums sums_;
  mutable std::optional<BatchedCg> cg_;
  std::optional<OnDevice> on_device_;
};

void OpenclSolver::interpolate(const BatchField& coarse, const GridShape& shape, int first,
                               BatchField& phi) const {
  const auto* from = dynamic_cast<const OpenclField*>(&coarse);
  const auto& fine = dynamic_cast<const OpenclField&>(phi);
  // All lanes of a block are those of one coarse block.
  std::vector<const Block*> sources;
  for (const Block& block : fine.blocks) {
    const int pattern = first + block.first;
    const Block* source = nullptr;
    for (std::size_t i = 0; from != nullptr && !from->zero && i < from->blocks.size(); ++i) {
      const Block& c = from->blocks[i];
      if (pattern >= c.first && pattern + block.lanes <= c.first + c.lanes) source = &c;
    }
    if (source == nullptr) return;
    sources.push_back(source);
  }
  const GridShape& s = setup_.shape;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const Block& block = cast(phi).blocks[i];
    const LaneKernels& k = kernels_(block.lanes);
    context_.launch(k.common(), "interpolate", k.rows(s), s.nx, s.ny, s.nz, shape.nx, shape.ny,
                    shape.nz, sources[i]->lanes, first + block.first - sources[i]->first,
                    sources[i]->values, block.values);
  }
}

SolveReport OpenclSolver::solve(const BatchField& b, BatchField& phi,
                                const SolveOptions& options) const {
  need_medium();
  const Stopwatch watch;
  const OpenclField& rhs = to_read(b);
  const InitialGuess guess =
      cast(std::as_const(phi)).zero ? InitialGuess::zero : InitialGuess::given;
  const OpenclField& x = cast(phi);
  check(rhs.total == x.total, "solve: fields of different batches");
  SolveReport report;
  bool stagnated = false;
  for (std::size_t i = 0; i < rhs.blocks.size(); ++i) {
    const Block& block = rhs.blocks[i];
    const BatchedCg::Result one =
        cg().solve(kernels_(block.lanes), block.values, x.blocks[i].values, guess, options);
    report.iterations = std::max(report.iterations, one.iterations);
    stagnated = stagnated || one.stagnated;
    report.residual.insert(report.residual.end(), one.residual.begin(),
                           one.residual.begin() + block.count);
  }
  context_.finish();
  conclude(report, options.tolerance, stagnated, options_.precision);
  report.seconds = watch.seconds();
  return report;
}

void OpenclSolver::change_source(const EquationsChange& change, const BatchField& phi,
                                 std::span<const double> irradiance, BatchField& b) const {
  const OpenclField& in = to_read(phi);
  const OpenclField& out = cast(b);
  check(in.total == out.total, "change_source: fields of different batches");
  const Face lit = setup_.lit_face;
  const GridShape& s = setup_.shape;
  const std::array<int, 3> a = column_strides(s, lit);
  const auto part = [&](const std::vector<double>& values) {
    return uploaded(context_, format_, values);
  };
  const std::array<device::Buffer, 5> parts{part(change.source), part(change.diagonal),
                                            part(change.face_x), part(change.face_y),
                                            part(change.face_z)};
  for (std::size_t i = 0; i < in.blocks.size(); ++i) {
    const LaneKernels& k = kernels_(in.blocks[i].lanes);
    const Block light = face_block(lit, in.blocks[i], irradiance);
    context_.launch(k.common(), "change_source", k.rows(s), s.nx, s.ny, s.nz, a[0], a[1], a[2],
                    parts[0], parts[1], parts[2], parts[3], parts[4], light.values,
                    in.blocks[i].values, out.blocks[i].values);
  }
}

}  // namespace

std::unique_ptr<GridSolver> make_opencl_solver(const GridSetup& setup, device::Context& context,
                                               const OpenclOptions& options) {
  return std::make_unique<OpenclSolver>(setup, context, options);
}

}  // namespace kappamu::forward

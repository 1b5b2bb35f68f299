#include "forward/grid/opencl/opencl_solver.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/processor_time.h"
#include "device/buffer_pool.h"
#include "forward/device_medium.h"
#include "forward/grid/grid_physics.h"
#include "forward/grid/opencl/deposit_beam.h"
#include "forward/grid/opencl/device_gradient.h"
#include "forward/grid/opencl/face_index.h"
#include "forward/grid/opencl/field_sums.h"
#include "forward/grid/opencl/multigrid/batched_cg.h"
#include "forward/grid/opencl/multigrid/grid_hierarchy.h"
#include "forward/grid/opencl/opencl_faces.h"
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
        sums_(context, format_, setup_, kernels_, pool_),
        faces_(context, format_, setup_, constants_, kernels_, hierarchy_, pool_) {
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
    need_medium();
    check_values(setup_.lit_face, irradiance.size(), b.patterns());
    faces_.light_source(faces_.samples(setup_.lit_face, irradiance, faces_.light_factor()),
                        deposit_, cast(b));
  }

  void exitance_adjoint(Face face, std::span<const double> weights, BatchField& b) const override {
    need_medium();
    check_values(face, weights.size(), b.patterns());
    faces_.zero(cast(b));
    faces_.add_seen(face, faces_.samples(face, weights), cast(b));
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
    check_values(face, out.size(), phi.patterns());
    check(!faces_.needs_light(face) || irradiance.size() == out.size(),
          "exitance: the lit face needs irradiance");
    faces_.exitance(to_read(phi), face, faces_.samples(face, irradiance),
                    faces_.to_host(face, out));
  }

  PairProducts pair_products(const BatchField& lambda, const BatchField& phi) const override {
    return sums_.pair_products(to_read(lambda), to_read(phi));
  }
  std::vector<double> column_products(const BatchField& lambda,
                                      std::span<const double> irradiance) const override {
    check_values(setup_.lit_face, irradiance.size(), lambda.patterns());
    return sums_.column_products(to_read(lambda), faces_.samples(setup_.lit_face, irradiance));
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
    void light_source(const device::Buffer& light, BatchField& b) const override {
      const OpenclFaces& faces = solver_.faces_;
      faces.light_source(lit(light, faces.light_factor()), solver_.deposit_, cast(b));
    }
    void exitance(const BatchField& phi, std::span<const Face> seen, const device::Buffer& light,
                  const device::Buffer& out) const override {
      for (std::size_t f = 0; f < seen.size(); ++f) {
        solver_.faces_.exitance(solver_.to_read(phi), seen[f], lit(light),
                                solver_.faces_.to_device(seen[f], one_of(seen, f, out)));
      }
    }
    void exitance_adjoint(std::span<const Face> seen, const device::Buffer& weights,
                          BatchField& b) const override {
      const OpenclField& own = cast(b);
      solver_.faces_.zero(own);
      for (std::size_t f = 0; f < seen.size(); ++f) {
        solver_.faces_.add_seen(seen[f], solver_.faces_.samples(seen[f], one_of(seen, f, weights)),
                                own);
      }
    }
    void add_gradient(const BatchField& lambda, const DeviceBatch& at, std::span<const Face> seen,
                      const device::Buffer& weights,
                      const device::Buffer& gradient) const override {
      const FieldSums& sums = solver_.sums_;
      const OpenclField& adjoint = solver_.to_read(lambda);
      gradient_.add(
          sums.products(adjoint, solver_.to_read(at.phi)), sums.columns(adjoint, lit(at.light)),
          seen, gradient_.observed(adjoint.total, seen, weights, at.exitance, at.light), gradient);
    }

   private:
    std::size_t samples(Face face) const { return face_shape(solver_.setup_.shape, face).cells(); }
    SamplesOf lit(const device::Buffer& light, double factor = 1.0) const {
      const Face face = solver_.setup_.lit_face;
      return solver_.faces_.samples(face, FaceOnDevice{light, 0, samples(face)}, factor);
    }
    FaceOnDevice one_of(std::span<const Face> seen, std::size_t f,
                        const device::Buffer& values) const {
      const std::size_t each = samples(seen[f]);
      return {values, f * each, seen.size() * each};
    }

    OpenclSolver& solver_;
    DeviceGradient gradient_;
  };

  std::size_t cells() const { return setup_.shape.cells(); }
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
  void check_values(Face face, std::size_t count, int patterns) const {
    check(count == face_shape(setup_.shape, face).cells() * static_cast<std::size_t>(patterns),
          "wrong number of values on face " + to_string(face));
  }

  BatchedCg& cg() const {
    if (!cg_) cg_.emplace(context_, format_, *hierarchy_, layout_, most_lanes_);
    return *cg_;
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
  OpenclFaces faces_;
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
  const SamplesOf light = faces_.samples(setup_.lit_face, irradiance);
  const GridShape& s = setup_.shape;
  const std::array<int, 3> a = column_strides(s, setup_.lit_face);
  const auto part = [&](const std::vector<double>& values) {
    return uploaded(context_, format_, values);
  };
  const std::array<device::Buffer, 5> parts{part(change.source), part(change.diagonal),
                                            part(change.face_x), part(change.face_y),
                                            part(change.face_z)};
  for (std::size_t i = 0; i < in.blocks.size(); ++i) {
    const LaneKernels& k = kernels_(in.blocks[i].lanes);
    context_.launch(k.common(), "change_source", k.rows(s), s.nx, s.ny, s.nz, a[0], a[1], a[2],
                    parts[0], parts[1], parts[2], parts[3], parts[4], light(in.blocks[i]),
                    in.blocks[i].values, out.blocks[i].values);
  }
}

}  // namespace

std::unique_ptr<GridSolver> make_opencl_solver(const GridSetup& setup, device::Context& context,
                                               const OpenclOptions& options) {
  return std::make_unique<OpenclSolver>(setup, context, options);
}

}  // namespace kappamu::forward

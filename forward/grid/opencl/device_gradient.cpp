#include "forward/grid/opencl/device_gradient.h"

#include <string>

#include "forward/device_medium.h"
#include "forward/grid/grid_physics.h"
#include "forward/grid/opencl/face_index.h"

namespace kappamu::forward {

extern const device::KernelSource grid_gradient_cl;

device::Program& double_program(device::Context& context, const Format& format) {
  return context.program(grid_gradient_cl, std::string("-DREAL=double -DSTORED=") +
                                               (format.single ? "float" : "double"));
}

namespace {

device::Range items(std::size_t count) {
  return {count, 1, 64, 1};
}

}  // namespace

DeviceGradient::DeviceGradient(device::Context& context, const Format& format,
                               const GridSetup& setup, const BoundaryConstants& constants)
    : context_(context), format_(format), setup_(setup), constants_(constants), pool_(context) {}

void DeviceGradient::set_coefficients(const device::Buffer& logs, const device::Buffer& kappa,
                                      const device::Buffer& mu) {
  if (!logs_) logs_ = context_.allocate(bytes());
  context_.copy(logs, logs_, bytes());
  const std::size_t cells = setup_.shape.cells();
  context_.launch(double_program(context_, format_), "set_coefficients", items(cells),
                  static_cast<int>(cells), logs_, kappa, mu);
}

CoefficientPair DeviceGradient::medium() const {
  return read_pair(context_, logs_, setup_.shape.cells());
}

device::Buffer DeviceGradient::observed(int patterns, std::span<const Face> seen,
                                        const device::Buffer& weights,
                                        const device::Buffer& exitance,
                                        const device::Buffer& light) const {
  const std::size_t samples = face_shape(setup_.shape, seen.front()).cells();
  const std::size_t all = seen.size() * samples;
  device::Buffer sums = pool_.take(all * sizeof(double));
  for (std::size_t f = 0; f < seen.size(); ++f) {
    const double apart =
        seen[f] == setup_.lit_face ? exitance_per_irradiance(setup_, constants_) : 0.0;
    context_.launch(double_program(context_, format_), "observe", items(samples),
                    static_cast<int>(samples), static_cast<int>(f * samples), static_cast<int>(all),
                    patterns, apart, weights, exitance, light, sums);
  }
  return sums;
}

void DeviceGradient::add(const std::array<device::Buffer, 4>& products,
                         const device::Buffer& columns, std::span<const Face> seen,
                         const device::Buffer& observed, const device::Buffer& gradient) const {
  const GridShape& s = setup_.shape;
  device::Program& program = double_program(context_, format_);
  context_.launch(program, "gradient_of_voxels", items(s.cells()), s.nx, s.ny, s.nz,
                  int{is_open(setup_, Face::x_minus)}, int{is_open(setup_, Face::y_minus)},
                  int{is_open(setup_, Face::z_minus)}, s.voxel_mm, constants_.A, logs_, products[0],
                  products[1], products[2], products[3], gradient);
  int first = 0;
  for (const Face face : seen) {
    const FaceIndex f = face_index(s, face);
    context_.launch(program, "gradient_of_seen", items(face_shape(s, face).cells()), f.nu, f.nv,
                    f.cell, f.cell_u, f.cell_v, s.voxel_mm, constants_.A, first, logs_, observed,
                    gradient);
    first += f.nu * f.nv;
  }
  if (setup_.source == SourceModel::boundary) {
    add_entry(columns, gradient);
  } else {
    add_beam(columns, gradient);
  }
}

void DeviceGradient::add_entry(const device::Buffer& columns,
                               const device::Buffer& gradient) const {
  const GridShape& s = setup_.shape;
  const FaceIndex f = face_index(s, setup_.lit_face);
  context_.launch(double_program(context_, format_), "gradient_of_entry",
                  items(face_shape(s, setup_.lit_face).cells()), f.nu, f.nv, f.cell, f.cell_u,
                  f.cell_v, s.voxel_mm, constants_.A, boundary_q_per_irradiance(setup_, constants_),
                  logs_, columns, gradient);
}

void DeviceGradient::add_beam(const device::Buffer& columns, const device::Buffer& gradient) const {
  const GridShape& s = setup_.shape;
  const Face lit = setup_.lit_face;
  const FaceIndex f = face_index(s, lit);
  const std::size_t scratch_bytes = s.cells() * sizeof(double);
  const std::array<device::Buffer, 3> scratch{pool_.take(scratch_bytes), pool_.take(scratch_bytes),
                                              pool_.take(scratch_bytes)};
  context_.launch(double_program(context_, format_), "gradient_of_beam",
                  items(face_shape(s, lit).cells()), f.nu, f.nv, s.extent(axis_of(lit)), f.cell,
                  f.cell_u, f.cell_v, cells_inwards(s, lit), static_cast<int>(s.cells()),
                  s.voxel_mm, fresnel_internal(setup_.eta, 1.0),
                  s.voxel_mm * s.voxel_mm * constants_.normal_transmittance, logs_, columns,
                  scratch[0], scratch[1], scratch[2], gradient);
}

}  // namespace kappamu::forward

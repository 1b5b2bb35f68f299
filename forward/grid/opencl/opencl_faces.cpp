#include "forward/grid/opencl/opencl_faces.h"

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "forward/grid/grid_physics.h"
#include "forward/grid/opencl/device_gradient.h"
#include "forward/grid/opencl/face_index.h"

namespace kappamu::forward {

OpenclFaces::OpenclFaces(device::Context& context, const Format& format, const GridSetup& setup,
                         const BoundaryConstants& constants, TrustedKernels& kernels,
                         const std::optional<Hierarchy>& hierarchy, device::BufferPool& pool)
    : context_(context),
      format_(format),
      setup_(setup),
      constants_(constants),
      kernels_(kernels),
      hierarchy_(hierarchy),
      pool_(pool) {}

std::size_t OpenclFaces::bytes(Face face, const Block& block) const {
  return count(face) * static_cast<std::size_t>(block.lanes) * format_.real_bytes();
}

SamplesOf OpenclFaces::samples(Face face, std::span<const double> values, double factor) const {
  std::vector<double> scaled;
  if (factor != 1.0) {
    scaled.assign(values.begin(), values.end());
    for (double& v : scaled) v *= factor;
  }
  return [this, face, values, scaled = std::move(scaled)](const Block& block) {
    Block own{block.first, block.count, block.lanes, pool_.take(bytes(face, block))};
    write_block(context_, format_, own, count(face),
                scaled.empty() ? values : std::span<const double>(scaled));
    return own.values;
  };
}

SamplesOf OpenclFaces::samples(Face face, const FaceOnDevice& values, double factor) const {
  return [this, face, values, factor](const Block& block) {
    device::Buffer packed = pool_.take(bytes(face, block));
    context_.launch(double_program(context_, format_), "pack_samples", {count(face), 1, 64, 1},
                    static_cast<int>(count(face)), block.lanes, block.count,
                    static_cast<int>(values.first_of(block)), static_cast<int>(values.stride),
                    factor, values.values, packed);
    return packed;
  };
}

device::Buffer OpenclFaces::dark(Face face, const Block& block) const {
  device::Buffer none = pool_.take(bytes(face, block));
  context_.zero(none, bytes(face, block));
  return none;
}

TakeSamples OpenclFaces::to_host(Face face, std::span<double> values) const {
  return [this, face, values](const Block& block, const device::Buffer& samples) {
    read_block(context_, format_, {block.first, block.count, block.lanes, samples}, count(face),
               values);
  };
}

TakeSamples OpenclFaces::to_device(Face face, const FaceOnDevice& values) const {
  return [this, face, values](const Block& block, const device::Buffer& samples) {
    context_.launch(double_program(context_, format_), "unpack_samples", {count(face), 1, 64, 1},
                    static_cast<int>(count(face)), block.lanes, block.count,
                    static_cast<int>(values.first_of(block)), static_cast<int>(values.stride),
                    samples, values.values);
  };
}

/// Calls f with the doubles as the kernels' reals.
template <class F, class... T>
void OpenclFaces::with_reals(F f, T... values) const {
  if (format_.single) {
    f(static_cast<float>(values)...);
  } else {
    f(values...);
  }
}

/// Calls launch with the face's place as grid_surface.cl wants it.
template <class F>
void OpenclFaces::on_face(Face face, F launch) const {
  const FaceIndex f = face_index(setup_.shape, face);
  launch(f.nu, f.nv, f.cell, f.cell_u, f.cell_v, setup_.shape.nx, static_cast<int>(face),
         hierarchy_->finest().stencils);
}

void OpenclFaces::zero(const OpenclField& b) const {
  for (const Block& block : b.blocks) {
    context_.zero(block.values, setup_.shape.cells() * static_cast<std::size_t>(block.lanes) *
                                    format_.real_bytes());
  }
}

void OpenclFaces::add_on_face(Face face, const SamplesOf& values, double scale,
                              const OpenclField& b) const {
  for (const Block& block : b.blocks) {
    const LaneKernels& k = kernels_(block.lanes);
    const device::Buffer samples = values(block);
    on_face(face, [&](auto&&... place) {
      with_reals(
          [&](auto s) {
            context_.launch(k.common(), "add_on_face", k.items(count(face)), place..., s, samples,
                            block.values);
          },
          scale);
    });
  }
}

void OpenclFaces::add_seen(Face face, const SamplesOf& weights, const OpenclField& b) const {
  add_on_face(face, weights, exitance_per_flux(setup_) / area(), b);
}

double OpenclFaces::light_factor() const {
  return setup_.source == SourceModel::boundary ? 1.0 : constants_.normal_transmittance * area();
}

void OpenclFaces::light_source(const SamplesOf& light, const device::Buffer& deposit,
                               const OpenclField& b) const {
  if (setup_.source == SourceModel::boundary) {
    zero(b);
    add_on_face(setup_.lit_face, light, boundary_q_per_irradiance(setup_, constants_), b);
    return;
  }
  const GridShape& s = setup_.shape;
  const std::array<int, 3> a = column_strides(s, setup_.lit_face);
  for (const Block& block : b.blocks) {
    const LaneKernels& k = kernels_(block.lanes);
    context_.launch(k.common(), "deposit", k.rows(s), s.nx, s.ny, s.nz, a[0], a[1], a[2], deposit,
                    light(block), block.values);
  }
}

bool OpenclFaces::needs_light(Face face) const {
  return face == setup_.lit_face && setup_.source == SourceModel::boundary;
}

void OpenclFaces::exitance(const OpenclField& phi, Face face, const SamplesOf& light,
                           const TakeSamples& take) const {
  const bool entering = needs_light(face);
  const double scale = exitance_per_flux(setup_) / area();
  const double q = entering ? boundary_q_per_irradiance(setup_, constants_) : 0.0;
  const double apart = entering ? exitance_per_irradiance(setup_, constants_) : 0.0;
  for (const Block& block : phi.blocks) {
    const LaneKernels& k = kernels_(block.lanes);
    const device::Buffer lit = entering ? light(block) : dark(face, block);
    const device::Buffer result = pool_.take(bytes(face, block));
    on_face(face, [&](auto&&... place) {
      with_reals(
          [&](auto s, auto qq, auto e) {
            context_.launch(k.common(), "exitance", k.items(count(face)), place..., s, qq, e, lit,
                            block.values, result);
          },
          scale, q, apart);
    });
    take(block, result);
  }
}

}  // namespace kappamu::forward

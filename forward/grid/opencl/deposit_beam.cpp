#include "forward/grid/opencl/deposit_beam.h"

#include "core/optics.h"
#include "forward/grid/opencl/face_index.h"

namespace kappamu::forward {

void deposit_beam(device::Context& context, const Format& format, Layout layout,
                  const GridSetup& setup, const device::Buffer& kappa, const device::Buffer& mu,
                  const device::Buffer& share) {
  const GridShape& s = setup.shape;
  const FaceIndex f = face_index(s, setup.lit_face);
  const int depth = s.extent(axis_of(setup.lit_face)), inwards = cells_inwards(s, setup.lit_face);
  const auto eights = static_cast<std::size_t>((f.nu + 7) / 8);
  const auto rows = static_cast<std::size_t>(f.nv);
  const device::Buffer remaining = context.allocate(8 * eights * rows * format.accu_bytes());
  const device::Range items =
      layout == Layout::gpu ? device::Range{eights, rows, 32, 1} : device::Range{1, rows, 1, 1};
  const auto launch = [&](auto h, auto reflectance) {
    context.launch(level_program(context, format, layout), "first_collisions", items, f.nu, f.nv,
                   depth, f.cell, f.cell_u, f.cell_v, inwards, h, reflectance, kappa, mu, share,
                   remaining);
  };
  const double reflectance = fresnel_internal(setup.eta, 1.0);
  if (format.single) {
    launch(static_cast<float>(s.voxel_mm), static_cast<float>(reflectance));
  } else {
    launch(s.voxel_mm, reflectance);
  }
}

}  // namespace kappamu::forward

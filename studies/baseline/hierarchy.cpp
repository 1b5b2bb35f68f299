#include "studies/baseline/hierarchy.h"

namespace kappamu::studies::baseline {

namespace {

/// G_b below each sample of the lit face, [v][u].
std::vector<double> lit_conductance(const Stencil& stencil, Face lit) {
  // As a grid of faces, the array across the lit axis is one longer; its outermost layer is wanted.
  GridShape faces{stencil.n[0], stencil.n[1], stencil.n[2], 1.0};
  const int axis = axis_of(lit);
  ++(axis == 0 ? faces.nx : axis == 1 ? faces.ny : faces.nz);
  const FaceShape face = face_shape(faces, lit);
  std::vector<double> g(face.cells());
  std::size_t k = 0;
  for (int v = 0; v < face.nv; ++v) {
    for (int u = 0; u < face.nu; ++u) {
      g[k++] = stencil.face[static_cast<std::size_t>(axis)][face_cell(faces, lit, u, v)];
    }
  }
  return g;
}

/// What the sum of the children's b is multiplied by. First collisions add up. The boundary source
/// is b = G_b q, and it is q that must not change with the grid.
std::vector<double> light_scale(const GridSetup& setup, const Stencil& fine,
                                const Stencil& coarse) {
  const GridShape shape{coarse.n[0], coarse.n[1], coarse.n[2], 1.0};
  std::vector<double> scale(shape.cells(), 1.0);
  if (setup.source != SourceModel::boundary) return scale;
  const Face lit = setup.lit_face;
  const std::vector<double> fine_g = lit_conductance(fine, lit);
  const std::vector<double> coarse_g = lit_conductance(coarse, lit);
  const FaceShape fine_face = face_shape({fine.n[0], fine.n[1], fine.n[2], 1.0}, lit);
  const FaceShape face = face_shape(shape, lit);
  std::vector<double> children(face.cells(), 0.0);
  for (int v = 0; v < fine_face.nv; ++v) {
    for (int u = 0; u < fine_face.nu; ++u) {
      children[static_cast<std::size_t>(v / 2) * face.nu + u / 2] +=
          fine_g[static_cast<std::size_t>(v) * fine_face.nu + u];
    }
  }
  for (int v = 0; v < face.nv; ++v) {
    for (int u = 0; u < face.nu; ++u) {
      const std::size_t k = static_cast<std::size_t>(v) * face.nu + u;
      scale[face_cell(shape, lit, u, v)] = coarse_g[k] / children[k];
    }
  }
  return scale;
}

}  // namespace

CoarseToFine::CoarseToFine(const Batch& batch, const GridSetup& setup, double robin_A,
                           const Medium& medium, const HierarchyOptions& options)
    : active_(options.active) {
  Bricks bricks = bricks_of(setup.shape);
  std::vector<double> kappa = medium.kappa.values(), mu = medium.mu.values();
  Stencil stencil = conservative_stencil(setup, robin_A, bricks, kappa, mu);
  levels_.push_back({batch.upload(stencil), {}});
  while (static_cast<int>(levels_.size()) < options.levels && bricks.cells() > 1) {
    const Bricks coarse = coarsened(bricks);
    kappa = children_mean(bricks, coarse, kappa);
    mu = children_mean(bricks, coarse, mu);
    const Stencil next = conservative_stencil(setup, robin_A, coarse, kappa, mu);
    levels_.push_back({batch.upload(next), batch.upload(light_scale(setup, stencil, next))});
    bricks = coarse;
    stencil = next;
  }
}

CoarseToFine::Result CoarseToFine::solve(const Batch& batch, const device::Buffer& b,
                                         device::Buffer& phi, Relaxation kind,
                                         const SolveOptions& options) const {
  std::vector<device::Buffer> light{b};
  for (std::size_t l = 1; l < levels_.size(); ++l) {
    const auto& n = levels_[l - 1].stencil.n;
    const std::size_t cells = levels_[l].stencil.cells();
    light.push_back(batch.make_field(cells));
    batch.over_cells("sum_children", cells, n[0], n[1], n[2], levels_[l].light_scale, light[l - 1],
                     light[l]);
  }
  Result result;
  device::Buffer coarse;
  for (std::size_t l = levels_.size(); l-- > 1;) {
    const DeviceStencil& stencil = levels_[l].stencil;
    device::Buffer field = batch.make_field(stencil.cells());
    const bool coarsest = l + 1 == levels_.size();
    if (!coarsest) {
      const auto& n = stencil.n;
      batch.over_cells("copy_to_children", stencil.cells(), n[0], n[1], n[2], coarse, field);
    }
    const Relaxed relaxed =
        relax(batch, kind, stencil, coarsest ? Active{} : active_, light[l], field, options);
    result.coarse_sweeps.push_back(relaxed.sweeps);
    coarse = field;
  }
  const DeviceStencil& finest = levels_.front().stencil;
  if (levels_.size() > 1) {
    const auto& n = finest.n;
    batch.over_cells("copy_to_children", finest.cells(), n[0], n[1], n[2], coarse, phi);
  }
  result.finest =
      relax(batch, kind, finest, levels_.size() > 1 ? active_ : Active{}, b, phi, options);
  return result;
}

}  // namespace kappamu::studies::baseline

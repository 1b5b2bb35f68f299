#include "studies/forward/problem.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "forward/grid/grid_physics.h"
#include "tests/cases/limit_case.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

constexpr double truth_tolerance = 1e-13;

std::vector<double> first_patterns(const std::vector<double>& all, std::size_t size, int patterns) {
  return {all.begin(),
          all.begin() + static_cast<std::ptrdiff_t>(size * static_cast<std::size_t>(patterns))};
}

}  // namespace

Problem::Problem(ProblemSpec spec, const std::string& device) : spec_(std::move(spec)) {
  setup_.shape = spec_.shape;
  medium_ = make_medium(spec_.shape, spec_.medium);
  irradiance_ = patch_light(spec_.shape, setup_.lit_face, spec_.patterns);
  spec_.compared = std::min(spec_.compared, spec_.patterns);
  if (spec_.compared == 0) return;
  solver_ = forward::make_grid_solver(setup_, device, forward::Precision::double_precision).solver;
  solver_->set_medium(medium_.kappa.values(), medium_.mu.values());
  const auto b = solver_->make_field(spec_.compared);
  const auto phi = solver_->make_field(spec_.compared);
  solver_->light_source(irradiance(spec_.compared), *b);
  const forward::SolveOptions options{truth_tolerance, 400};
  solver_->solve(*b, *phi, options);
  std::vector<double> first(spec_.shape.cells() * static_cast<std::size_t>(spec_.compared));
  solver_->read(*phi, first);
  solver_->solve(*b, *phi, options);
  phi_.resize(first.size());
  solver_->read(*phi, phi_);
  truth_error_ = worst_difference(first, phi_, spec_.compared);
  maps_ = maps_of(phi_, spec_.compared);
}

std::vector<double> Problem::irradiance(int patterns) const {
  return first_patterns(irradiance_, face_shape(setup_.shape, setup_.lit_face).cells(), patterns);
}

std::vector<double> Problem::right_hand_sides(int patterns) const {
  check(patterns <= spec_.patterns, "right_hand_sides: more patterns than there are");
  const auto b = solver_->make_field(patterns);
  solver_->light_source(irradiance(patterns), *b);
  std::vector<double> values(setup_.shape.cells() * static_cast<std::size_t>(patterns));
  solver_->read(*b, values);
  return values;
}

std::array<std::vector<double>, 6> Problem::maps_of(const std::vector<double>& phi,
                                                    int patterns) const {
  const auto field = solver_->make_field(patterns);
  solver_->fill(*field, phi);
  std::array<std::vector<double>, 6> maps;
  const std::vector<double> light = irradiance(patterns);
  for (std::size_t f = 0; f < all_faces.size(); ++f) {
    maps[f].resize(face_shape(setup_.shape, all_faces[f]).cells() *
                   static_cast<std::size_t>(patterns));
    const bool lit = all_faces[f] == setup_.lit_face;
    solver_->exitance(*field, all_faces[f],
                      lit ? std::span<const double>(light) : std::span<const double>(), maps[f]);
  }
  return maps;
}

Errors Problem::errors_of(const std::vector<double>& phi, int patterns) const {
  const int compared = std::min(patterns, spec_.compared);
  const std::size_t cells = setup_.shape.cells();
  const std::vector<double> mine = first_patterns(phi, cells, compared);
  return {worst_difference(mine, first_patterns(phi_, cells, compared), compared),
          map_error(maps_of(mine, compared), compared)};
}

double Problem::map_error(const std::array<std::vector<double>, 6>& maps, int patterns) const {
  const int compared = std::min(patterns, spec_.compared);
  double worst = 0.0;
  for (int m = 0; m < compared; ++m) {
    double difference = 0.0, size = 0.0;
    for (std::size_t f = 0; f < all_faces.size(); ++f) {
      const std::size_t cells = face_shape(setup_.shape, all_faces[f]).cells();
      for (std::size_t i = cells * static_cast<std::size_t>(m), end = i + cells; i < end; ++i) {
        difference += (maps[f][i] - maps_[f][i]) * (maps[f][i] - maps_[f][i]);
        size += maps_[f][i] * maps_[f][i];
      }
    }
    worst = std::max(worst, std::sqrt(difference / size));
  }
  return worst;
}

AssembledMatrix assemble(const forward::GridSetup& setup, const BoundaryConstants& constants,
                         const Medium& medium) {
  const GridShape& s = setup.shape;
  const double h = s.voxel_mm;
  AssembledMatrix matrix;
  for (auto& link : matrix.link) link.assign(s.cells(), 0.0);
  matrix.diagonal.resize(s.cells());
  for (std::size_t i = 0; i < s.cells(); ++i) matrix.diagonal[i] = medium.mu[i] * h * h * h;
  const std::array<std::size_t, 3> stride{
      1, static_cast<std::size_t>(s.nx),
      static_cast<std::size_t>(s.nx) * static_cast<std::size_t>(s.ny)};
  for (int z = 0; z < s.nz; ++z) {
    for (int y = 0; y < s.ny; ++y) {
      for (int x = 0; x < s.nx; ++x) {
        const std::size_t i = s.index(x, y, z);
        const std::array<int, 3> at{x, y, z};
        for (std::size_t a = 0; a < 3; ++a) {
          if (at[a] + 1 == s.extent(static_cast<int>(a))) continue;
          const std::size_t j = i + stride[a];
          const double ki = medium.kappa[i], kj = medium.kappa[j];
          const double g = h * 2.0 * ki * kj / (ki + kj);
          matrix.link[a][i] = g;
          matrix.diagonal[i] += g;
          matrix.diagonal[j] += g;
        }
      }
    }
  }
  for (const Face face : all_faces) {
    if (!forward::is_open(setup, face)) continue;
    const FaceShape shape = face_shape(s, face);
    for (int v = 0; v < shape.nv; ++v) {
      for (int u = 0; u < shape.nu; ++u) {
        const std::size_t i = face_cell(s, face, u, v);
        matrix.diagonal[i] += h * h / (h / (2.0 * medium.kappa[i]) + 2.0 * constants.A);
      }
    }
  }
  return matrix;
}

}  // namespace kappamu::studies

#include "inverse/problem/problem.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/optics.h"
#include "core/parallel.h"

namespace kappamu::inverse {

namespace {

double largest_used(const std::vector<double>& data, const std::vector<double>& weight,
                    std::size_t begin, std::size_t end) {
  double largest = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    if (weight[i] > 0.0) largest = std::max(largest, std::abs(data[i]));
  }
  return largest;
}

/// Root mean square of d/σ of some pictures.
double signal(const Problem& problem, const std::vector<int>& pictures) {
  const std::size_t pixels = problem.seen_shape().cells();
  double squares = 0.0;
  std::size_t used = 0;
  for (const int m : pictures) {
    const std::size_t first = static_cast<std::size_t>(m) * pixels;
    for (std::size_t i = first; i < first + pixels; ++i) {
      squares += problem.weight[i] * problem.data[i] * problem.data[i];
      used += problem.weight[i] > 0.0 ? 1 : 0;
    }
  }
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, used)));
}

/// Adds the model's own variance to weights that hold 1/measured variance.
void add_model_error(Problem& problem, const ModelError& error) {
  const std::size_t pixels = problem.seen_shape().cells();
  for (std::size_t m = 0; m < static_cast<std::size_t>(problem.patterns); ++m) {
    const double largest = largest_used(problem.data, problem.weight, m * pixels, (m + 1) * pixels);
    for (std::size_t i = m * pixels; i < (m + 1) * pixels; ++i) {
      if (problem.weight[i] == 0.0) continue;
      const double variance = 1.0 / problem.weight[i] +
                              std::pow(error.relative * problem.data[i], 2) +
                              std::pow(error.of_maximum * largest, 2);
      problem.weight[i] = 1.0 / variance;
    }
  }
}

void set_smooth_error(Problem& problem, const SmoothError& error) {
  problem.smooth_error = error;
  if (error.none()) return;
  std::vector<PicturesOfFace> faces;
  for (std::vector<int>& pictures : problem.pictures_by_face()) {
    const double q = signal(problem, pictures);
    faces.push_back({std::move(pictures), q});
  }
  problem.precision.emplace(problem.seen_shape(), std::move(faces), error);
}

/// Linear interpolation weights of one axis at voxels of half the edge.
struct AxisStencil {
  std::vector<std::array<int, 2>> index;
  std::vector<std::array<double, 2>> weight;
};

AxisStencil axis_stencil(int coarse, int fine) {
  AxisStencil stencil;
  for (int i = 0; i < fine; ++i) {
    const double position = 0.5 * (i + 0.5) - 0.5;
    const int below = static_cast<int>(std::floor(position));
    const double share = position - below;
    stencil.index.push_back(
        {std::clamp(below, 0, coarse - 1), std::clamp(below + 1, 0, coarse - 1)});
    stencil.weight.push_back({1.0 - share, share});
  }
  return stencil;
}

}  // namespace

std::size_t Problem::used() const {
  return static_cast<std::size_t>(
      std::count_if(weight.begin(), weight.end(), [](double w) { return w > 0.0; }));
}

std::vector<std::vector<int>> Problem::pictures_by_face() const {
  std::vector<std::vector<int>> pictures(seen_faces.empty() ? 1 : 2);
  for (int m = 0; m < patterns; ++m) {
    const bool far = !seen_faces.empty() && seen_faces[static_cast<std::size_t>(m)] != seen_face;
    pictures[far ? 1 : 0].push_back(m);
  }
  std::erase_if(pictures, [](const std::vector<int>& of_face) { return of_face.empty(); });
  return pictures;
}

double exitance_per_value(const SurfaceMeasurements& measurements,
                          const forward::GridSetup& setup) {
  if (measurements.quantity == Quantity::exitance) return 1.0;
  return 1.0 / radiance_per_exitance(boundary_constants(setup.eta), 1.0);
}

Cameras cameras_of(const SurfaceMeasurements& measurements) {
  return measurements.light == Light::collimated && measurements.quantity == Quantity::exitance
             ? measurements.cameras
             : Cameras{};
}

forward::GridSetup make_setup(const SurfaceMeasurements& measurements,
                              forward::Convention convention) {
  const bool boundary =
      measurements.light == Light::diffuse || convention == forward::Convention::wang2008;
  return {measurements.grid,
          measurements.eta,
          measurements.lit_face,
          measurements.sides,
          boundary ? forward::SourceModel::boundary : forward::SourceModel::first_collision,
          convention};
}

Problem make_problem(const SurfaceMeasurements& measurements, int channel,
                     forward::Convention convention, const ModelError& model_error) {
  Problem problem;
  problem.setup = make_setup(measurements, convention);
  problem.seen_face = measurements.seen_face;
  problem.seen_faces = measurements.seen_faces;
  problem.patterns = measurements.patterns;
  problem.cameras = cameras_of(measurements);
  problem.irradiance.assign(measurements.irradiance.begin(), measurements.irradiance.end());
  const double scale = exitance_per_value(measurements, problem.setup);
  const std::size_t count =
      measurements.seen_shape().cells() * static_cast<std::size_t>(measurements.patterns);
  const std::size_t first = count * static_cast<std::size_t>(channel);
  problem.data.assign(count, 0.0);
  problem.weight.assign(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    if (!measurements.mask.empty() && measurements.mask[first + i] == 0) continue;
    problem.data[i] = scale * measurements.value[first + i];
    problem.weight[i] = 1.0 / (scale * scale * measurements.variance[first + i]);
    if (measurements.lit.empty() || measurements.lit[first + i] == 0) continue;
    problem.lateral.resize(static_cast<std::size_t>(measurements.patterns), 0);
    problem.lateral[i / problem.seen_shape().cells()] = 1;
  }
  add_model_error(problem, model_error);
  set_smooth_error(problem, measurements.smooth_error);
  return problem;
}

void equalise_weights(Problem& problem) {
  double variance = 0.0;
  for (const double w : problem.weight) variance += w > 0.0 ? 1.0 / w : 0.0;
  const double mean = variance / static_cast<double>(problem.used());
  for (double& w : problem.weight) w = w > 0.0 ? 1.0 / mean : 0.0;
  problem.precision.reset();
}

Problem coarsen(const Problem& fine, const ModelError& model_error) {
  Problem coarse;
  coarse.setup = fine.setup;
  const GridShape& s = fine.setup.shape;
  coarse.setup.shape = {(s.nx + 1) / 2, (s.ny + 1) / 2, (s.nz + 1) / 2, 2.0 * s.voxel_mm};
  coarse.seen_face = fine.seen_face;
  coarse.seen_faces = fine.seen_faces;
  coarse.cameras = fine.cameras;
  coarse.lateral = fine.lateral;
  coarse.patterns = fine.patterns;

  const FaceShape fine_lit = fine.lit_shape();
  const FaceShape lit = coarse.lit_shape();
  const FaceShape fine_seen = fine.seen_shape();
  const FaceShape seen = coarse.seen_shape();
  const std::size_t count = seen.cells() * static_cast<std::size_t>(fine.patterns);
  coarse.irradiance.assign(lit.cells() * static_cast<std::size_t>(fine.patterns), 0.0);
  coarse.data.assign(count, 0.0);
  coarse.weight.assign(count, 0.0);
  std::vector<double> variance(count, 0.0);
  std::vector<int> covered(count, 0);
  std::vector<int> present(count, 0);
  for (int m = 0; m < fine.patterns; ++m) {
    for (int v = 0; v < fine_lit.nv; ++v) {
      for (int u = 0; u < fine_lit.nu; ++u) {
        const std::size_t from = (static_cast<std::size_t>(m) * fine_lit.nv + v) * fine_lit.nu + u;
        const std::size_t to = (static_cast<std::size_t>(m) * lit.nv + v / 2) * lit.nu + u / 2;
        coarse.irradiance[to] += 0.25 * fine.irradiance[from];
      }
    }
    for (int v = 0; v < fine_seen.nv; ++v) {
      for (int u = 0; u < fine_seen.nu; ++u) {
        const std::size_t from =
            (static_cast<std::size_t>(m) * fine_seen.nv + v) * fine_seen.nu + u;
        const std::size_t to = (static_cast<std::size_t>(m) * seen.nv + v / 2) * seen.nu + u / 2;
        ++covered[to];
        if (fine.weight[from] == 0.0) continue;
        ++present[to];
        coarse.data[to] += fine.data[from];
        variance[to] += 1.0 / fine.weight[from];
      }
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (present[i] == 0 || present[i] < covered[i]) {
      coarse.data[i] = 0.0;
      continue;
    }
    coarse.data[i] /= present[i];
    coarse.weight[i] = present[i] * present[i] / variance[i];
  }
  add_model_error(coarse, model_error);
  set_smooth_error(coarse, fine.smooth_error);
  return coarse;
}

std::vector<double> restrict_face(const std::vector<double>& fine, FaceShape fine_shape,
                                  FaceShape coarse_shape, int factor, int patterns) {
  std::vector<double> coarse(coarse_shape.cells() * static_cast<std::size_t>(patterns), 0.0);
  for (int m = 0; m < patterns; ++m) {
    for (int v = 0; v < coarse_shape.nv; ++v) {
      for (int u = 0; u < coarse_shape.nu; ++u) {
        double sum = 0.0;
        int count = 0;
        for (int fv = v * factor; fv < std::min((v + 1) * factor, fine_shape.nv); ++fv) {
          for (int fu = u * factor; fu < std::min((u + 1) * factor, fine_shape.nu); ++fu) {
            sum += fine[(static_cast<std::size_t>(m) * fine_shape.nv + fv) * fine_shape.nu + fu];
            ++count;
          }
        }
        coarse[(static_cast<std::size_t>(m) * coarse_shape.nv + v) * coarse_shape.nu + u] =
            count > 0 ? sum / count : 0.0;
      }
    }
  }
  return coarse;
}

std::vector<double> split_face(const std::vector<double>& coarse, FaceShape coarse_shape,
                               FaceShape fine_shape, int factor, int patterns) {
  std::vector<double> fine;
  fine.reserve(fine_shape.cells() * static_cast<std::size_t>(patterns));
  for (int m = 0; m < patterns; ++m) {
    for (int v = 0; v < fine_shape.nv; ++v) {
      for (int u = 0; u < fine_shape.nu; ++u) {
        fine.push_back(
            coarse[(static_cast<std::size_t>(m) * coarse_shape.nv + v / factor) * coarse_shape.nu +
                   u / factor]);
      }
    }
  }
  return fine;
}

std::vector<double> prolong(const std::vector<double>& coarse, const GridShape& coarse_shape,
                            const GridShape& fine_shape) {
  const AxisStencil sx = axis_stencil(coarse_shape.nx, fine_shape.nx);
  const AxisStencil sy = axis_stencil(coarse_shape.ny, fine_shape.ny);
  const AxisStencil sz = axis_stencil(coarse_shape.nz, fine_shape.nz);
  std::vector<double> fine(fine_shape.cells());
  for (int z = 0; z < fine_shape.nz; ++z) {
    for (int y = 0; y < fine_shape.ny; ++y) {
      for (int x = 0; x < fine_shape.nx; ++x) {
        double sum = 0.0;
        for (int corner = 0; corner < 8; ++corner) {
          const int a = corner & 1;
          const int b = corner >> 1 & 1;
          const int c = corner >> 2;
          sum += sx.weight[x][a] * sy.weight[y][b] * sz.weight[z][c] *
                 coarse[coarse_shape.index(sx.index[x][a], sy.index[y][b], sz.index[z][c])];
        }
        fine[fine_shape.index(x, y, z)] = sum;
      }
    }
  }
  return fine;
}

std::vector<double> restrict_voxels(const std::vector<double>& values, const GridShape& fine,
                                    const GridShape& coarse) {
  std::vector<double> means(coarse.cells(), 0.0);
  std::vector<int> counts(coarse.cells(), 0);
  const int factor = static_cast<int>(std::lround(coarse.voxel_mm / fine.voxel_mm));
  for (int z = 0; z < fine.nz; ++z) {
    for (int y = 0; y < fine.ny; ++y) {
      for (int x = 0; x < fine.nx; ++x) {
        const std::size_t to = coarse.index(x / factor, y / factor, z / factor);
        means[to] += values[fine.index(x, y, z)];
        ++counts[to];
      }
    }
  }
  for (std::size_t i = 0; i < means.size(); ++i) means[i] /= counts[i];
  return means;
}

CoefficientPair restrict_voxels(const CoefficientPair& fields, const GridShape& fine,
                                const GridShape& coarse) {
  if (coarse == fine) return fields;
  return {restrict_voxels(fields.log_kappa, fine, coarse),
          restrict_voxels(fields.log_mu, fine, coarse)};
}

std::vector<double> split_voxels(const std::vector<double>& coarse, const GridShape& coarse_shape,
                                 const GridShape& fine_shape, int factor) {
  std::vector<double> fine(fine_shape.cells());
  for_rows(fine_shape.ny * fine_shape.nz, [&](int row) {
    const int y = row % fine_shape.ny;
    const int z = row / fine_shape.ny;
    const double* from = &coarse[coarse_shape.index(0, y / factor, z / factor)];
    double* to = &fine[fine_shape.index(0, y, z)];
    for (int x = 0; x < fine_shape.nx; ++x) to[x] = from[x / factor];
  });
  return fine;
}

}  // namespace kappamu::inverse

#include "forward/polygrid/polygrid_diffusion.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/dot.h"
#include "core/parallel.h"
#include "core/processor_time.h"
#include "forward/light_entry.h"

namespace kappamu::forward::polygrid {

namespace {

using Eigen::Vector3d;

constexpr int most_points = 4;  ///< along an edge of a cell
/// Of all rows: beyond, all are made anew.
constexpr double most_renewed = 0.5;

Eigen::AlignedBox3d box_of(const CellCorners& corners) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& corner : corners) box.extend(corner);
  return box;
}

/// Means over points of cells, of several media. Media that are placed alike are looked up at the
/// same voxels.
class CellMeans {
 public:
  explicit CellMeans(std::span<const ObjectMedium* const> media) : media_(media) {
    alike_ = std::all_of(media.begin(), media.end(),
                         [&](const ObjectMedium* each) { return each->placed_as(*media[0]); });
    for (int n = 1; n <= most_points; ++n) {
      for (int z = 0; z < n; ++z) {
        for (int y = 0; y < n; ++y) {
          for (int x = 0; x < n; ++x) {
            weights_[at(n)].push_back(shape_functions((Vector3d(x, y, z).array() + 0.5) / n));
          }
        }
      }
    }
  }

  /// means[c]: of medium c.
  void of_cell(const CellCorners& corners, const Eigen::AlignedBox3d& box,
               std::span<Coefficients> means) const {
    std::array<std::size_t, most_points * most_points * most_points> voxels{};
    for (std::size_t c = 0; c < media_.size(); ++c) {
      const ObjectMedium& medium = *media_[c];
      if (medium.homogeneous()) {
        means[c] = medium.smallest();
        continue;
      }
      const double points = std::ceil(box.sizes().maxCoeff() / *medium.voxel_mm());
      const int n = static_cast<int>(std::clamp(points, 1.0, static_cast<double>(most_points)));
      if (c == 0 || !alike_) {
        for (std::size_t k = 0; k < weights_[at(n)].size(); ++k) {
          Vector3d p = Vector3d::Zero();
          for (std::size_t i = 0; i < 8; ++i) p += weights_[at(n)][k][i] * corners[i];
          voxels[k] = medium.voxel_at(p);
        }
      }
      Coefficients sum;
      const std::size_t count = weights_[at(n)].size();
      for (std::size_t k = 0; k < count; ++k) {
        const Coefficients here = medium.of_voxel(voxels[k]);
        sum.kappa += here.kappa;
        sum.mu += here.mu;
      }
      means[c] = {sum.kappa / static_cast<double>(count), sum.mu / static_cast<double>(count)};
    }
  }

 private:
  static std::size_t at(int n) { return static_cast<std::size_t>(n); }

  std::span<const ObjectMedium* const> media_;
  bool alike_ = false;
  /// [n][point] of the cell's corners, for n points along an edge.
  std::array<std::vector<std::array<double, 8>>, most_points + 1> weights_;
};

}  // namespace

std::vector<std::vector<Coefficients>> coefficients_of_cells(
    const Polygrid& grid, std::span<const ObjectMedium* const> media) {
  std::vector<std::vector<Coefficients>> result(media.size(),
                                                std::vector<Coefficients>(grid.cell.size()));
  const CellMeans means(media);
  for_ranges(grid.cell.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<Coefficients> here(media.size());
    for (std::size_t k = begin; k < end; ++k) {
      const CellCorners corners = corners_of(grid, k);
      means.of_cell(corners, box_of(corners), here);
      for (std::size_t c = 0; c < here.size(); ++c) result[c][k] = here[c];
    }
  });
  return result;
}

PolygridDiffusion::PolygridDiffusion(Polygrid grid, const TriangleMesh& mesh,
                                     const Surface& surface, double eta, const std::string& device,
                                     Lights lights)
    : grid_(std::move(grid)),
      constants_(boundary_constants(eta)),
      equations_(grid_, constants_.A),
      hierarchy_(equations_, grid_),
      map_(grid_, mesh, surface),
      solver_(make_linear_solver(equations_, hierarchy_, device, lights)),
      lights_(lights) {
  for (std::size_t k = 0; k < grid_.cell.size(); ++k) {
    longest_cell_ = std::max(longest_cell_, box_of(corners_of(grid_, k)).sizes().maxCoeff());
  }
}

PolygridDiffusion::~PolygridDiffusion() = default;

void PolygridDiffusion::set_media(std::span<const ObjectMedium* const> media) {
  const double start = processor_seconds();
  const bool all = media_.size() != media.size();
  std::vector<char> changed(equations_.unknowns(), 0);
  if (all) {
    of_cell_ = coefficients_of_cells(grid_, media);
  } else {
    std::vector<Eigen::AlignedBox3d> differences(media.size());
    for_rows(static_cast<int>(media.size()), [&](int row) {
      const auto c = static_cast<std::size_t>(row);
      differences[c] = media[c]->difference(media_[c]);
    });
    Eigen::AlignedBox3d region;
    for (const Eigen::AlignedBox3d& difference : differences) region.extend(difference);
    renew_cells(media, region, changed);
  }
  std::vector<int> rows;
  for (std::size_t i = 0; i < changed.size(); ++i) {
    if (changed[i] != 0) rows.push_back(static_cast<int>(i));
  }
  if (all ||
      static_cast<double>(rows.size()) > most_renewed * static_cast<double>(changed.size())) {
    std::vector<MediumValues> values;
    for (const auto& of_cell : of_cell_) values.push_back(equations_.values(of_cell));
    solver_->set_media(std::move(values));
  } else if (!rows.empty()) {
    solver_->change_media(rows, [&](std::size_t c, MediumValues& values) {
      equations_.renew(of_cell_[c], rows, values);
    });
  }
  media_.clear();
  for (const ObjectMedium* medium : media) media_.push_back(*medium);
  seconds_.media = processor_seconds() - start;
}

void PolygridDiffusion::renew_cells(std::span<const ObjectMedium* const> media,
                                    const Eigen::AlignedBox3d& region,
                                    std::vector<char>& row_changed) {
  if (region.isEmpty()) return;
  const CellMeans means(media);
  const std::size_t cells = grid_.cell.size();
  std::vector<char> changed(cells, 0);
  Eigen::AlignedBox3d about(region);  // holds the nodes of cells that meet the region
  about.min().array() -= longest_cell_;
  about.max().array() += longest_cell_;
  for_ranges(cells, [&](std::size_t begin, std::size_t end) {
    std::vector<Coefficients> now(media.size());
    for (std::size_t k = begin; k < end; ++k) {
      if (!about.contains(grid_.node[k])) continue;
      const CellCorners corners = corners_of(grid_, k);
      const Eigen::AlignedBox3d box = box_of(corners);
      if (!region.intersects(box)) continue;
      means.of_cell(corners, box, now);
      for (std::size_t c = 0; c < now.size(); ++c) {
        Coefficients& before = of_cell_[c][k];
        if (now[c].kappa == before.kappa && now[c].mu == before.mu) continue;
        before = now[c];
        changed[k] = 1;
      }
    }
  });
  for (std::size_t k = 0; k < cells; ++k) {
    if (changed[k] == 0) continue;
    for (const int corner : grid_.cell_corners[k])
      row_changed[static_cast<std::size_t>(corner)] = 1;
  }
}

void PolygridDiffusion::add_light(std::span<const ObjectProblem> problems, std::size_t light,
                                  double remainder, std::vector<PolygridAnswer>& answers) {
  const std::size_t lights = problems[0].lights.size();
  std::vector<ChannelBeams> channels;
  for (std::size_t c = 0; c < problems.size(); ++c) {
    Load& load = loads_[c * lights + light];
    load.channel = c;
    load.power.assign(equations_.unknowns(), 0.0);
    channels.push_back({problems[c].lights[light].beams, of_cell_[c], load.power,
                        answers[c].balance[light], &answers[c].leaving[light]});
  }
  const bool keep = lights_ == Lights::moving;
  constexpr std::size_t together = BeamWalks::most_channels;
  std::size_t walks = keep ? light * ((channels.size() + together - 1) / together) : 0;
  for (std::size_t c = 0; c < channels.size(); c += together, walks += keep ? 1 : 0) {
    while (walks_.size() <= walks) {
      walks_.emplace_back(grid_, map_, keep ? BeamWalks::Steps::kept : BeamWalks::Steps::forgotten);
    }
    const std::size_t count = std::min(together, channels.size() - c);
    walks_[walks].add(problems[0], std::span(channels).subspan(c, count), remainder);
  }
  for_rows(static_cast<int>(problems.size()), [&](int row) {
    const auto c = static_cast<std::size_t>(row);
    const std::vector<double>& diffuse = problems[c].lights[light].diffuse;
    if (diffuse.empty()) return;
    const double transmitted = diffuse_transmittance(constants_);
    const double per_incident = constants_.q_per_entering() / (2.0 * constants_.A) * transmitted;
    const double entering = transmitted * map_.add_loads(diffuse, per_incident, channels[c].load);
    channels[c].balance.entering += entering;
    channels[c].balance.exiting += entering_less_q() * entering;
  });
}

std::vector<PolygridAnswer> PolygridDiffusion::solve(std::span<const ObjectProblem> problems,
                                                     const PolygridAccuracy& accuracy) {
  const double start = processor_seconds();
  std::vector<PolygridAnswer> answers(problems.size());
  const std::size_t lights = problems[0].lights.size();
  loads_.resize(problems.size() * lights);
  for (PolygridAnswer& answer : answers) {
    answer.balance.resize(lights);
    answer.leaving.resize(lights);
  }
  for (std::size_t l = 0; l < lights; ++l) {
    add_light(problems, l, accuracy.beam_remainder, answers);
  }
  const double beams = processor_seconds();
  const Stopwatch watch;
  report_ = solver_->solve(loads_, fluence_, accuracy.linear_tolerance, accuracy.most_iterations);
  const double solved = processor_seconds();
  seconds_.solving_elapsed = watch.seconds();

  const double transmitted = diffuse_transmittance(constants_);
  const double per_fluence = 1.0 / (2.0 * constants_.A);
  for (std::size_t c = 0; c < problems.size(); ++c) {
    answers[c].exitance.resize(lights * map_.triangles());
  }
  for_rows(static_cast<int>(problems.size() * lights), [&](int row) {
    const auto at = static_cast<std::size_t>(row), c = at / lights, l = at % lights;
    const ObjectLight& light = problems[c].lights[l];
    ObjectBalance& balance = answers[c].balance[l];
    const auto exitance =
        std::span(answers[c].exitance).subspan(l * map_.triangles(), map_.triangles());
    map_.on_triangles(fluence_[at], exitance);
    for (double& value : exitance) value *= per_fluence;
    balance.exiting += per_fluence * dot(equations_.boundary_share(), fluence_[at]);
    balance.absorbed += dot(solver_->media()[c].absorption, fluence_[at]);
    for (std::size_t t = 0; t < light.diffuse.size(); ++t) {
      exitance[t] += entering_less_q() * transmitted * light.diffuse[t];
    }
  });
  seconds_.beams = beams - start;
  seconds_.solving = solved - beams;
  seconds_.exitance = processor_seconds() - solved;
  return answers;
}

}  // namespace kappamu::forward::polygrid

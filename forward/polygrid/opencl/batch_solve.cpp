#include "forward/polygrid/opencl/batch_solve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/parallel.h"

namespace kappamu::forward::polygrid {

extern const device::KernelSource polygrid_cl;

namespace {

using device::Buffer;
using linear::Place;

/// Of the residual that changed media leave: what little they change of the whole is solved for,
/// too.
constexpr double of_change = 0.05;

/// Rows beyond the last that vectors of 16 numbers may reach.
constexpr std::size_t most_beyond = 16;

constexpr std::size_t most_fresh = 1 << 16;  ///< rows written at once

/// Stretches of rows, each a work-item's. A GPU of 132 multiprocessors starves on a tenth of these,
/// each with ten times the rows; the sums of more of them would take one work-group too long to
/// add.
constexpr std::size_t gpu_runs = 32768, cpu_runs = 64;

std::string number_types(const linear::Numbers& numbers) {
  return std::string("-DREAL=") + (numbers.precision == Precision::single ? "float" : "double") +
         " -DSUM=" + (numbers.double_sums ? "double" : "float");
}

}  // namespace

BatchSolve::BatchSolve(device::Context& context, const linear::Numbers& numbers,
                       const linear::Lanes& of, const DevicePattern& matrix,
                       const std::vector<DeviceLevel>& levels, Lights lights)
    : DeviceLanes(context, numbers, of, static_cast<std::size_t>(matrix.rows),
                  numbers.interleaved ? gpu_runs : cpu_runs, false, FormerAnswers::most + 1),
      matrix_(matrix),
      levels_(levels),
      program_(program(polygrid_cl, number_types(numbers))) {
  const std::size_t media = of.media() * numbers.real_bytes();
  const std::size_t field = width() * numbers.real_bytes();
  const auto zeros = [&](std::size_t count) {
    Buffer made = context.allocate(field_bytes(count));
    context.zero(made, made.bytes());
    return made;
  };
  value_ = context.allocate((matrix.places() + most_beyond) * media);
  for (const DeviceLevel& level : levels) {
    const auto count = static_cast<std::size_t>(level.links.rows);
    links_.push_back(context.allocate((level.links.places() + most_beyond) * media));
    for (auto* each : {&inverse_diagonal_, &level_r_, &level_y_}) each->push_back(zeros(count));
  }
  const auto coarsest = static_cast<std::size_t>(levels.back().links.rows);
  coarsest_ = context.allocate(coarsest * coarsest * media);
  for (Buffer* each : {&b_, &x_, &z_, &p_, &image_}) *each = zeros(rows());
  std::size_t fresh = 0;
  const auto count = [&](const DevicePattern& of_pattern) {
    fresh = std::max(fresh, std::min(of_pattern.pattern.rows(), most_fresh) * of_pattern.slots);
  };
  count(matrix);
  for (const DeviceLevel& level : levels) count(level.links);
  fresh_ = context.allocate(std::max(fresh * media, std::min(rows(), most_fresh) * field));
  fresh_row_ = context.allocate(std::min(rows(), most_fresh) * sizeof(int));
  if (lights == Lights::moving) former_.emplace(context, field_bytes(rows()));
}

template <class Numbers>
void BatchSolve::write_rows(const Buffer& buffer, std::size_t slots, std::span<const int> rows,
                            const Numbers& numbers, bool every_lane) {
  const std::size_t media = every_lane ? width() : lanes().media();
  const auto write_as = [&]<class T>(T, std::span<const int> part, int all) {
    std::vector<T> fresh(part.size() * slots * media, T(0));
    for_ranges(part.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        for (std::size_t lane = 0; lane < media; ++lane) {
          if (lanes().own() && lane >= lanes().channels.size()) break;
          const std::size_t channel = lanes().channels[lanes().own() ? lane : 0];
          T* const row = fresh.data() + k * slots * media + lane;
          numbers(channel, part[k], [&](std::size_t slot, double number) {
            row[slot * media] = static_cast<T>(number);
          });
        }
      }
    });
    context_.write(fresh_, fresh.data(), fresh.size() * sizeof(T));
    context_.write(fresh_row_, part.data(), part.size_bytes());
    if (every_lane) {
      over(part.size(), "take_lanes", fresh_row_, fresh_, buffer);
    } else {
      over(part.size(), "take_rows", all, static_cast<int>(slots), fresh_row_, fresh_, buffer);
    }
  };
  const auto all =
      static_cast<int>((buffer.bytes() / (media * numbers_.real_bytes()) - most_beyond) / slots);
  for (std::size_t begin = 0; begin < rows.size(); begin += most_fresh) {
    const auto part = rows.subspan(begin, std::min(most_fresh, rows.size() - begin));
    if (numbers_.precision == Precision::single) {
      write_as(0.0F, part, all);
    } else {
      write_as(0.0, part, all);
    }
  }
}

void BatchSolve::set_media(const std::vector<MediumValues>& media,
                           const std::vector<ChannelLevels>& levels, std::span<const int> rows) {
  if (former_) former_->forget();
  write_rows(value_, matrix_.slots, rows, [&](std::size_t c, int row, const auto& put) {
    matrix_.for_numbers(media[c].value, row, put);
  });
  std::vector<int> of_level(rows.begin(), rows.end());
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const DevicePattern& links = levels_[l].links;
    if (l > 0) {
      of_level.resize(links.pattern.rows());
      std::iota(of_level.begin(), of_level.end(), 0);
    }
    if (links.slots > 0) {
      write_rows(links_[l], links.slots, of_level, [&](std::size_t c, int row, const auto& put) {
        links.for_numbers(levels[c].graph[l].link, row, put);
      });
    }
    const auto inverse = [&](std::size_t c, int row, const auto& put) {
      put(0, levels[c].inverse_diagonal[l][static_cast<std::size_t>(row)]);
    };
    write_rows(inverse_diagonal_[l], 1, of_level, inverse, true);
  }
  std::vector<const std::vector<double>*> coarsest;
  for (const std::size_t c : lanes().channels) coarsest.push_back(&levels[c].coarsest);
  write_lanes(coarsest_, coarsest, coarsest.front()->size(), lanes().media());
}

void BatchSolve::start(const std::vector<const std::vector<double>*>& starts) {
  const Buffer &r = level_r_[0], &y = level_y_[0];
  begin();
  if (!former_ || former_->size() == 0) {
    write_lanes(z_, starts, rows(), width());
    const Scalars energy = sums(1, "product", matrix_.list, matrix_.step, value_, z_, image_)[0];
    const Scalars none(width(), 0.0);
    write({linear::quotients(dot(b_, z_), energy), none, none, none});
    sum_to(Place::size, "start_from_former", given(), inverse_diagonal_[0], z_, z_, z_, z_, image_,
           image_, image_, image_, b_, x_, r, y);
    return;
  }
  const FormerAnswers& of = *former_;
  const std::vector<Scalars> products = sums(FormerAnswers::most, "products_with_images", b_,
                                             of.image(0), of.image(1), of.image(2), of.image(3));
  const auto times = of.combination({products[0], products[1], products[2], products[3]});
  write({times.begin(), times.end()});
  sum_to(Place::size, "start_from_former", given(), inverse_diagonal_[0], of.answer(0),
         of.answer(1), of.answer(2), of.answer(3), of.image(0), of.image(1), of.image(2),
         of.image(3), b_, x_, r, y);
}

void BatchSolve::direct() {
  if (first_direction_) {
    std::swap(p_, z_);
    first_direction_ = false;
  } else {
    in_runs(rows(), "update_direction", static_cast<int>(Place::along), scalars(), z_, p_);
  }
  sum_to(Place::step, "product", matrix_.list, matrix_.step, value_, p_, image_);
}

void BatchSolve::advance() {
  sum_to(Place::size, "update_solution", scalars(), inverse_diagonal_[0], p_, image_, b_, x_,
         level_r_[0], level_y_[0]);
}

void BatchSolve::solve(const std::vector<Load>& loads, const std::vector<std::size_t>& lights,
                       std::vector<std::vector<double>>& x, linear::CgEnd ends, CgReport& report) {
  std::vector<const std::vector<double>*> powers, starts;
  std::vector<std::vector<double>*> answers;
  for (const std::size_t light : lights) {
    powers.push_back(&loads[light].power);
    starts.push_back(&x[light]);
    answers.push_back(&x[light]);
  }
  write_lanes(b_, powers, rows(), width());
  if (former_ && former_->size() == 0) ends.of_first = of_change;
  first_direction_ = true;
  start(starts);
  // r·z estimates the error's energy, b·x is the answer's.
  linear::CgState at;
  Scalars first;
  linear::Looks looks;
  const auto excess = [&](std::size_t lane) {
    return ends.energy_excess(at.r_z[lane], at.size[lane], first[lane]);
  };
  const int iterations = linear::conjugate_gradients(
      *this, [](int) { return false; },
      [&](int iteration) {
        const bool last = iteration == ends.most_iterations;
        if (!last && !looks.due(iteration)) return false;
        at = look();
        if (iteration == 0) first = at.r_z;
        const double most = linear::largest_excess(width(), excess);
        looks.saw(iteration, most);
        return last || most <= 1.0;
      });
  report.iterations = std::max(report.iterations, iterations);
  for (std::size_t lane = 0; lane < lights.size(); ++lane) {
    const double energy = at.size[lane];
    report.residual[lights[lane]] =
        energy > 0.0 ? std::sqrt(std::max(0.0, at.r_z[lane]) / energy) : 0.0;
    report.converged = report.converged && excess(lane) <= 1.0;
  }
  // z = x + 1 z: the last correction is the answer's, too. What is kept goes without, as its image.
  write({Scalars(width(), 1.0)});
  in_runs(rows(), "update_direction", 0, given(), x_, z_);
  read_lanes(z_, answers);
  if (former_ && iterations > 0) keep(level_r_[0]);
}

void BatchSolve::keep(const Buffer& r) {
  FormerAnswers::Kept& kept = former_->next();
  std::swap(kept.answer, x_);
  const auto other = [&](std::size_t k) -> const Buffer& {
    return &former_->image(k) == &kept.image ? b_ : former_->image(k);
  };
  const std::vector<Scalars> products = sums(FormerAnswers::most + 1, "image_of_answer", b_, r,
                                             other(0), other(1), other(2), other(3), kept.image);
  former_->set_products(products[0], {products[1], products[2], products[3], products[4]});
}

void BatchSolve::precondition() {
  const std::size_t coarsest = levels_.size() - 1;
  const auto rows_of = [&](std::size_t l) {
    return static_cast<std::size_t>(levels_[l].links.rows);
  };
  if (coarsest == 0) {
    over(rows(), "solve_directly", coarsest_, level_r_[0], z_);
    sum_to(Place::r_z, "dot_product", level_r_[0], z_);
    return;
  }
  for (std::size_t l = 0; l < coarsest; ++l) {
    const DeviceLevel& level = levels_[l];
    in_runs(rows_of(l), "left_of_residual", level.links.list, level.links.step, links_[l],
            level_r_[l], level_y_[l], z_);
    over(rows_of(l + 1), "down", level.first_child, level.child, z_, inverse_diagonal_[l + 1],
         level_r_[l + 1], level_y_[l + 1]);
  }
  over(rows_of(coarsest), "direct_to_children", coarsest_, level_r_[coarsest],
       levels_[coarsest - 1].first_child, levels_[coarsest - 1].child, level_y_[coarsest - 1]);
  for (std::size_t l = coarsest - 1; l > 0; --l) {
    const DeviceLevel &level = levels_[l], &finer = levels_[l - 1];
    over(rows_of(l), "up_to_children", level.links.list, level.links.step, links_[l],
         inverse_diagonal_[l], level_r_[l], level_y_[l], finer.first_child, finer.child,
         level_y_[l - 1]);
  }
  sum_to(Place::r_z, "up", levels_[0].links.list, levels_[0].links.step, links_[0],
         inverse_diagonal_[0], level_r_[0], level_y_[0], z_);
}

}  // namespace kappamu::forward::polygrid

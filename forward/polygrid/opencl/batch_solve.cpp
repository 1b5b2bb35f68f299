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
using linear::Lanes;

/// Of the residual that changed media leave: what little they change of the whole is solved for,
/// too.
constexpr double of_change = 0.05;

/// Rows beyond the last that vectors of 16 numbers may reach.
constexpr std::size_t most_beyond = 16;

constexpr std::size_t most_fresh = 1 << 16;  ///< rows written at once

}  // namespace

BatchSolve::BatchSolve(device::Context& context, const Numbers& numbers, const Lanes& lanes,
                       const DevicePattern& matrix, const std::vector<DeviceLevel>& levels,
                       Lights lights)
    : context_(context),
      numbers_(numbers),
      lanes_(lanes),
      matrix_(matrix),
      levels_(levels),
      program_(context.program(polygrid_cl, numbers_.build_options(lanes))) {
  const std::size_t media = lanes.media() * numbers.real_bytes();
  const std::size_t field = lanes.width * numbers.real_bytes();
  const auto zeros = [&](std::size_t rows) {
    Buffer made = context.allocate(field_bytes(rows));
    context.zero(made, made.bytes());
    return made;
  };
  value_ = context.allocate((matrix.places() + most_beyond) * media);
  for (const DeviceLevel& level : levels) {
    const auto rows = static_cast<std::size_t>(level.links.rows);
    links_.push_back(context.allocate((level.links.places() + most_beyond) * media));
    for (auto* each : {&inverse_diagonal_, &level_r_, &level_y_}) each->push_back(zeros(rows));
  }
  const auto coarsest = static_cast<std::size_t>(levels.back().links.rows);
  coarsest_ = context.allocate(coarsest * coarsest * media);
  for (Buffer* each : {&b_, &x_, &z_, &p_, &image_}) *each = zeros(rows());
  runs_ = std::min<std::size_t>(rows(), context.info().kind == device::Kind::gpu ? 4096 : 64);
  partial_ =
      context.allocate((FormerAnswers::most + 1) * runs_ * lanes.width * numbers.sum_bytes());
  scalars_ = context.allocate(FormerAnswers::most * lanes.width * numbers.sum_bytes());
  std::size_t fresh = 0;
  const auto count = [&](const DevicePattern& of) {
    fresh = std::max(fresh, std::min(of.pattern.rows(), most_fresh) * of.slots);
  };
  count(matrix);
  for (const DeviceLevel& level : levels) count(level.links);
  fresh_ = context.allocate(std::max(fresh * media, std::min(rows(), most_fresh) * field));
  fresh_row_ = context.allocate(std::min(rows(), most_fresh) * sizeof(int));
  if (lights == Lights::moving) former_.emplace(context, field_bytes(rows()));
}

template <class Number>
void BatchSolve::write_rows(const Buffer& buffer, std::size_t slots, std::span<const int> rows,
                            const Number& number, bool every_lane) {
  const std::size_t media = every_lane ? lanes_.width : lanes_.media();
  const auto write_as = [&]<class T>(T, std::span<const int> part, int all) {
    std::vector<T> fresh(part.size() * slots * media, T(0));
    for_ranges(part.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        for (std::size_t slot = 0; slot < slots; ++slot) {
          for (std::size_t lane = 0; lane < media; ++lane) {
            if (lanes_.own() && lane >= lanes_.channels.size()) break;
            const std::size_t channel = lanes_.channels[lanes_.own() ? lane : 0];
            fresh[(k * slots + slot) * media + lane] =
                static_cast<T>(number(channel, part[k], slot));
          }
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
  write_rows(value_, matrix_.slots, rows, [&](std::size_t c, int row, std::size_t slot) {
    return matrix_.number(media[c].value, row, slot);
  });
  std::vector<int> of_level(rows.begin(), rows.end());
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const DevicePattern& links = levels_[l].links;
    if (l > 0) {
      of_level.resize(links.pattern.rows());
      std::iota(of_level.begin(), of_level.end(), 0);
    }
    if (links.slots > 0) {
      write_rows(links_[l], links.slots, of_level, [&](std::size_t c, int row, std::size_t slot) {
        return links.number(levels[c].graph[l].link, row, slot);
      });
    }
    const auto inverse = [&](std::size_t c, int row, std::size_t) {
      return levels[c].inverse_diagonal[l][static_cast<std::size_t>(row)];
    };
    write_rows(inverse_diagonal_[l], 1, of_level, inverse, true);
  }
  std::vector<const std::vector<double>*> coarsest;
  for (const std::size_t c : lanes_.channels) coarsest.push_back(&levels[c].coarsest);
  write_lanes(context_, coarsest_, numbers_, coarsest, lanes_.media());
}

void BatchSolve::solve(const std::vector<Load>& loads, const std::vector<std::size_t>& lights,
                       std::vector<std::vector<double>>& x, double tolerance, int most_iterations,
                       CgReport& report) {
  const std::size_t width = lanes_.width;
  std::vector<const std::vector<double>*> powers, starts;
  std::vector<std::vector<double>*> answers;
  for (const std::size_t light : lights) {
    powers.push_back(&loads[light].power);
    starts.push_back(&x[light]);
    answers.push_back(&x[light]);
  }
  write_lanes(context_, b_, numbers_, powers, width);
  const Buffer &r = level_r_[0], &y = level_y_[0];
  const bool changed = former_ && former_->size() == 0;
  Scalars energy, before(width, 0.0), enough(width, 0.0);
  if (former_ && !changed) {
    const FormerAnswers& of = *former_;
    const std::vector<Scalars> products = sums(FormerAnswers::most, "products_with_images", b_,
                                               of.image(0), of.image(1), of.image(2), of.image(3));
    write(of.combination({products[0], products[1], products[2], products[3]}));
    energy = sums(1, "start_from_former", scalars_, inverse_diagonal_[0], of.answer(0),
                  of.answer(1), of.answer(2), of.answer(3), of.image(0), of.image(1), of.image(2),
                  of.image(3), b_, x_, r, y)[0];
  } else {
    write_lanes(context_, x_, numbers_, starts, width);
    over(rows(), "residual", matrix_.list, matrix_.step, value_, inverse_diagonal_[0], b_, x_, r,
         y);
    energy = dot(b_, x_);
  }
  // r·z estimates the error's energy, b·x is the answer's.
  Scalars r_z = cycle();
  Scalars from_change(width, std::numeric_limits<double>::infinity());
  if (changed) {
    for (std::size_t lane = 0; lane < width; ++lane) {
      from_change[lane] = of_change * of_change * r_z[lane];
    }
  }
  const auto done = [&] {
    bool all = true;
    for (std::size_t lane = 0; lane < width; ++lane) {
      const double of_answer = tolerance * tolerance * std::max(0.0, energy[lane]);
      enough[lane] = std::min(of_answer, from_change[lane]);
      all = all && r_z[lane] <= enough[lane];
    }
    return all;
  };
  int iteration = 0;
  for (; iteration < most_iterations && !done(); ++iteration) {
    Scalars along(width, 0.0), step(width, 0.0);
    if (iteration == 0) {
      std::swap(p_, z_);
    } else {
      for (std::size_t lane = 0; lane < width; ++lane) {
        if (before[lane] > 0.0) along[lane] = r_z[lane] / before[lane];
      }
      write(std::array{along});
      in_runs(rows(), "update_direction", scalars_, z_, p_);
    }
    const Scalars p_image = sums(1, "product", matrix_.list, matrix_.step, value_, p_, image_)[0];
    for (std::size_t lane = 0; lane < width; ++lane) {
      if (p_image[lane] > 0.0) step[lane] = r_z[lane] / p_image[lane];
    }
    write(std::array{step});
    energy =
        sums(1, "update_solution", scalars_, inverse_diagonal_[0], p_, image_, b_, x_, r, y)[0];
    before = r_z;
    r_z = cycle();
  }
  done();
  report.iterations = std::max(report.iterations, iteration);
  for (std::size_t lane = 0; lane < lights.size(); ++lane) {
    report.residual[lights[lane]] =
        energy[lane] > 0.0 ? std::sqrt(std::max(0.0, r_z[lane]) / energy[lane]) : 0.0;
    report.converged = report.converged && r_z[lane] <= enough[lane];
  }
  // z = x + 1 z: the last correction is the answer's, too. What is kept goes without, as its image.
  write(std::array{Scalars(width, 1.0)});
  in_runs(rows(), "update_direction", scalars_, x_, z_);
  read_lanes(context_, z_, numbers_, answers, width);
  if (former_ && iteration > 0) keep(r);
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

Scalars BatchSolve::cycle() {
  const std::size_t coarsest = levels_.size() - 1;
  const auto rows_of = [&](std::size_t l) {
    return static_cast<std::size_t>(levels_[l].links.rows);
  };
  if (coarsest == 0) {
    over(rows(), "solve_directly", coarsest_, level_r_[0], z_);
    return dot(level_r_[0], z_);
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
  return sums(1, "up", levels_[0].links.list, levels_[0].links.step, links_[0],
              inverse_diagonal_[0], level_r_[0], level_y_[0], z_)[0];
}

}  // namespace kappamu::forward::polygrid

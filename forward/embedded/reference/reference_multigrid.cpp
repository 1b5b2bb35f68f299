#include "forward/embedded/reference/reference_multigrid.h"

#include <algorithm>
#include <cmath>

#include "forward/embedded/reference/row_levels.h"

namespace kappamu::forward::embedded {

namespace {

template <int lanes>
class VCycle {
 public:
  explicit VCycle(const RowLevels& rows) : rows_(rows) {
    for (const Level& level : rows.from) {
      const std::size_t size = level.space.unknowns() * lanes;
      work_.push_back({std::vector<float>(size), std::vector<float>(size), std::vector<float>(size),
                       std::vector<float>(size)});
    }
  }

  /// The finest level's residual, to be filled before run().
  std::vector<float>& residual() { return work_[0].r; }
  const std::vector<float>& run() {
    cycle(0);
    return work_[0].x;
  }

 private:
  struct Work {
    std::vector<float> r, x, z, next;  ///< residual, correction, step, next step
  };

  /// Turns the residual r into the correction x; r is used up.
  void cycle(std::size_t l) {
    Work& w = work_[l];
    if (l + 1 == work_.size()) {
      solve_directly(w);
      return;
    }
    const RowLevel& level = rows_.level[l];
    const std::vector<float>& inverse_scale = rows_.from[l].inverse_scale[rows_.channel];
    Work& coarse = work_[l + 1];
    smooth(level, inverse_scale, w, Start::zero);
    subtract_product(level, w);
    for_products<lanes>(level.restriction, w.r.data(), [&](std::size_t row, const auto& sum) {
      std::copy(sum.begin(), sum.end(),
                coarse.r.begin() + static_cast<std::ptrdiff_t>(row * lanes));
    });
    cycle(l + 1);
    for_products<lanes>(level.interpolation, coarse.x.data(),
                        [&](std::size_t row, const auto& sum) {
                          for (std::size_t lane = 0; lane < lanes; ++lane) {
                            w.z[row * lanes + lane] = sum[lane];
                            w.x[row * lanes + lane] += sum[lane];
                          }
                        });
    subtract_product(level, w);
    smooth(level, inverse_scale, w, Start::given);
  }

  /// r −= A z.
  void subtract_product(const RowLevel& level, Work& w) {
    for_products<lanes>(level.matrix, w.z.data(), [&](std::size_t row, const auto& sum) {
      for (std::size_t lane = 0; lane < lanes; ++lane) w.r[row * lanes + lane] -= sum[lane];
    });
  }

  /// Adds the smoother's steps to x. The last step stays in z, not yet
  /// subtracted from r.
  void smooth(const RowLevel& level, const std::vector<float>& inverse_scale, Work& w,
              Start start) {
    for_row_ranges(level.matrix.rows(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t row = begin; row < end; ++row) {
        const float scale = smoothing_step(1).gain * inverse_scale[row];
        for (std::size_t i = row * lanes; i < (row + 1) * lanes; ++i) {
          w.z[i] = scale * w.r[i];
          w.x[i] = start == Start::zero ? w.z[i] : w.x[i] + w.z[i];
        }
      }
    });
    for (int k = 2; k <= smoothing_degree(level.matrix.rows()); ++k) {
      const auto [keep, gain] = smoothing_step(k);
      for_products<lanes>(level.matrix, w.z.data(), [&](std::size_t row, const auto& sum) {
        const float scale = gain * inverse_scale[row];
        for (std::size_t lane = 0; lane < lanes; ++lane) {
          const std::size_t i = row * lanes + lane;
          w.r[i] -= sum[lane];
          w.next[i] = keep * w.z[i] + scale * w.r[i];
          w.x[i] += w.next[i];
        }
      });
      w.z.swap(w.next);
    }
  }

  void solve_directly(Work& w) {
    const auto rows = static_cast<Eigen::Index>(w.r.size() / lanes);
    using Map = Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, lanes,
                                         lanes == 1 ? Eigen::ColMajor : Eigen::RowMajor>>;
    const Eigen::MatrixXd solution =
        rows_.coarsest * Map(w.r.data(), rows, lanes).template cast<double>();
    Map(w.x.data(), rows, lanes) = solution.cast<float>();
  }

  const RowLevels& rows_;
  std::vector<Work> work_;
};

template <int lanes>
using Sums = std::array<double, lanes>;

/// Σ a·b per lane; the same bits on any number of cores.
template <int lanes, class A, class B>
Sums<lanes> dot(const std::vector<A>& a, const std::vector<B>& b) {
  const std::size_t rows = a.size() / lanes;
  std::vector<Sums<lanes>> partial(pieces(rows), Sums<lanes>{});
  for_pieces(rows, [&](std::size_t piece, std::size_t begin, std::size_t end) {
    Sums<lanes> sum{};
    for (std::size_t row = begin; row < end; ++row) {
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        sum[lane] +=
            static_cast<double>(a[row * lanes + lane]) * static_cast<double>(b[row * lanes + lane]);
      }
    }
    partial[piece] = sum;
  });
  Sums<lanes> total{};
  for (const Sums<lanes>& sum : partial) {
    for (std::size_t lane = 0; lane < lanes; ++lane) total[lane] += sum[lane];
  }
  return total;
}

/// Adds to x the constant that makes the residual sum to zero; the residual follows.
template <int lanes>
void balance(const SparseRows<double>& matrix, std::vector<double>& x, std::vector<double>& r) {
  const std::vector<double> ones(x.size(), 1.0);
  std::vector<double> image(x.size());
  for_products<lanes>(matrix, ones.data(), [&](std::size_t row, const auto& sum) {
    std::copy(sum.begin(), sum.end(), image.begin() + static_cast<std::ptrdiff_t>(row * lanes));
  });
  const Sums<lanes> missing = dot<lanes>(r, ones), whole = dot<lanes>(image, ones);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double shift = missing[i % lanes] / whole[i % lanes];
    x[i] += shift;
    r[i] -= shift * image[i];
  }
}

template <int lanes>
void solve_lanes(const RowLevels& rows_of, const std::vector<Load>& loads,
                 const std::vector<std::size_t>& lights, std::size_t first,
                 std::vector<std::vector<double>>& solutions, const CgEnd& ends, CgReport& report) {
  const std::size_t used = std::min<std::size_t>(lanes, lights.size() - first);
  const std::size_t rows = rows_of.matrix.rows();
  std::vector<double> r(rows * lanes, 0.0), x(rows * lanes, 0.0), p(rows * lanes, 0.0),
      image(rows * lanes);
  const auto multiply = [&](const std::vector<double>& by) {
    for_products<lanes>(rows_of.matrix, by.data(), [&](std::size_t row, const auto& sum) {
      std::copy(sum.begin(), sum.end(), image.begin() + static_cast<std::ptrdiff_t>(row * lanes));
    });
  };
  for (std::size_t lane = 0; lane < used; ++lane) {
    const std::vector<double>& power = loads[lights[first + lane]].power;
    const std::vector<double>& start = solutions[lights[first + lane]];
    for (std::size_t row = 0; row < rows; ++row) r[row * lanes + lane] = power[row];
    for (std::size_t row = 0; row < start.size(); ++row) x[row * lanes + lane] = start[row];
  }
  const Sums<lanes> b_b = dot<lanes>(r, r);
  multiply(x);
  for (std::size_t i = 0; i < r.size(); ++i) r[i] -= image[i];
  VCycle<lanes> cycle(rows_of);
  Sums<lanes> r_z_before{}, r_z{}, r_r = dot<lanes>(r, r);
  std::array<bool, lanes> reached{};
  const auto done = [&] {
    for (std::size_t lane = 0; lane < used; ++lane) {
      reached[lane] =
          ends.reached(lights[first + lane], r_r[lane], b_b[lane], r_z[lane], r_z_before[lane]);
    }
    return std::all_of(reached.begin(), reached.begin() + used, [](bool is) { return is; });
  };
  int iteration = 0;
  for (; !done() && iteration < ends.most_iterations; ++iteration) {
    r_z_before = r_z;
    // Scaled to one, so that single precision neither overflows nor underflows.
    Sums<lanes> size{};
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      size[lane] = r_r[lane] > 0.0 ? std::sqrt(r_r[lane]) : 1.0;
    }
    for_row_ranges(rows, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin * lanes; i < end * lanes; ++i) {
        cycle.residual()[i] = static_cast<float>(r[i] / size[i % lanes]);
      }
    });
    const std::vector<float>& z = cycle.run();
    Sums<lanes> along{};
    r_z = dot<lanes>(r, z);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      r_z[lane] *= size[lane];
      along[lane] = r_z_before[lane] > 0.0 ? r_z[lane] / r_z_before[lane] : 0.0;
    }
    for_row_ranges(rows, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin * lanes; i < end * lanes; ++i) {
        p[i] = size[i % lanes] * static_cast<double>(z[i]) + along[i % lanes] * p[i];
      }
    });
    multiply(p);
    const Sums<lanes> p_image = dot<lanes>(p, image);
    for_row_ranges(rows, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin * lanes; i < end * lanes; ++i) {
        const std::size_t lane = i % lanes;
        const double step = p_image[lane] > 0.0 ? r_z[lane] / p_image[lane] : 0.0;
        x[i] += step * p[i];
        r[i] -= step * image[i];
      }
    });
    r_r = dot<lanes>(r, r);
  }
  balance<lanes>(rows_of.matrix, x, r);
  r_r = dot<lanes>(r, r);
  report.iterations = std::max(report.iterations, iteration);
  for (std::size_t lane = 0; lane < used; ++lane) {
    double& residual = report.residual[lights[first + lane]];
    residual = b_b[lane] > 0.0 ? std::sqrt(r_r[lane] / b_b[lane]) : 0.0;
    report.converged = report.converged && reached[lane];
    std::vector<double>& mine = solutions[lights[first + lane]];
    mine.resize(rows);
    for (std::size_t row = 0; row < rows; ++row) mine[row] = x[row * lanes + lane];
  }
}

class ReferenceMultigrid final : public LinearSolver {
 public:
  explicit ReferenceMultigrid(const Levels& levels) : levels_(levels) {}

  CgReport solve(const std::vector<Load>& b, std::vector<std::vector<double>>& x, const CgEnd& ends,
                 std::size_t level) override {
    CgReport report;
    report.residual.resize(b.size());
    x.resize(b.size());
    for (std::size_t channel = 0; channel < levels_.channels(); ++channel) {
      std::vector<std::size_t> lights;
      for (std::size_t l = 0; l < b.size(); ++l) {
        if (b[l].channel == channel) lights.push_back(l);
      }
      if (lights.empty()) continue;
      const RowLevels rows = make_row_levels(levels_, channel, level);
      for (std::size_t first = 0; first < lights.size();) {
        const std::size_t left = lights.size() - first;
        const auto batch = [&]<int lanes>() {
          solve_lanes<lanes>(rows, b, lights, first, x, ends, report);
          first += std::min<std::size_t>(lanes, left);
        };
        if (left > 4) {
          batch.template operator()<8>();
        } else if (left > 2) {
          batch.template operator()<4>();
        } else if (left > 1) {
          batch.template operator()<2>();
        } else {
          batch.template operator()<1>();
        }
      }
    }
    return report;
  }

 private:
  const Levels& levels_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_reference_multigrid(const Levels& levels) {
  return std::make_unique<ReferenceMultigrid>(levels);
}

}  // namespace kappamu::forward::embedded

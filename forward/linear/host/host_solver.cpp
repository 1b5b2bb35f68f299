#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "forward/linear/batches.h"
#include "forward/linear/conjugate_gradients.h"

namespace kappamu::forward::linear {

namespace {

/// Work of a V-cycle on the levels from one on, all of the same lanes.
template <std::size_t lanes, bool own>
class HostCycle {
 public:
  HostCycle(const RowLevels& levels, std::size_t first)
      : levels_(levels), first_(first), work_(levels.level.size()) {
    for (std::size_t l = first; l < work_.size(); ++l) {
      const std::size_t size = levels.level[l].rows * lanes;
      work_[l] = {std::vector<float>(size), std::vector<float>(size), std::vector<float>(size),
                  std::vector<float>(size)};
    }
  }

  /// The finest level's residual, to be filled before run().
  std::vector<float>& residual() { return work_[first_].r; }
  const std::vector<float>& run() {
    v_cycle(*this, levels_, first_);
    return work_[first_].x;
  }

  void smooth_first(std::size_t l, Start start) {
    Work& w = work_[l];
    const float gain = smoothing_step(1).gain;
    for_ranges(levels_.level[l].rows, [&](std::size_t begin, std::size_t end) {
      for (std::size_t row = begin; row < end; ++row) {
        for (std::size_t lane = 0; lane < lanes; ++lane) {
          const std::size_t i = row * lanes + lane;
          w.z[i] = gain * inverse_scale(l, row, lane) * w.r[i];
          w.x[i] = start == Start::zero ? w.z[i] : w.x[i] + w.z[i];
        }
      }
    });
  }
  void smooth_next(std::size_t l, int k) {
    Work& w = work_[l];
    const auto [keep, gain] = smoothing_step(k);
    products(levels_.level[l].matrix, w.z, [&](std::size_t row, const auto& sum) {
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        const std::size_t i = row * lanes + lane;
        w.r[i] -= sum[lane];
        w.next[i] = keep * w.z[i] + gain * inverse_scale(l, row, lane) * w.r[i];
        w.x[i] += w.next[i];
      }
    });
    w.z.swap(w.next);
  }
  void subtract_product(std::size_t l) {
    Work& w = work_[l];
    products(levels_.level[l].matrix, w.z, [&](std::size_t row, const auto& sum) {
      for (std::size_t lane = 0; lane < lanes; ++lane) w.r[row * lanes + lane] -= sum[lane];
    });
  }
  void restrict_to(std::size_t l) {
    Work& w = work_[l];
    for_products<lanes, false>(levels_.level[l - 1].restriction, work_[l - 1].r.data(),
                               [&](std::size_t row, const auto& sum) {
                                 std::copy(sum.begin(), sum.end(), w.r.data() + row * lanes);
                               });
  }
  void prolong_to(std::size_t l) {
    Work& w = work_[l];
    for_products<lanes, false>(levels_.level[l].interpolation, work_[l + 1].x.data(),
                               [&](std::size_t row, const auto& sum) {
                                 for (std::size_t lane = 0; lane < lanes; ++lane) {
                                   w.z[row * lanes + lane] = sum[lane];
                                   w.x[row * lanes + lane] += sum[lane];
                                 }
                               });
  }
  void solve_directly(std::size_t l) {
    Work& w = work_[l];
    const std::size_t rows = levels_.level[l].rows;
    const float* inverse = levels_.coarsest.data();
    for (std::size_t row = 0; row < rows; ++row) {
      std::array<double, lanes> sum{};
      for (std::size_t k = 0; k < rows; ++k) {
        const float* value = inverse + (row * rows + k) * (own ? lanes : 1);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
          sum[lane] += static_cast<double>(value[own ? lane : 0]) *
                       static_cast<double>(w.r[k * lanes + lane]);
        }
      }
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        w.x[row * lanes + lane] = static_cast<float>(sum[lane]);
      }
    }
  }

 private:
  struct Work {
    std::vector<float> r, x, z, next;  ///< residual, correction, step, next step
  };

  float inverse_scale(std::size_t l, std::size_t row, std::size_t lane) const {
    return levels_.level[l].inverse_scale[own ? row * lanes + lane : row];
  }
  template <class Use>
  void products(const RowMatrix<float>& matrix, const std::vector<float>& x, const Use& use) const {
    for_products<lanes, own>(matrix, x.data(), use);
  }

  const RowLevels& levels_;
  std::size_t first_;
  std::vector<Work> work_;
};

/// Fields of a batch; what solve_batch() asks for.
template <std::size_t lanes, bool own>
class HostSystem {
 public:
  HostSystem(const RowLevels& levels, std::size_t level)
      : equations_(levels.level[level].equations),
        cycle_(levels, level),
        r_(equations_.rows() * lanes, 0.0),
        x_(r_),
        p_(r_),
        q_(r_) {}

  static constexpr bool looks_are_free = true;

  Scalars start(const std::vector<Load>& b, const std::vector<std::vector<double>>& x,
                const std::vector<std::size_t>& lights) {
    for (std::size_t lane = 0; lane < lights.size(); ++lane) {
      put(b[lights[lane]].power, lane, r_);
      put(x[lights[lane]], lane, x_);
    }
    const Scalars b_b = dot(r_, r_);
    multiply(x_);
    for_ranges(r_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) r_[i] -= q_[i];
    });
    at_ = {dot(r_, r_), Scalars(lanes, 0.0), Scalars(lanes, 0.0)};
    return b_b;
  }
  const CgState& look() const { return at_; }
  void precondition() {
    // Scaled to one, so that single precision neither overflows nor underflows.
    std::array<double, lanes> size{};
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      size[lane] = at_.size[lane] > 0.0 ? std::sqrt(at_.size[lane]) : 1.0;
    }
    std::vector<float>& scaled = cycle_.residual();
    for_lanes([&](std::size_t i, std::size_t lane) {
      scaled[i] = static_cast<float>(r_[i] / size[lane]);
    });
    z_ = &cycle_.run();
    std::copy(size.begin(), size.end(), size_.begin());
    Scalars r_z = dot(r_, *z_);
    for (std::size_t lane = 0; lane < lanes; ++lane) r_z[lane] *= size[lane];
    at_.before = std::exchange(at_.r_z, r_z);
  }
  void direct() {
    const Scalars along = quotients(at_.r_z, at_.before);
    for_lanes([&](std::size_t i, std::size_t lane) {
      p_[i] = size_[lane] * static_cast<double>((*z_)[i]) + along[lane] * p_[i];
    });
    multiply(p_);
    step_ = quotients(at_.r_z, dot(p_, q_));
  }
  void advance() {
    for_lanes([&](std::size_t i, std::size_t lane) {
      x_[i] += step_[lane] * p_[i];
      r_[i] -= step_[lane] * q_[i];
    });
    at_.size = dot(r_, r_);
  }
  Scalars add_constant() {
    std::fill(p_.begin(), p_.end(), 1.0);
    multiply(p_);
    step_ = quotients(dot(r_, p_), dot(p_, q_));
    advance();
    return at_.size;
  }
  void take(std::vector<std::vector<double>>& x, const std::vector<std::size_t>& lights) const {
    for (std::size_t lane = 0; lane < lights.size(); ++lane) {
      std::vector<double>& mine = x[lights[lane]];
      mine.resize(equations_.rows());
      for (std::size_t row = 0; row < mine.size(); ++row) mine[row] = x_[row * lanes + lane];
    }
  }

 private:
  static void put(const std::vector<double>& field, std::size_t lane, std::vector<double>& to) {
    for (std::size_t row = 0; row < field.size(); ++row) to[row * lanes + lane] = field[row];
  }
  template <class Use>
  void for_lanes(const Use& use) const {
    for_ranges(equations_.rows(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t row = begin; row < end; ++row) {
        for (std::size_t lane = 0; lane < lanes; ++lane) use(row * lanes + lane, lane);
      }
    });
  }
  /// q = A v.
  void multiply(const std::vector<double>& v) {
    for_products<lanes, own>(equations_, v.data(), [&](std::size_t row, const auto& sum) {
      std::copy(sum.begin(), sum.end(), q_.data() + row * lanes);
    });
  }
  /// Σ a·b per lane; the same bits on any number of cores.
  template <class B>
  static Scalars dot(const std::vector<double>& a, const std::vector<B>& b) {
    const std::size_t rows = a.size() / lanes;
    std::vector<std::array<double, lanes>> partial(pieces(rows));
    for_pieces(rows, [&](std::size_t piece, std::size_t begin, std::size_t end) {
      std::array<double, lanes> sum{};
      for (std::size_t row = begin; row < end; ++row) {
        for (std::size_t lane = 0; lane < lanes; ++lane) {
          sum[lane] += a[row * lanes + lane] * static_cast<double>(b[row * lanes + lane]);
        }
      }
      partial[piece] = sum;
    });
    Scalars total(lanes, 0.0);
    for (const auto& sum : partial) {
      for (std::size_t lane = 0; lane < lanes; ++lane) total[lane] += sum[lane];
    }
    return total;
  }

  const RowMatrix<double>& equations_;
  HostCycle<lanes, own> cycle_;
  std::vector<double> r_, x_, p_, q_;
  const std::vector<float>* z_ = nullptr;  ///< of the residual of length one
  std::array<double, lanes> size_{};       ///< the residual's length
  CgState at_;
  Scalars step_;
};

class HostSolver final : public BatchSolver {
 public:
  using BatchSolver::BatchSolver;

 private:
  void solve_batch_on(std::size_t level, const std::vector<Load>& b, const Batch& batch,
                      std::vector<std::vector<double>>& x, const CgEnd& ends,
                      CgReport& report) override {
    const auto with = [&]<std::size_t lanes, bool own>() {
      HostSystem<lanes, own> system(levels(), level);
      solve_batch(system, b, batch.lights, x, ends, report);
    };
    const auto of_width = [&]<std::size_t lanes>() {
      batch.lanes.own() ? with.template operator()<lanes, true>()
                        : with.template operator()<lanes, false>();
    };
    switch (batch.lanes.width) {
      case 1:
        return with.template operator()<1, false>();
      case 2:
        return of_width.template operator()<2>();
      case 4:
        return of_width.template operator()<4>();
      default:
        return of_width.template operator()<8>();
    }
  }
};

}  // namespace

std::unique_ptr<LinearSolver> make_host_solver(Assembly assembly) {
  return std::make_unique<HostSolver>(std::move(assembly));
}

}  // namespace kappamu::forward::linear

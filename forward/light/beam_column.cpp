#include "forward/light/beam_column.h"

#include <cmath>

namespace kappamu::forward {

void BeamColumn::set(std::span<const double> optical_thickness) {
  const std::size_t cells = optical_thickness.size();
  share_.resize(cells);
  away_.resize(cells + 1);
  back_.resize(cells + 1);
  double passes = 1.0;
  for (std::size_t k = 0; k < cells; ++k) {
    // expm1 keeps thin cells accurate, where the two exponentials nearly cancel.
    share_[k] = -std::expm1(-optical_thickness[k]);
    passes *= 1.0 - share_[k];
  }
  const double round_trip = reflectance_ * passes;
  away_.front() = 1.0 / (1.0 - round_trip * round_trip);
  back_.back() = round_trip * away_.front();
  series_ = 2.0 * round_trip * back_.back();
  for (std::size_t k = 0; k < cells; ++k) away_[k + 1] = away_[k] * (1.0 - share_[k]);
  for (std::size_t k = cells; k-- > 0;) back_[k] = back_[k + 1] * (1.0 - share_[k]);
}

void BeamColumn::change(std::span<const double> of_thickness, std::span<double> of_collided) const {
  double passage = 0.0;
  for (const double x : of_thickness) passage += x;
  double above = 0.0;
  for (std::size_t k = 0; k < share_.size(); ++k) {
    const double x = of_thickness[k], below = passage - above - x;
    const double away = above + series_ * passage, back = below + (1.0 + series_) * passage;
    of_collided[k] = (1.0 - share_[k]) * (away_[k] + back_[k + 1]) * x -
                     share_[k] * (away_[k] * away + back_[k + 1] * back);
    above += x;
  }
}

void BeamColumn::gradient(std::span<const double> weight, std::span<double> by_thickness) const {
  const std::size_t cells = share_.size();
  double away = 0.0, back = 0.0;  // Σ of the weighted collisions behind cell k
  for (std::size_t k = cells; k-- > 0;) {
    by_thickness[k] = (1.0 - share_[k]) * (away_[k] + back_[k + 1]) * weight[k] - away;
    away += weight[k] * away_[k] * share_[k];
    back += weight[k] * back_[k + 1] * share_[k];
  }
  double before = series_ * (away + back) + back;
  for (std::size_t k = 0; k < cells; ++k) {
    by_thickness[k] -= before;
    before += weight[k] * back_[k + 1] * share_[k];
  }
}

}  // namespace kappamu::forward

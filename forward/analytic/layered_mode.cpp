#include "forward/analytic/layered_mode.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.h"
#include "forward/light/beam_column.h"

namespace kappamu::forward {

namespace {

/// ∫₀^d e^(−a z) dz, a >= 0.
double decay_integral(double a, double d) {
  return a * d == 0.0 ? d : -std::expm1(-a * d) / a;
}

/// ∫₀^d e^(−a z) z/d dz, a >= 0.
double ramp_integral(double a, double d) {
  const double t = a * d;
  constexpr double few_digits_left = 1e-2;  // the closed form loses eps/t², the series t⁵/840
  if (t < few_digits_left) {
    return d * (1.0 / 2.0 - t * (1.0 / 3.0 - t * (1.0 / 8.0 - t * (1.0 / 30.0 - t / 144.0))));
  }
  return (-std::expm1(-t) - t * std::exp(-t)) / (a * t);
}

/// Below this γd a layer's closed forms lose more digits, eps/γd, than their series (γd)².
constexpr double straight_below = 1e-6;

void validate(std::span<const Layer> layers, double robin_A, const ModeSource& source) {
  if (layers.empty()) throw InputError("layers: at least one is needed");
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const Layer& layer = layers[i];
    const bool last = i + 1 == layers.size();
    const bool valid = std::isfinite(layer.kappa) && layer.kappa > 0.0 && std::isfinite(layer.mu) &&
                       layer.mu >= 0.0 && layer.thickness > 0.0 &&
                       (std::isfinite(layer.thickness) || last);
    if (!valid) {
      throw InputError("layers[" + std::to_string(i) +
                       "]: kappa and thickness must be positive, mu not negative, and only the "
                       "last layer may be infinitely thick");
    }
  }
  if (!(robin_A > 0.0 && source.wavenumber_squared >= 0.0 && source.reflectance >= 0.0 &&
        source.reflectance < 1.0)) {
    throw InputError(
        "layers: A must be positive, the squared wavenumber not negative and the reflectance from "
        "0 to below 1");
  }
}

}  // namespace

bool LayeredMode::Piece::straight() const {
  return std::isfinite(thickness) && decay * thickness < straight_below;
}

double LayeredMode::Piece::same_end() const {
  if (std::isinf(thickness)) return kappa * decay;
  if (straight()) return kappa / thickness + kappa * decay * decay * thickness / 3.0;
  return kappa * decay / std::tanh(decay * thickness);
}

double LayeredMode::Piece::cross() const {
  if (std::isinf(thickness)) return 0.0;
  if (straight()) return kappa / thickness - kappa * decay * decay * thickness / 6.0;
  return 2.0 * kappa * decay * std::exp(-decay * thickness) / -std::expm1(-2.0 * decay * thickness);
}

// With w = sinh γ(d−z) / sinh γd, the fluence of unit value at the top and 0 at the bottom, Green's
// identity gives the flux through the top as ∫ S w dz; likewise at the bottom. Written with falling
// exponentials only; w = 1 − z/d where the layer is straight.
std::array<double, 2> LayeredMode::Piece::source_flux() const {
  double in = 0.0, out = 0.0;  // per S where it comes in: through that end, and the other
  if (std::isinf(thickness)) {
    in = decay_integral(extinction + decay, thickness);
  } else if (straight()) {
    out = ramp_integral(extinction, thickness);
    in = decay_integral(extinction, thickness) - out;
  } else {
    const double sum = decay_integral(extinction + decay, thickness);
    const double difference = std::exp(-std::min(decay, extinction) * thickness) *
                              decay_integral(std::abs(extinction - decay), thickness);
    const double across = std::exp(-decay * thickness);
    const double scale = -std::expm1(-2.0 * decay * thickness);
    in = (sum - across * difference) / scale;
    out = (difference - across * sum) / scale;
  }
  return {falling * in + rising * out, falling * out + rising * in};
}

LayeredMode::Piece LayeredMode::Piece::part(double from, double to) const {
  Piece piece = *this;
  piece.falling = falling * std::exp(-extinction * from);
  if (rising > 0.0) piece.rising = rising * std::exp(-extinction * (thickness - to));
  piece.thickness = to - from;
  return piece;
}

LayeredMode::LayeredMode(std::span<const Layer> layers, double robin_A, const ModeSource& source)
    : robin_A_(robin_A), q_(source.q) {
  validate(layers, robin_A, source);
  std::vector<double> depth;
  for (const Layer& layer : layers) depth.push_back(layer.thickness / (3.0 * layer.kappa));
  BeamColumn beam(source.reflectance);
  beam.set(depth);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const Layer& layer = layers[i];
    Piece piece{};
    piece.kappa = layer.kappa;
    piece.thickness = layer.thickness;
    piece.extinction = 1.0 / (3.0 * layer.kappa);
    piece.decay = std::sqrt(layer.mu / layer.kappa + source.wavenumber_squared);
    const double scattering = std::max(0.0, piece.extinction - layer.mu) * source.beam;
    piece.falling = scattering * beam.away(i);
    piece.rising = scattering * beam.back(i);
    pieces_.push_back(piece);
  }
  unscattered_near_ = source.beam * beam.leaves_near();
  unscattered_far_ = source.beam * beam.leaves_far();

  // Elimination from the lit surface down (Thomas), then back.
  const double robin = 1.0 / (2.0 * robin_A_);
  const std::size_t n = pieces_.size();
  std::vector<double> diagonal(n + 1, 0.0);
  value_.assign(n + 1, 0.0);
  diagonal.front() = robin;
  value_.front() = robin * q_;
  diagonal.back() += std::isinf(layers.back().thickness) ? 1.0 : robin;  // φ(∞) = 0 stands alone
  for (std::size_t i = 0; i < n; ++i) {
    const Piece& piece = pieces_[i];
    const auto [to_top, to_bottom] = piece.source_flux();
    diagonal[i] += piece.same_end();
    value_[i] += to_top;
    if (std::isinf(piece.thickness)) continue;
    const double cross = piece.cross();
    diagonal[i + 1] += piece.same_end() - cross * cross / diagonal[i];
    value_[i + 1] += to_bottom + cross / diagonal[i] * value_[i];
  }
  value_[n] /= diagonal[n];
  for (std::size_t i = n; i-- > 0;) {
    value_[i] = (value_[i] + pieces_[i].cross() * value_[i + 1]) / diagonal[i];
  }
}

double LayeredMode::fluence(double z) const {
  check(z >= 0.0, "fluence: z lies before the stack");
  double top = 0.0;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    const double from = z - top, left = piece.thickness - from;
    top += piece.thickness;
    if (left < 0.0) continue;
    if (from <= 0.0) return value_[i];
    if (left == 0.0) return value_[i + 1];
    // z as one more interface.
    const Piece above = piece.part(0.0, from), below = piece.part(from, piece.thickness);
    return (above.cross() * value_[i] + below.cross() * value_[i + 1] + above.source_flux()[1] +
            below.source_flux()[0]) /
           (above.same_end() + below.same_end());
  }
  return value_.back();
}

double LayeredMode::flux_out_near() const {
  return (value_.front() - q_) / (2.0 * robin_A_);
}

double LayeredMode::flux_out_far() const {
  return std::isinf(pieces_.back().thickness) ? 0.0 : value_.back() / (2.0 * robin_A_);
}

double LayeredMode::scattered() const {
  double sum = 0.0;
  for (const Piece& piece : pieces_) {
    sum += (piece.falling + piece.rising) * decay_integral(piece.extinction, piece.thickness);
  }
  return sum;
}

}  // namespace kappamu::forward

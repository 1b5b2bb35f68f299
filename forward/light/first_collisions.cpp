#include "forward/light/first_collisions.h"

#include <algorithm>
#include <cstring>

#include "core/numbers/widest.h"

namespace kappamu::forward {

namespace {

typedef double Lanes __attribute__((vector_size(beam_lanes * sizeof(double))));  // NOLINT

/// e^(−depth), and 1 less it.
struct Beer {
  Lanes passes, collides;
};

[[gnu::always_inline]] inline void beer(const Lanes& depth, Beer& result) {
  // e^(−depth) = 2^(−k) e^(−r), e^(−r) − 1 by its series. `shift` leaves k in the last bits.
  constexpr double per_ln2 = 1.4426950408889634, shift = 6755399441055744.0;
  constexpr double ln2_high = 0.6931471803691238, ln2_low = 1.9082149292705877e-10;
  const Lanes shifted = depth * per_ln2 + shift, k = shifted - shift;
  const Lanes r = (depth - k * ln2_high) - k * ln2_low;
  typedef long long Bits __attribute__((vector_size(sizeof(Lanes))));  // NOLINT
  Bits bits;
  std::memcpy(&bits, &shifted, sizeof bits);
  bits = (1023 - (bits & 0xffff)) << 52;
  Lanes halved;
  std::memcpy(&halved, &bits, sizeof halved);
  Lanes series{};
  double of_term = 1.0;  // n!/11!
  for (int n = 11; n > 0; --n) {
    series = of_term - series * r;
    of_term *= n;
  }
  series *= r * (-1.0 / of_term);
  result.passes = halved + halved * series;
  result.collides = (1.0 - halved) - halved * series;
}

/// Means over what collides of t, t² and t³, 0 ≤ t ≤ 1 the way along.
[[gnu::always_inline]] inline void moments(const Lanes& depth, const Beer& light, Lanes moment[3]) {
  // J_k = ∫ t^k e^(−depth t) dt; by parts depth J_k = k J_(k−1) − e^−depth. Where the depth is
  // small, downwards from J_3 = e^−depth Σ_n depth^n 3!/(n+4)!.
  constexpr double shallow = 0.25;
  Lanes series = Lanes{} + 1.0;
  for (int n = 11; n > 4; --n) series = 1.0 + depth * (1.0 / n) * series;
  Lanes j[4];
  j[3] = 0.25 * light.passes * series;
  j[2] = (depth * j[3] + light.passes) * (1.0 / 3.0);
  j[1] = (depth * j[2] + light.passes) * 0.5;
  j[0] = depth * j[1] + light.passes;
  const auto thin = depth < shallow;
  const Lanes inverse = 1.0 / depth;
  j[0] = thin ? j[0] : light.collides * inverse;
  for (int k = 1; k < 4; ++k) {
    j[k] = thin ? j[k] : (static_cast<double>(k) * j[k - 1] - light.passes) * inverse;
  }
  const Lanes scale = 1.0 / j[0];
  for (int k = 0; k < 3; ++k) moment[k] = j[k + 1] * scale;
}

/// `power` by the means of the corners' functions: of x, y, z and their products, polynomials in t.
[[gnu::always_inline]] inline void share(const CellStep& step, const Lanes moment[3],
                                         const Lanes& power, CornerShares& shares) {
  const Eigen::Vector3d from = step.from.cast<double>(), way = step.along.cast<double>();
  const auto turned = [&](Eigen::Index i, Eigen::Index j) {
    return from[i] * way[j] + from[j] * way[i];
  };
  const double here = from.x() * from.y(), along = way.x() * way.y();
  const Lanes x = from.x() + moment[0] * way.x(), y = from.y() + moment[0] * way.y(),
              z = from.z() + moment[0] * way.z();
  const Lanes xy = here + moment[0] * turned(0, 1) + moment[1] * along;
  const Lanes yz = from.y() * from.z() + moment[0] * turned(1, 2) + moment[1] * (way.y() * way.z());
  const Lanes zx = from.z() * from.x() + moment[0] * turned(2, 0) + moment[1] * (way.z() * way.x());
  const Lanes xyz = here * from.z() + moment[0] * (here * way.z() + turned(0, 1) * from.z()) +
                    moment[1] * (turned(0, 1) * way.z() + along * from.z()) +
                    moment[2] * (along * way.z());
  const Lanes of_corner[8] = {power * (1.0 - x - y - z + xy + yz + zx - xyz),
                              power * (x - xy - zx + xyz),
                              power * (y - xy - yz + xyz),
                              power * (xy - xyz),
                              power * (z - yz - zx + xyz),
                              power * (zx - xyz),
                              power * (yz - xyz),
                              power * xyz};
  std::memcpy(shares.data(), of_corner, sizeof of_corner);
}

}  // namespace

void set_lane(const Coefficients& coefficients, std::size_t lane, CellOptics& optics) {
  optics.sigma_t[lane] = 1.0 / (3.0 * coefficients.kappa);
  optics.scattered[lane] = 1.0 - std::min(1.0, 3.0 * coefficients.kappa * coefficients.mu);
}

BeamLight entering(const BeamPath& path, const OfChannels& power, double remainder) {
  BeamLight light;
  for (std::size_t c = 0; c < beam_lanes; ++c) {
    light.left[c] = path.transmitted() * power[c];
    light.least[c] = remainder * light.left[c];
  }
  return light;
}

KAPPAMU_WIDEST bool collide(const CellStep& step, const CellOptics& optics, BeamLight& light,
                            CornerShares& shares) {
  Lanes depth, scattering, left, least, scattered, absorbed;
  std::memcpy(&depth, optics.sigma_t.data(), sizeof depth);
  std::memcpy(&scattering, optics.scattered.data(), sizeof scattering);
  std::memcpy(&left, light.left.data(), sizeof left);
  std::memcpy(&least, light.least.data(), sizeof least);
  std::memcpy(&scattered, light.scattered.data(), sizeof scattered);
  std::memcpy(&absorbed, light.absorbed.data(), sizeof absorbed);
  constexpr double deepest = 700.0;  // e^-700 is a number yet
  depth *= step.length;
  depth = depth < deepest ? depth : Lanes{} + deepest;
  Beer beer_law;
  beer(depth, beer_law);
  Lanes moment[3];
  moments(depth, beer_law, moment);
  const Lanes collided = left * beer_law.passes > least ? left * beer_law.collides : left;
  const Lanes sent = collided * scattering;
  left -= collided;
  scattered += sent;
  absorbed += collided - sent;
  share(step, moment, sent, shares);
  std::memcpy(light.left.data(), &left, sizeof left);
  std::memcpy(light.scattered.data(), &scattered, sizeof scattered);
  std::memcpy(light.absorbed.data(), &absorbed, sizeof absorbed);
  return left[0] + left[1] + left[2] + left[3] > 0.0;
}

bool leave(double share, BeamLight& light, OfChannels& leaves) {
  bool any = false;
  for (std::size_t c = 0; c < beam_lanes; ++c) {
    const double stays = (1.0 - share) * light.left[c];
    leaves[c] = stays > light.least[c] ? light.left[c] - stays : light.left[c];
    light.left[c] -= leaves[c];
    light.unscattered[c] += leaves[c];
    any = any || light.left[c] > 0.0;
  }
  return any;
}

}  // namespace kappamu::forward

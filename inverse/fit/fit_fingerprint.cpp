#include "inverse/fit/fit_fingerprint.h"

#include <optional>
#include <span>

#include "inverse/checkpoint/state_bytes.h"
#include "inverse/fit/describe_options.h"

namespace kappamu::inverse {

namespace {

/// Channel `channel` of `m` with the light it was seen under.
void add(Fingerprint& print, const SurfaceMeasurements& m, int channel) {
  for (const int n : {m.grid.nx, m.grid.ny, m.grid.nz, m.patterns}) print.add(n);
  for (const double x : {m.grid.voxel_mm, m.eta, m.smooth_error.common, m.smooth_error.own}) {
    print.add(x);
  }
  print.add(m.lit_face);
  print.add(m.seen_face);
  for (const Face face : m.seen_faces) print.add(face);
  for (const auto& [face, camera] : m.cameras) {
    print.add(face);
    for (const double x : camera) print.add(x);
  }
  print.add(m.quantity);
  print.add(m.light);
  print.add(m.sides);
  print.add(std::span<const float>(m.irradiance));
  const std::size_t count = m.seen_shape().cells() * static_cast<std::size_t>(m.patterns);
  const std::size_t first = count * static_cast<std::size_t>(channel);
  print.add(std::span<const float>(m.value).subspan(first, count));
  print.add(std::span<const float>(m.variance).subspan(first, count));
  if (!m.lit.empty()) print.add(std::span<const std::uint8_t>(m.lit).subspan(first, count));
  if (!m.mask.empty()) print.add(std::span<const std::uint8_t>(m.mask).subspan(first, count));
}

template <class Value>
void add(Fingerprint& print, const Value& value) {
  print.add(value);
}

void add(Fingerprint& print, const std::optional<double>& value) {
  print.add(value.has_value());
  print.add(value.value_or(0.0));
}

}  // namespace

std::uint64_t fingerprint(const SurfaceMeasurements& m, int channel, const FitOptions& o,
                          const FitContext& context, const std::string& program) {
  Fingerprint print;
  print.add(program);
  print.add(channel);
  add(print, m, channel);
  print.add(context.interim);
  print.add(context.continued.has_value());
  if (context.continued) {
    const Continuation& c = *context.continued;
    print.add(std::span<const double>(c.medium.kappa.values()));
    print.add(std::span<const double>(c.medium.mu.values()));
    for (const double x : {c.homogeneous_kappa, c.homogeneous_mu, c.weight}) print.add(x);
    print.add(c.physics == Physics::transport);
  }

  describe(o, [&print](const Option& option, const auto& value, const auto&...) {
    if (option.shapes_volumes) add(print, value);
  });
  return print.value();
}

}  // namespace kappamu::inverse

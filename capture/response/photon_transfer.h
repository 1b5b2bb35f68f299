// Photo-electrons at full scale from an exposure stack itself.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "capture/response/response.h"

namespace kappamu::capture {

/// Neighbouring exposures j, k of a pixel see one radiance, so d = x_j - (t_j/t_k) x_k (x the
/// linear signal) has the variance of noise alone whatever the scene's texture. Its robust spread
/// in bins of the signal, less read noise and rounding, rises with slope (1 + t_j/t_k)/N. Returns N
/// (median over bins and pairs of frames), or nothing where no bin rises clearly above read noise.
/// `response` [code] is the linear signal, `read_deviation` the read noise as a fraction of full
/// scale.
std::optional<double> electrons_at_full_scale(std::span<const ExposedFrame> stack, int channel,
                                              const std::vector<double>& response,
                                              double read_deviation);

}  // namespace kappamu::capture

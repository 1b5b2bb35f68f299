// Recovery of the camera's inverse response from exposure stacks: Debevec & Malik 1997, eq. (3),
// with these deviations (docs/hdr.md tells why and what each brings):
//  - samples are means over small smooth blocks, so noise and quantisation average out;
//  - weights are inverse variances of ln exposure, not a hat; outliers are weighted down (Tukey);
//  - g is written ln((z - black)/(top - black)) + s, and s is smooth in ln(1 + (z - black)/toe), in
//    which linear toes and power laws are straight, stretched towards the largest code, where
//    shoulders bend; black level fixes what log exposures cannot;
//  - the weight of the smoothness is chosen by generalised cross-validation.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "capture/response/exposed_frame.h"

namespace kappamu::capture {

/// A small smooth block of the scene under the exposures of its stack, one channel.
struct ResponseSample {
  std::vector<double> code;          ///< [frame] mean code value
  std::vector<double> variance;      ///< [frame] variance of the block's codes about their mean
  std::vector<double> log_exposure;  ///< [frame] ln of the exposure time [s]
  std::vector<std::uint8_t> valid;   ///< [frame] 1 unless a code is saturated
};

inline constexpr int sample_block_px = 4;  ///< edge of a sample block [px]

/// How well the curve explains its samples.
struct ResponseReport {
  int samples = 0;             ///< blocks
  int observations = 0;        ///< block means used, over all frames
  double residual_rms = 0.0;   ///< of ln exposure, inliers, weighted [dimensionless]
  double outlier_share = 0.0;  ///< of observations weighted to zero
  double smoothness = 0.0;     ///< the weight chosen
  double lowest_code = 0.0;    ///< the range of codes the samples cover; beyond, s is extrapolated
  double highest_code = 0.0;
  int pooled_codes = 0;  ///< codes changed to make the curve rise
};

struct RecoveredResponse {
  std::vector<double> linear;  ///< [code], 0 at the black level, 1 at the largest code, rising
  ResponseReport report;
};

/// Code values at and above this are taken as saturated: 1 % below the largest, since the codes
/// just below clipping are bent by it (JPEG, interpolation between clipped and unclipped pixels).
int saturation_code(int bit_depth);

/// The same of a camera whose inverse response `linear` [code] reaches 1 at its white level.
int saturation_code(const std::vector<double>& linear);

/// Adds the smoothest blocks of one stack that cover the code range evenly. Deterministic.
void collect_response_samples(std::span<const ExposedFrame> stack, int channel, int bit_depth,
                              std::vector<ResponseSample>& samples);

/// Throws InputError if the samples do not hold two exposures each on at least a quarter of the
/// code range. `name` begins the sentence (a file or folder).
RecoveredResponse recover_response(const std::vector<ResponseSample>& samples, int bit_depth,
                                   double black_level, const std::string& name);

}  // namespace kappamu::capture

// Whether absolute scale, refractive index and pose of the data are right. κ and μ of voxels absorb
// a wrong scale, a wrong index and much of a shift between light and images, and the residuals do
// not show it. A homogeneous block cannot absorb them: every fit first finds the scale and shift
// that suit such a block best, with their spread between patterns (scale_and_shift.h). The
// roughness of a fitted volume then gives finer estimates (volume_errors.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "inverse/data_checks/coarser_volume.h"
#include "inverse/data_checks/scale_and_shift.h"
#include "inverse/data_checks/volume_errors.h"
#include "inverse/problem/problem.h"
#include "inverse/uncertainty/uncertainty.h"

namespace kappamu::inverse {

/// Errors between patterns need some.
inline constexpr int fewest_patterns = 4;

struct Consistency {
  bool checked = false;          ///< false: too few patterns
  bool explained = false;        ///< a homogeneous block with scale and shift explains the data
  bool volume_shift = false;     ///< the shift is what the fitted volume shows
  Estimate log_scale;            ///< natural logarithm of the data over what they should be
  double log_scale_limit = 0.0;  ///< beyond which it is reported
  Estimate shift_u, shift_v;     ///< of the images, along the seen face's axes [voxels]
  double shift_limit = 0.0;      ///< of its length [voxels]
  /// Refractive index with which a homogeneous block explains the data, where it does not with the
  /// one stated.
  std::optional<double> other_eta;
  /// By the fitted volume, if there is one [voxels of the problem].
  std::optional<VolumeErrors> by_volume;
  SolveCount solves;

  /// The volume's shift replaces the block's, except where both are significant.
  void set_by_volume(const VolumeErrors& found);
  /// By the block, or values too high by the volume.
  bool scale_is_wrong() const;
  bool block_scale_is_wrong() const;
  /// By the volume, unless a shift explains it. Values that are too low cannot be detected, because
  /// absorption and layers explain them.
  bool is_too_bright() const;
  bool is_shifted() const;
};

/// Checks `problem`, that of the finest grid, by transport if `photons` are given. The search
/// starts at `kappa` [mm] and `mu` [1/mm]; `model_error` is the one in the problem's weights.
Consistency check_consistency(const Problem& problem, double kappa, double mu,
                              const ModelError& model_error, const Backend& backend,
                              const std::optional<PhotonOptions>& photons = std::nullopt);

/// `homogeneous` with what the volume shows.
Consistency check_volume(const FittedVolume& volume, Consistency homogeneous,
                         const ModelError& model_error, const Backend& backend, std::uint64_t seed);

/// A sentence for each finding but a shift: what, by how much, what to check.
std::vector<std::string> warnings_of(const Consistency& consistency, const Problem& problem);

/// The least shifted of the channels checked, if every one is shifted. A true shift is the same in
/// all channels; what structure adds to it grows with absorption.
std::optional<std::size_t> shifted_channel(std::span<const Consistency> channels);

/// Values too high (is_too_bright()): size, and what to check.
std::string brightness_sentence(const Consistency& consistency);

/// A shift by how much, and what to check.
std::string shift_sentence(const Consistency& consistency, const GridShape& grid, Face seen_face);

/// Summary of the findings, of their bounds and of what the data cannot determine; empty if nothing
/// was checked.
std::string in_words(const Consistency& consistency, double eta);

}  // namespace kappamu::inverse

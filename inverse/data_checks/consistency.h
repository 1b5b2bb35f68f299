// Whether the data can be what they claim to be. A volume absorbs a wrong absolute scale, a wrong
// refractive index and much of a shift between light and images into κ and μ, and its residuals
// never tell. A homogeneous block cannot: what scale and shift suit it best, and how far patterns
// agree on them, is asked of every fit (scale_and_shift.h). Where a volume was fitted, the
// roughness that it paid for a shift or for values too high reveals more (volume_errors.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

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
  /// What the fitted volume shows, where one was asked [the problem's voxels].
  std::optional<VolumeErrors> by_volume;
  SolveCount solves;

  /// Its shift goes in place of the block's, which stays where both report one: it is no matter of
  /// derivatives.
  void set_by_volume(const VolumeErrors& found);
  /// By the block, or values too high by the volume.
  bool scale_is_wrong() const;
  bool block_scale_is_wrong() const;
  /// By the volume, where no shift makes it look so. Of values too low there is no such sign:
  /// absorption and layers take up all of them.
  bool is_too_bright() const;
  bool is_shifted() const;
};

/// Of `problem`, the finest grid's, by transport where `photons` are given; `kappa` [mm] and `mu`
/// [1/mm] are where to start. `model_error` is what it was made with.
Consistency check_consistency(const Problem& problem, double kappa, double mu,
                              const ModelError& model_error, const Backend& backend,
                              const std::optional<PhotonOptions>& photons = std::nullopt);

/// What the fit of a volume ended with.
struct FittedVolume {
  const Problem& problem;  ///< the finest grid's
  const CoefficientPair& fields;
  const std::vector<double>& prediction;  ///< [M][v][u], as `problem.data`
  const Prior& prior;                     ///< of the fit's α
  const DataTermOptions& data_term;
};

/// `homogeneous` with what the volume shows.
Consistency check_volume(const FittedVolume& volume, Consistency homogeneous,
                         const ModelError& model_error, const Backend& backend, std::uint64_t seed);

/// A sentence for each finding but a shift: what, by how much, what to check.
std::vector<std::string> warnings_of(const Consistency& consistency, const Problem& problem);

/// The least shifted of the channels checked, where every one is shifted: images and light lie
/// apart alike in all of them, while what the block's structure adds grows with absorption.
std::optional<std::size_t> shifted_channel(std::span<const Consistency> channels);

/// Of values too high (is_too_bright()): by how much, and what to check.
std::string brightness_sentence(const Consistency& consistency);

/// A shift by how much, and what to check.
std::string shift_sentence(const Consistency& consistency, const GridShape& grid, Face seen_face);

/// What was found, what would have been reported, and what the data cannot determine; empty where
/// nothing was checked.
std::string in_words(const Consistency& consistency, double eta);

}  // namespace kappamu::inverse

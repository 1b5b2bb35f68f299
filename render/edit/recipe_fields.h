// What reader and writer of recipes share.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "render/edit/edit.h"

namespace kappamu::render {

/// What v may be in the operations that state it, and the largest step of an addition.
struct Range {
  const char* name;
  Amount Edit::*amount;
  double smallest, largest;
};
inline constexpr double largest_albedo = 0.999999;
inline const Range ranges[] = {{"kappa", &Edit::kappa, smallest_kappa_mm, largest_kappa_mm},
                               {"mu", &Edit::mu, 0.0, largest_mu_per_mm},
                               {"albedo", &Edit::albedo, smallest_albedo, largest_albedo},
                               {"mean_free_path_mm", &Edit::mean_free_path_mm,
                                3.0 * smallest_kappa_mm, 3.0 * largest_kappa_mm}};

/// One edit of a recipe in `folder`.
nlohmann::ordered_json edit_json(const Edit& edit, const std::filesystem::path& folder);

}  // namespace kappamu::render

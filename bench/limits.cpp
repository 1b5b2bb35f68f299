#include "bench/limits.h"

#include "core/error.h"

namespace kappamu::bench {

namespace {

struct Entry {
  LimitName name;
  LimitTable (*measure)(const LimitsOptions&, Progress&);
};

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all{
      {{"contrast", "iterations and true error against the contrast of kappa"}, limit_contrast},
      {{"size", "iterations against the size of the grid"}, limit_size},
      {{"floor", "the error float and double can attain, against contrast"}, limit_floor},
      {{"absorption", "mu from 0 to 100/mm"}, limit_absorption},
      {{"mirror", "mirror sides without absorption"}, limit_mirror},
      {{"shape", "thin, long, prime and odd grids"}, limit_shape},
      {{"boundary", "kappa jumping at the surface"}, limit_boundary},
      {{"coarse", "voxels against the mean free path"}, limit_coarse},
      {{"stencil", "energy lost or made by [W] equation (8)'s stencil"}, limit_stencil},
      {{"relaxation", "how far relaxation is from the solution when it seems to stand"},
       limit_relaxation},
      {{"inverse", "fits of difficult, scarce and wrong data"}, limit_inverse},
      {{"consistency", "how often data of a wrong scale, pose or eta are told"}, limit_consistency},
  };
  return all;
}

}  // namespace

const std::vector<LimitName>& limit_names() {
  static const std::vector<LimitName> names = [] {
    std::vector<LimitName> list;
    for (const Entry& entry : entries()) list.push_back(entry.name);
    return list;
  }();
  return names;
}

LimitTable measure_limit(const std::string& id, const LimitsOptions& options, Progress& progress) {
  std::string known;
  for (const Entry& entry : entries()) {
    if (entry.name.id == id) return entry.measure(options, progress);
    known += (known.empty() ? "'" : ", '") + entry.name.id + "'";
  }
  throw InputError("limit '" + id + "' is unknown; choose one of " + known + ".");
}

}  // namespace kappamu::bench

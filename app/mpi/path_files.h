// The state of a fit before a weight, on disk: the fields and what the optimiser has learned as
// arrays that every rank writes its part of, the rest as JSON, which comes last and names them. Any
// number of ranks can go on from it whose pieces have its grid.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "forward/distributed/block_pieces.h"
#include "inverse/distributed/distributed_fit.h"

namespace kappamu::app::mpi {

class PathFiles {
 public:
  /// `pieces` are those of the finest grid; `name` tells apart the fits of a folder.
  PathFiles(std::shared_ptr<const forward::distributed::BlockPieces> pieces,
            std::filesystem::path folder, const std::string& name)
      : pieces_(std::move(pieces)), folder_(std::move(folder)), name_("checkpoint_" + name) {}

  void save(const inverse::distributed::PathState& state) const;
  std::optional<inverse::distributed::PathState> load() const;
  void remove() const;

 private:
  std::filesystem::path json_file() const { return folder_ / (name_ + ".json"); }
  /// Of the state after so many weights' steps.
  std::filesystem::path array(std::size_t steps) const {
    return folder_ / (name_ + "_" + std::to_string(steps) + ".npy");
  }
  std::filesystem::path pairs(std::size_t steps) const {
    return folder_ / (name_ + "_" + std::to_string(steps) + "_pairs.npy");
  }

  std::shared_ptr<const forward::distributed::BlockPieces> pieces_;
  std::filesystem::path folder_;
  std::string name_;
};

}  // namespace kappamu::app::mpi

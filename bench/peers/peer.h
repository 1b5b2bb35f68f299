// A solver of somebody else's behind one interface, so that all are driven and timed alike.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bench/peers/problem.h"

namespace kappamu::peers {

class Peer {
 public:
  virtual ~Peer() = default;
  /// What its authors would try first; index into this is `setting` below.
  virtual std::vector<std::string> settings() const = 0;
  /// Builds the preconditioner of a setting, leaving out the assembly of the matrix, which is done
  /// once before: only this is timed as set-up.
  virtual void set_up(int setting) = 0;
  /// Conjugate gradients from zero to ‖b − Aφ‖₂ ≤ tolerance ‖b‖₂. Returns the iterations. Vectors
  /// in row order, this rank's part.
  virtual int solve(const std::vector<double>& b, double tolerance, std::vector<double>& phi) = 0;
};

inline constexpr int max_iterations = 5000;

/// The names of a list of settings, for Peer::settings().
template <class Settings>
std::vector<std::string> names_of(const Settings& settings) {
  std::vector<std::string> names;
  for (const auto& setting : settings) names.emplace_back(setting.name);
  return names;
}

// Present where the library was found; the matrix is assembled on construction.
std::unique_ptr<Peer> make_hypre_pfmg(const Problem& problem);
std::unique_ptr<Peer> make_hypre_boomeramg(const Problem& problem);
std::unique_ptr<Peer> make_petsc_gamg(const Problem& problem);
std::unique_ptr<Peer> make_petsc_icc(const Problem& problem);

}  // namespace kappamu::peers

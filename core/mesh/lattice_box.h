// Places of the integer lattice, their neighbours, and values in a box of them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

namespace kappamu {

/// Corner of a cell by its bits: 0 in x, 1 in y, 2 in z.
inline Eigen::Vector3i lattice_corner(int bits) {
  return {bits & 1, bits >> 1 & 1, bits >> 2 & 1};
}

/// Step across a side: -x, +x, -y, +y, -z, +z.
inline Eigen::Vector3i lattice_side(int side) {
  return (side % 2 == 0 ? -1 : 1) * Eigen::Vector3i::Unit(side / 2);
}

/// A value at every place from `low` to `high`, both included.
template <class Value>
class LatticeBox {
 public:
  LatticeBox(const Eigen::Vector3i& low, const Eigen::Vector3i& high, Value outside)
      : low_(low),
        size_(high - low + Eigen::Vector3i::Ones()),
        outside_(outside),
        values_(static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()) *
                    static_cast<std::size_t>(size_.z()),
                outside) {}

  const Eigen::Vector3i& low() const { return low_; }
  const Eigen::Vector3i& size() const { return size_; }
  bool holds(const Eigen::Vector3i& place) const {
    const Eigen::Array3i at = (place - low_).array();
    return (at >= 0).all() && (at < size_.array()).all();
  }
  /// Of any place: `outside` beyond the box.
  Value at(const Eigen::Vector3i& place) const {
    return holds(place) ? values_[index(place)] : outside_;
  }
  /// Only within the box.
  Value& operator[](const Eigen::Vector3i& place) { return values_[index(place)]; }

  template <class Act>
  void for_each(const Act& act) const {
    std::size_t i = 0;
    for (int z = 0; z < size_.z(); ++z) {
      for (int y = 0; y < size_.y(); ++y) {
        for (int x = 0; x < size_.x(); ++x) {
          act(Eigen::Vector3i(low_ + Eigen::Vector3i(x, y, z)), values_[i++]);
        }
      }
    }
  }

 private:
  std::size_t index(const Eigen::Vector3i& place) const {
    const Eigen::Vector3i at = place - low_;
    return static_cast<std::size_t>(at.x()) +
           static_cast<std::size_t>(size_.x()) *
               (static_cast<std::size_t>(at.y()) +
                static_cast<std::size_t>(size_.y()) * static_cast<std::size_t>(at.z()));
  }

  Eigen::Vector3i low_, size_;
  Value outside_;
  std::vector<Value> values_;
};

}  // namespace kappamu

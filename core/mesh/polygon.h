// Polygons in space as triangles.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace kappamu {

/// Appends n − 2 triangles of a polygon of n ≥ 3 vertices, concave or not, that face as it does, by
/// clipping ears in its mean plane (Newell's normal). One that crosses itself there is cut somehow.
void cut_into_triangles(const std::vector<Eigen::Vector3d>& vertices, std::span<const int> polygon,
                        std::vector<std::array<int, 3>>& triangles);

}  // namespace kappamu

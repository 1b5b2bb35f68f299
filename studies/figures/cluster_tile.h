// [M] 6.9: the clusters of the dipole's hierarchy that give one triangle its light.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/image.h"
#include "render/scene/scene.h"

namespace kappamu::studies {

/// What the scene's camera sees of its first object. Each level of the hierarchy has a colour, each
/// cluster a shade of it, and triangles that are summed one by one are white. The triangle that
/// receives, black, is the one seen at `at`, shares of the film's width and height. Throws
/// InputError where none is seen there, and of a medium that varies.
Image<std::uint8_t> cluster_tile(const render::Scene& scene, const Eigen::Vector2d& at);

}  // namespace kappamu::studies

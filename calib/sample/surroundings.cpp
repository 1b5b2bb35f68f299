#include "calib/sample/surroundings.h"

#include "capture/radiance/merge.h"

namespace kappamu::calib {

void add_block(const Lens& camera, const Rigid& camera_from_sample, const GridShape& grid,
               Surrounding& surrounding) {
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d point = grid.voxel_mm * Eigen::Vector3d((corner & 1) != 0 ? grid.nx : 0,
                                                                  (corner & 2) != 0 ? grid.ny : 0,
                                                                  (corner & 4) != 0 ? grid.nz : 0);
    const Eigen::Vector2d pixel = camera.project(camera_from_sample * point);
    surrounding.add(pixel.x(), pixel.y());
  }
}

Region with_surroundings(const Surrounding& surrounding, const Lens& camera) {
  constexpr double share = 0.25;
  constexpr double least_px = 64.0;
  return surrounding.region(share, least_px, capture::merged_grid_px, camera.width, camera.height);
}

}  // namespace kappamu::calib

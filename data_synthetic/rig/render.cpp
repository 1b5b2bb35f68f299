#include "data_synthetic/rig/render.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"

namespace kappamu::synthetic {

using Eigen::Vector2d;
using Eigen::Vector3d;

RayTable::RayTable(const calib::Lens& lens, int per_side)
    : lens_(lens),
      per_side_(per_side),
      tile_(std::clamp(static_cast<int>(std::sqrt(0.0078 * lens.width)), 1, 8)) {
  const std::size_t columns = corners_in_row();
  const int rows = (lens.height + tile_ - 1) / tile_ + 1;
  std::vector<Vector3d> corners(columns * static_cast<std::size_t>(rows));
  for_rows(rows, [&](int row) {
    for (std::size_t column = 0; column < columns; ++column) {
      corners[static_cast<std::size_t>(row) * columns + column] = lens.unproject(
          {static_cast<double>(column) * tile_ - 0.5, static_cast<double>(row) * tile_ - 0.5});
    }
  });
  corners_ = std::make_shared<const std::vector<Vector3d>>(std::move(corners));
}

double coverage(double position, double low, double high, double width) {
  const double from = std::max(position - 0.5 * width, low);
  const double to = std::min(position + 0.5 * width, high);
  return std::clamp((to - from) / width, 0.0, 1.0);
}

namespace {

/// Where a ray meets a quad's plane, in the quad's frame.
struct Hit {
  Vector2d at = Vector2d::Zero();
  Vector2d footprint = Vector2d::Zero();  // extent along x and y of the ray's share of the picture
};

/// `spacing` is the distance between neighbouring rays at unit depth.
std::optional<Hit> meet_plane(const Rigid& quad_from_camera, const Vector3d& direction,
                              double spacing) {
  const Vector3d ray = quad_from_camera.rotation * direction;
  const Vector3d& origin = quad_from_camera.translation;
  const double distance = -origin.z() / ray.z();
  if (ray.z() <= 0.0 || distance <= 0.0) return std::nullopt;
  Hit hit;
  hit.at = (origin + distance * ray).head<2>();
  for (int axis = 0; axis < 2; ++axis) {
    const Vector3d turn = quad_from_camera.rotation.col(axis);
    const Vector3d shift = distance * (turn - turn.z() / ray.z() * ray);
    hit.footprint += spacing * shift.head<2>().cwiseAbs();
  }
  return hit;
}

/// Irradiance of the light at a point of the quad.
double irradiance(const Illumination& light, const Quad& quad, const Vector2d& at) {
  double sum = light.ambient;
  if (light.projector != nullptr && light.thrown != nullptr) {
    const Vector3d normal = -quad.world_from_quad.rotation.col(2);
    const ProjectorSample sample = sample_projector(
        *light.projector, quad.world_from_quad * Vector3d(at.x(), at.y(), 0.0), normal);
    if (sample.white > 0.0) sum += sample.white * thrown_value(*light.thrown, sample.pixel);
  }
  return sum;
}

/// Between the values at a square's corners: left top, right top, left bottom, right bottom.
template <class T>
T between(const std::array<T, 4>& corners, double s, double t) {
  return (1.0 - t) * ((1.0 - s) * corners[0] + s * corners[1]) +
         t * ((1.0 - s) * corners[2] + s * corners[3]);
}

/// The square of pixels [x, x + edge) x [y, y + edge); its corners are those of its pixels.
struct Tile {
  int x = 0, y = 0, edge = 1;

  const Vector3d& corner(const RayTable& rays, std::size_t k) const {
    return rays.corner(x / edge + (k % 2 == 1 ? 1 : 0), y / edge + (k >= 2 ? 1 : 0));
  }
  double across(double pixel_x) const { return (pixel_x + 0.5 - x) / edge; }
  double down(double pixel_y) const { return (pixel_y + 0.5 - y) / edge; }
};

/// Calls work(tile) for the tiles of a picture, rows of them on all cores.
template <class Work>
void for_tiles(const RayTable& rays, const Work& work) {
  const int edge = rays.tile();
  for_rows((rays.height() + edge - 1) / edge, [&](int row) {
    for (int x = 0; x < rays.width(); x += edge) work(Tile{x, row * edge, edge});
  });
}

/// Calls act(x, y) for the tile's pixels that lie in the picture.
template <class Act>
void for_pixels(const Tile& tile, const RayTable& rays, const Act& act) {
  for (int y = tile.y; y < std::min(tile.y + tile.edge, rays.height()); ++y) {
    for (int x = tile.x; x < std::min(tile.x + tile.edge, rays.width()); ++x) act(x, y);
  }
}

/// A quad in a tile: where the rays of its corners meet it, and what lights it there.
class QuadTile {
 public:
  QuadTile(const Quad& quad, const Rigid& quad_from_camera, const Illumination& light,
           double spacing, const RayTable& rays, const Tile& tile)
      : quad_(quad),
        quad_from_camera_(quad_from_camera),
        light_(light),
        spacing_(spacing),
        rays_(rays),
        tile_(tile) {
    for (std::size_t k = 0; k < 4; ++k) {
      const std::optional<Hit> hit = meet_plane(quad_from_camera, tile.corner(rays, k), spacing);
      if (!hit) continue;
      ++hits_;
      at_[k] = hit->at;
      footprint_ += 0.25 * hit->footprint;
    }
    if (hits_ < 4) return;
    Vector2d low = at_[0], high = at_[0];
    for (const Vector2d& at : at_) low = low.cwiseMin(at), high = high.cwiseMax(at);
    const Vector2d margin = 0.51 * footprint_;
    beside_ = ((high + margin).array() < quad.low.array()).any() ||
              ((low - margin).array() > quad.high.array()).any();
    if (beside_) return;
    inside_ = ((low - margin).array() > quad.low.array()).all() &&
              ((high + margin).array() < quad.high.array()).all();
    const Vector2d middle = between(at_, 0.5, 0.5);
    albedo_ = quad.albedo(middle, footprint_);
    const std::array<double, 3> of_all = quad.albedo(middle, high - low + 1.02 * footprint_);
    constexpr double rounding = 1e-9;
    even_ = true;
    for (std::size_t c = 0; c < 3; ++c) even_ &= std::abs(of_all[c] - albedo_[c]) < rounding;
    find_light();
  }

  bool seen() const { return hits_ > 0 && !beside_; }

  /// What ray n of a pixel sees of it: its part of the ray, and albedo times irradiance by channel.
  struct Seen {
    double present = 0.0;
    std::array<double, 3> light{};
  };
  Seen look(const Vector2d& pixel) const {
    const double s = tile_.across(pixel.x()), t = tile_.down(pixel.y());
    Hit hit;
    if (hits_ == 4) {
      hit = {between(at_, s, t), footprint_};
    } else {
      const auto met = meet_plane(quad_from_camera_, rays_.direction(pixel), spacing_);
      if (!met) return {};
      hit = *met;
    }
    Seen seen;
    seen.present = inside_
                       ? 1.0
                       : coverage(hit.at.x(), quad_.low.x(), quad_.high.x(), hit.footprint.x()) *
                             coverage(hit.at.y(), quad_.low.y(), quad_.high.y(), hit.footprint.y());
    if (seen.present <= 0.0) return seen;
    const std::array<double, 3> albedo = even_ ? albedo_ : quad_.albedo(hit.at, hit.footprint);
    const double power = light_at(hit.at, s, t);
    for (std::size_t c = 0; c < 3; ++c) seen.light[c] = albedo[c] * power;
    return seen;
  }

  /// Whether what is seen is bilinear over the tile: the mean over a pixel's rays is its middle's.
  bool smooth() const {
    return inside_ && even_ &&
           (lit_ == Lit::by_room || (lit_ == Lit::by_projector && shows_one_value()));
  }

 private:
  enum class Lit { by_room, by_projector, in_part };

  void find_light() {
    lit_ = Lit::by_room;
    if (light_.projector == nullptr || light_.thrown == nullptr) return;
    const Vector3d normal = -quad_.world_from_quad.rotation.col(2);
    int reached = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const ProjectorSample sample = sample_projector(
          *light_.projector, quad_.world_from_quad * Vector3d(at_[k].x(), at_[k].y(), 0.0), normal);
      shown_[k] = sample.pixel;
      white_[k] = sample.white;
      reached += sample.white > 0.0 ? 1 : 0;
    }
    if (reached == 4) lit_ = Lit::by_projector;
    if (reached == 4 || (reached == 0 && beyond_projector())) return;
    lit_ = Lit::in_part;
  }
  /// Whether the tile lies a pixel and more beyond one side of the projector's picture.
  bool beyond_projector() const {
    Vector2d low = shown_[0], high = shown_[0];
    for (const Vector2d& at : shown_) low = low.cwiseMin(at), high = high.cwiseMax(at);
    const calib::Lens& lens = light_.projector->lens;
    return high.x() < -1.5 || high.y() < -1.5 || low.x() > lens.width + 0.5 ||
           low.y() > lens.height + 0.5;
  }
  /// Whether the projector's pixels that light the tile have one value, to its rounding.
  bool shows_one_value() const {
    Vector2d low = shown_[0], high = shown_[0];
    for (const Vector2d& at : shown_) low = low.cwiseMin(at), high = high.cwiseMax(at);
    const Image<float>& thrown = *light_.thrown;
    const auto inside = [](double at, int size) {
      return std::clamp(static_cast<int>(std::floor(at)), 0, size - 1);
    };
    const float value = thrown(inside(low.x(), thrown.width()), inside(low.y(), thrown.height()));
    constexpr float rounding = 1e-6F;
    bool one = true;
    for (int y = inside(low.y(), thrown.height()); y <= inside(high.y() + 1.0, thrown.height());
         ++y) {
      for (int x = inside(low.x(), thrown.width()); x <= inside(high.x() + 1.0, thrown.width());
           ++x) {
        one = one && std::abs(thrown(x, y) - value) < rounding;
      }
    }
    return one;
  }
  double light_at(const Vector2d& at, double s, double t) const {
    if (lit_ == Lit::by_room) return light_.ambient;
    if (lit_ == Lit::in_part || hits_ < 4) return irradiance(light_, quad_, at);
    return light_.ambient +
           between(white_, s, t) * thrown_value(*light_.thrown, between(shown_, s, t));
  }

  const Quad& quad_;
  const Rigid& quad_from_camera_;
  const Illumination& light_;
  double spacing_;
  const RayTable& rays_;
  const Tile& tile_;
  int hits_ = 0;                  ///< corners whose rays meet the quad's plane
  std::array<Vector2d, 4> at_{};  ///< where, in the quad's frame
  Vector2d footprint_ = Vector2d::Zero();
  bool beside_ = false, inside_ = false;
  bool even_ = false;  ///< one albedo
  std::array<double, 3> albedo_{};
  Lit lit_ = Lit::in_part;
  std::array<Vector2d, 4> shown_{};  ///< projector pixels
  std::array<double, 4> white_{};
};

}  // namespace

Image<float> render_quads(const RayTable& rays, const Rigid& world_from_camera,
                          const std::vector<Quad>& quads, const Illumination& light) {
  std::vector<Rigid> quad_from_camera;
  quad_from_camera.reserve(quads.size());
  for (const Quad& quad : quads) {
    quad_from_camera.push_back(quad.world_from_quad.inverse() * world_from_camera);
  }
  const double spacing = 1.0 / (rays.focal_px() * rays.per_side());
  Image<float> image(rays.width(), rays.height(), 3);
  for_tiles(rays, [&](const Tile& tile) {
    std::vector<QuadTile> seen;
    for (std::size_t q = 0; q < quads.size(); ++q) {
      QuadTile quad(quads[q], quad_from_camera[q], light, spacing, rays, tile);
      if (quad.seen()) seen.push_back(quad);
    }
    if (seen.empty()) return;
    const bool smooth = seen.front().smooth();
    const int looks = smooth ? 1 : rays.per_pixel();
    for_pixels(tile, rays, [&](int x, int y) {
      std::array<double, 3> sum{};
      for (int n = 0; n < looks; ++n) {
        const Vector2d pixel = smooth ? Vector2d(x, y) : Vector2d(x, y) + rays.offset(n);
        double open = 1.0;  // part of the ray that no quad so far has stopped
        for (std::size_t q = 0; q < seen.size() && open > 0.0; ++q) {
          const QuadTile::Seen one = seen[q].look(pixel);
          const double present = open * one.present;
          open -= present;
          for (std::size_t c = 0; c < 3; ++c) sum[c] += present * one.light[c];
        }
      }
      for (int c = 0; c < 3; ++c) {
        image(x, y, c) =
            static_cast<float>(sum[static_cast<std::size_t>(c)] / (std::numbers::pi * looks));
      }
    });
  });
  return image;
}

FaceView::FaceView(const RayTable& rays, const Rigid& world_from_camera,
                   const Rigid& world_from_sample, const GridShape& surface, Face face,
                   const BoundaryConstants& constants)
    : rays_(rays),
      sample_from_camera_(world_from_sample.inverse() * world_from_camera),
      shape_(face_shape(surface, face)),
      voxel_mm_(surface.voxel_mm),
      plane_z_(is_plus(face) ? surface.nz * surface.voxel_mm : 0.0),
      outward_(is_plus(face) ? 1.0 : -1.0),
      constants_(constants) {
  check(axis_of(face) == 2, "the simulated camera looks at a z face");
}

FaceView::Place FaceView::place(const Vector3d& direction) const {
  const Vector3d ray = sample_from_camera_.rotation * direction;
  const Vector3d& origin = sample_from_camera_.translation;
  const Vector3d at = origin + (plane_z_ - origin.z()) / ray.z() * ray;
  return {at.x() / voxel_mm_, at.y() / voxel_mm_, -outward_ * ray.z() / ray.norm()};
}

bool FaceView::covers(int x, int y) const {
  for (int n = 0; n < rays_.per_pixel(); ++n) {
    const Place at = place(rays_.direction(Vector2d(x, y) + rays_.offset(n)));
    if (at.cosine <= 0.0 || at.u < 0.0 || at.v < 0.0 || at.u > shape_.nu || at.v > shape_.nv)
      return false;
  }
  return true;
}

Image<float> FaceView::radiance(const std::vector<std::vector<double>>& exitance) const {
  const std::size_t channels = exitance.size();
  Image<float> image(rays_.width(), rays_.height(), static_cast<int>(channels));
  const int most_u = std::max(shape_.nu - 2, 0), most_v = std::max(shape_.nv - 2, 0);
  const auto cell = [](double at, int most) {
    return std::clamp(static_cast<int>(at - 0.5), 0, most);
  };
  // Variance of a ray's place in its pixel, along either side.
  const double spread = (rays_.per_pixel() - 1.0) / (12.0 * static_cast<double>(rays_.per_pixel()));
  for_tiles(rays_, [&](const Tile& tile) {
    std::array<Vector2d, 4> places;
    std::array<double, 4> factors;
    Vector2d low = Vector2d::Constant(HUGE_VAL), high = -low;
    for (std::size_t k = 0; k < 4; ++k) {
      const Place at = place(tile.corner(rays_, k));
      if (at.cosine <= 0.0) return;  // a plane is seen from behind as a whole
      places[k] = {at.u, at.v};
      factors[k] = radiance_per_exitance(constants_, std::min(at.cosine, 1.0));
      low = low.cwiseMin(places[k]);
      high = high.cwiseMax(places[k]);
    }
    if (high.x() < 0.0 || high.y() < 0.0 || low.x() > shape_.nu || low.y() > shape_.nv) return;
    const bool inside =
        low.x() >= 0.0 && low.y() >= 0.0 && high.x() <= shape_.nu && high.y() <= shape_.nv;
    const bool one_cell = inside && cell(low.x(), most_u) == cell(high.x(), most_u) &&
                          cell(low.y(), most_v) == cell(high.y(), most_v);
    // Of the bilinear function of one cell the mean over a pixel's rays is its value at their mean
    // and, of the term u v, the covariance of u and v.
    const Vector2d across = (0.5 / tile.edge) * (places[1] - places[0] + places[3] - places[2]);
    const Vector2d down = (0.5 / tile.edge) * (places[2] - places[0] + places[3] - places[1]);
    const double covariance = spread * (across.x() * across.y() + down.x() * down.y());
    const int looks = one_cell ? 1 : rays_.per_pixel();
    for_pixels(tile, rays_, [&](int x, int y) {
      std::array<double, 3> sum{};
      for (int n = 0; n < looks; ++n) {
        const Vector2d offset = one_cell ? Vector2d(0.0, 0.0) : rays_.offset(n);
        const Vector2d at = between(places, tile.across(x + offset.x()), tile.down(y + offset.y()));
        if (at.x() < 0.0 || at.y() < 0.0 || at.x() > shape_.nu || at.y() > shape_.nv) continue;
        // On the outer half cell the line through the last two centres goes on: the exitance falls
        // steeply towards an open edge.
        const int u0 = cell(at.x(), most_u), v0 = cell(at.y(), most_v);
        const double fu = shape_.nu > 1 ? at.x() - 0.5 - u0 : 0.0;
        const double fv = shape_.nv > 1 ? at.y() - 0.5 - v0 : 0.0;
        const double fuv =
            fu * fv + (one_cell && shape_.nu > 1 && shape_.nv > 1 ? covariance : 0.0);
        const std::size_t here = static_cast<std::size_t>(v0) * shape_.nu + u0;
        const std::size_t right = u0 + 1 < shape_.nu ? here + 1 : here;
        const std::size_t step = v0 + 1 < shape_.nv ? static_cast<std::size_t>(shape_.nu) : 0;
        for (std::size_t c = 0; c < channels; ++c) {
          const std::vector<double>& map = exitance[c];
          const double twist = map[here] - map[right] - map[here + step] + map[right + step];
          sum[c] += map[here] + fu * (map[right] - map[here]) +
                    fv * (map[here + step] - map[here]) + fuv * twist;
        }
      }
      const double factor = between(factors, tile.across(x), tile.down(y)) / looks;
      for (std::size_t c = 0; c < channels; ++c) {
        image(x, y, static_cast<int>(c)) = static_cast<float>(std::max(0.0, sum[c]) * factor);
      }
    });
  });
  return image;
}

}  // namespace kappamu::synthetic

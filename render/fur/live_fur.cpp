#include "render/fur/live_fur.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/numbers/linear_algebra.h"
#include "core/parallel.h"

namespace kappamu::render {

using namespace forward::shells;
using Eigen::Array3d;
using Eigen::Vector3d;

FurVolume make_fur_volume(const FurTile& tile) {
  const HairTexture& texture = tile.texture;
  const auto size = static_cast<Eigen::Index>(harmonics_in(tile.transfer.bands));
  const auto row = [&](std::size_t i) {
    return Eigen::Map<const Eigen::VectorXf>(
               tile.transfer.values.data() + static_cast<std::ptrdiff_t>(i) * size, size)
        .cast<double>();
  };
  Eigen::MatrixXd moments = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < texture.size(); ++i) {
    if (texture.density[i] <= 0.0F) continue;
    const Eigen::VectorXd t = row(i);
    moments.selfadjointView<Eigen::Lower>().rankUpdate(t, static_cast<double>(texture.density[i]));
  }
  const SymmetricEigen solved = symmetric_eigen(moments);
  const Eigen::Index modes = std::min<Eigen::Index>(FurVolume::modes, size);
  FurVolume volume{.width = texture.width,
                   .layers = texture.layers,
                   .r = tile.transfer.r,
                   .layer_height = texture.layer_height,
                   .texels = {},
                   .basis = Eigen::MatrixXd::Zero(size, FurVolume::modes)};
  // Eigenvalues come in rising order.
  volume.basis.leftCols(modes) = solved.vectors.rightCols(modes).rowwise().reverse();
  const double all = solved.values.sum();
  if (all > 0.0) volume.lost = std::max(0.0, 1.0 - solved.values.tail(modes).sum() / all);
  for (std::vector<float>& texels : volume.texels) texels.resize(4 * texture.size());
  for_pieces(texture.size(), 4096, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const float density = texture.density[i];
      if (density <= 0.0F) continue;
      const Eigen::VectorXf w = (volume.basis.transpose() * row(i)).cast<float>();
      const Eigen::Vector3f& t = texture.tangent[i];
      const std::array<std::array<float, 4>, 3> values{
          {{1.0F, texture.depth[i], texture.shade[i], w[0]},
           {t.x(), t.y(), t.z(), w[1]},
           {w[2], w[3], w[4], 0.0F}}};
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t c = 0; c < 4; ++c) volume.texels[k][4 * i + c] = density * values[k][c];
      }
    }
  });
  return volume;
}

std::vector<float> fur_geometry(const FurryObject& furry) {
  const TriangleMesh& mesh = furry.object().mesh;
  const Rigid& world_from_object = furry.object().world_from_object;
  constexpr auto floats = static_cast<std::size_t>(FurCorners::geometry_floats);
  std::vector<float> geometry(3 * mesh.triangles.size() * floats);
  for_pieces(mesh.triangles.size(), 256, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto places = furry.placement().at_corners(t);
      for (std::size_t c = 0; c < 3; ++c) {
        const auto v = static_cast<std::size_t>(mesh.triangles[t][c]);
        float* to = geometry.data() + (3 * t + c) * floats;
        const auto put = [&](const Vector3d& vector) {
          for (int i = 0; i < 3; ++i) *to++ = static_cast<float>(vector[i]);
        };
        put(world_from_object * mesh.vertices[v]);
        put(world_from_object.rotation * furry.frames()[v].col(2));
        put(world_from_object.rotation * furry.frames()[v].col(0));
        // Tile coordinates near zero: a card interpolates them in floats. All corners of a triangle
        // lose the same whole number.
        for (std::size_t k = 0; k < Placement::most_places; ++k) {
          const Placement::Place& place = places[c].place[k];
          const Placement::Place& first = places[0].place[k];
          put({place.tile.x() - std::floor(first.tile.x()),
               place.tile.y() - std::floor(first.tile.y()), place.weight});
        }
        *to++ = static_cast<float>(furry.length_mm(v));
        *to++ = furry.coat().density[v];
        for (int i = 0; i < 3; ++i) *to++ = furry.coat().colour[v][i];
      }
    }
  });
  return geometry;
}

void light_fur(const FurryObject& furry, const FurVolume& volume, FurCorners& corners) {
  constexpr int modes = FurVolume::modes;
  const TriangleMesh& mesh = furry.object().mesh;
  const auto& light = furry.light();
  const std::size_t lamps = light.empty() ? 0 : light.front().direction.size();
  for (std::size_t lamp = 0; lamp < 2; ++lamp) {
    Array3d most = Array3d::Zero();
    for (const auto& here : light) {
      if (lamp < lamps) most = most.max(here.of_lamp[lamp]);
    }
    corners.lamp_colour[lamp] = most.cast<float>();
  }
  constexpr auto floats = static_cast<std::size_t>(FurCorners::light_floats);
  std::vector<float> of_vertex(light.size() * floats);
  for_pieces(light.size(), 256, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const FurryObject::Irradiance& here = light[v];
      Eigen::MatrixXd sky = here.coefficients.leftCols(3);
      for (std::size_t lamp = 2; lamp < lamps; ++lamp) {
        sky += here.coefficients.col(3 + static_cast<Eigen::Index>(lamp)) *
               here.of_lamp[lamp].matrix().transpose();
      }
      float* to = of_vertex.data() + v * floats;
      const Eigen::MatrixXd reduced = volume.basis.transpose() * sky;
      for (int k = 0; k < modes; ++k) {
        for (int c = 0; c < 3; ++c) *to++ = static_cast<float>(reduced(k, c));
      }
      for (std::size_t lamp = 0; lamp < 2; ++lamp) {
        if (lamp >= lamps) {
          to += modes + 4;
          continue;
        }
        const Eigen::VectorXd w =
            volume.basis.transpose() * here.coefficients.col(3 + static_cast<Eigen::Index>(lamp));
        for (int k = 0; k < modes; ++k) *to++ = static_cast<float>(w[k]);
        for (int i = 0; i < 3; ++i) *to++ = static_cast<float>(here.direction[lamp][i]);
        const double brightest = static_cast<double>(corners.lamp_colour[lamp].maxCoeff());
        *to++ =
            static_cast<float>(brightest > 0.0 ? here.of_lamp[lamp].maxCoeff() / brightest : 0.0);
      }
    }
  });
  corners.light.resize(3 * mesh.triangles.size() * floats);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto v = static_cast<std::size_t>(mesh.triangles[t][c]);
      std::copy_n(of_vertex.begin() + static_cast<std::ptrdiff_t>(v * floats), floats,
                  corners.light.begin() + static_cast<std::ptrdiff_t>((3 * t + c) * floats));
    }
  }
}

std::vector<double> skin_shares(const FurryObject& furry) {
  const double of_even_sky = furry.tile().through_of_even_sky();
  std::vector<double> shares;
  for (std::size_t v = 0; v < furry.light().size(); ++v) {
    const FurryObject::Irradiance& here = furry.light()[v];
    const auto thinned = static_cast<double>(furry.coat().density[v]);
    const double even = std::pow(of_even_sky, thinned);
    // Of an even sky of the same mean radiance: π L, with L = c₀ Y₀.
    double all = std::max(0.0, here.coefficients.leftCols(3).row(0).mean()) *
                 std::sqrt(std::numbers::pi) * 0.5;
    double through = even * all;
    for (std::size_t lamp = 0; lamp < here.direction.size(); ++lamp) {
      const double cosine = std::max(0.0, here.direction[lamp].z());
      const double arriving = cosine * here.of_lamp[lamp].mean();
      all += arriving;
      through += arriving * std::pow(furry.tile().through_at(cosine), thinned);
    }
    shares.push_back(all > 0.0 ? through / all : even);
  }
  return shares;
}

}  // namespace kappamu::render

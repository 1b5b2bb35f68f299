#include "render/fur/furry_object.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"

namespace kappamu::render {

using namespace forward::shells;
using Eigen::Array3d;
using Eigen::Vector3d;

namespace {

/// Of 76 degrees between normal and eye.
constexpr double grazing_cosine = 0.25;
constexpr int through_steps = 32, tile_width = FurTile::width, tile_layers = FurTile::layers;

HairTexture texture_of(const Fur& fur) {
  HairOptions options;
  options.width = tile_width;
  options.layers = tile_layers;
  options.layer_height = fur.length_mm / tile_layers / (fur.tile() / tile_width);
  for (HairCoat& coat : options.coats) {
    coat.hairs = static_cast<int>(std::lround(fur.density * coat.hairs));
    coat.curl = fur.curl;
    coat.least_radius *= fur.width;
    coat.most_radius *= fur.width;
  }
  const double lean = fur.lean;
  options.lean = [lean](double, double) { return Eigen::Vector2d(lean, 0.0); };
  options.seed = fur.seed;
  return make_hair_texture(options);
}

/// Transmittance from the skin along directions of one cosine, over the tile and all azimuths.
double skin_share(const HairTexture& texture, double r, double cosine) {
  constexpr std::uint32_t points = 256;
  const double across = std::sqrt(1.0 - cosine * cosine);
  double sum = 0.0;
  for (std::uint32_t i = 0; i < points; ++i) {
    const auto [u, v] = sobol_point(i, 1);
    const double angle = 2.0 * std::numbers::pi * (i + 0.5) / points;
    sum += transmittance(texture, r, {tile_width * u, tile_width * v, 0.0},
                         {across * std::cos(angle), across * std::sin(angle), cosine});
  }
  return sum / points;
}

HairModel model_of(const std::string& name) {
  return name == "even"        ? HairModel::even
         : name == "marschner" ? HairModel::marschner
                               : HairModel::kajiya_kay;
}

}  // namespace

FurTile make_fur_tile(const Fur& fur, Progress& progress) {
  FurTile tile;
  tile.texture = texture_of(fur);
  tile.transfer = make_transfer(tile.texture, {fur.bands, fur.rays, 0.0}, progress);
  for (int i = 0; i <= through_steps; ++i) {
    const double cosine = std::max(1e-3, static_cast<double>(i) / through_steps);
    tile.through.push_back(skin_share(tile.texture, tile.transfer.r, cosine));
  }
  return tile;
}

bool same_tile(const Fur& a, const Fur& b) {
  return a.width == b.width && a.density == b.density && a.curl == b.curl && a.lean == b.lean &&
         a.seed == b.seed && a.bands == b.bands &&
         std::abs(a.length_mm / a.tile() - b.length_mm / b.tile()) < 1e-9;
}

std::shared_ptr<const FurTile> FurTiles::of(const Fur& fur, Progress& progress) {
  for (const auto& [of, tile] : made_) {
    if (same_tile(of, fur) && of.rays == fur.rays) return tile;
  }
  return made_.emplace_back(fur, std::make_shared<const FurTile>(make_fur_tile(fur, progress)))
      .second;
}

double FurTile::through_at(double cosine) const {
  const double place = std::clamp(cosine, 0.0, 1.0) * through_steps;
  const auto low = std::min(static_cast<std::size_t>(place), std::size_t{through_steps - 1});
  const double share = place - static_cast<double>(low);
  return (1.0 - share) * through[low] + share * through[low + 1];
}

double FurTile::through_of_even_sky() const {
  double share = 0.0;
  for (int i = 0; i < through_steps; ++i) {
    const double cosine = (i + 0.5) / through_steps;
    share += 2.0 * cosine * through_at(cosine) / through_steps;
  }
  return share;
}

namespace {

/// What `make` returns; the object is named in what it throws.
template <class Make>
auto named(const WorldObject& object, const Make& make) {
  try {
    return make();
  } catch (const InputError& error) {
    throw InputError("object '" + object.name + "': " + error.what());
  }
}

}  // namespace

FurryObject::FurryObject(const WorldObject& object, const Fur& fur,
                         std::shared_ptr<const FurTile> tile, Coat coat)
    : object_(object),
      fur_(fur),
      tile_(std::move(tile)),
      coat_(std::move(coat)),
      colour_{fur.root_colour, fur.tip_colour, fur.variation},
      reflectance_(model_of(fur.reflectance), fur.shine),
      frames_(skin_frames(object.mesh, fur, coat_)),
      placement_(named(object, [&] {
        return std::make_unique<Placement>(object.mesh, frames_, fur.tile(), fur.seed);
      })) {}

FurryObject::FurryObject(const WorldObject& object, const Fur& fur, FurTiles& tiles,
                         FurReport& report, Progress& progress)
    : FurryObject(object, fur, named(object, [&] { return tiles.of(fur, progress); }),
                  named(object, [&] { return coat_of(object.rest, fur); })) {
  for (const HairCoat& coat : HairOptions{}.coats) {
    report.hairs += static_cast<int>(std::lround(fur.density * coat.hairs));
  }
  report.patches = placement_->patches();
  report.stretch = placement_->stretch();
  report.extinction = tile_->transfer.r / texel_mm();
  report.through = tile_->through_of_even_sky();
}

void FurryObject::warn(const LightSources& sources, const Vector3d& eye,
                       std::vector<std::string>& warnings) const {
  const auto add = [&](const std::string& sentence) {
    warnings.push_back("object '" + object_.name + "': fur: " + sentence);
  };
  const auto percent = [](double share) {
    return std::to_string(std::lround(100.0 * share)) + " %";
  };
  if (tile_->texture.thin > 0.5) {
    add(percent(tile_->texture.thin) +
        " of the hair is thinner than a tenth of a texel and is drawn as mist; write a larger "
        "width");
  }
  if (tile_->texture.overfull > 0.05) {
    add(percent(tile_->texture.overfull) +
        " of the hair lies in texels that are full already and is left out; write a smaller "
        "density");
  }
  if (!sources.empty()) {
    add("a lamp's light is sharper than " + std::to_string(tile_->transfer.bands) +
        " bands hold: its shadows between hairs are softer than they are (docs/fur.md)");
  }
  const Vector3d from = object_.world_from_object.inverse() * eye;
  std::size_t facing = 0, grazing = 0;
  for (std::size_t v = 0; v < frames_.size(); ++v) {
    const double cosine = frames_[v].col(2).dot((from - object_.mesh.vertices[v]).normalized());
    facing += cosine > 0.0 ? 1 : 0;
    grazing += cosine > 0.0 && cosine < grazing_cosine ? 1 : 0;
  }
  if (2 * grazing > facing) {
    add("most of it is seen at less than 14 degrees from its skin, where gaps between shells show; "
        "move the camera");
  }
}

void FurryObject::shade(IncidentLight& light) const {
  const double of_even_sky = tile_->through_of_even_sky();
  // What hair lets through falls exponentially with its density.
  const auto thinned = [&](std::size_t triangle) {
    double sum = 0.0;
    for (const int v : object_.mesh.triangles[triangle]) {
      sum += static_cast<double>(coat_.density[static_cast<std::size_t>(v)]) / 3.0;
    }
    return sum;
  };
  std::vector<double> even(object_.surface.size());
  for (std::size_t t = 0; t < even.size(); ++t) even[t] = std::pow(of_even_sky, thinned(t));
  for (std::size_t c = 0; c < 3; ++c) {
    const auto channel = static_cast<Eigen::Index>(c);
    double beams = 0.0, shaded = 0.0, diffuse_before = 0.0, diffuse_after = 0.0;
    for (forward::Beam& beam : light.channels[c].beams) {
      beams += beam.power;
      const auto triangle = static_cast<std::size_t>(beam.triangle);
      const Vector3d& normal = object_.surface.normal[triangle];
      beam.power *= std::pow(tile_->through_at(-beam.direction.dot(normal)), thinned(triangle));
      shaded += beam.power;
    }
    std::vector<double>& diffuse = light.channels[c].diffuse;
    for (std::size_t t = 0; t < diffuse.size(); ++t) {
      diffuse_before += diffuse[t] * object_.surface.area[t];
      diffuse[t] *= even[t];
      diffuse_after += diffuse[t] * object_.surface.area[t];
    }
    const double share = diffuse_before > 0.0 ? diffuse_after / diffuse_before : of_even_sky;
    light.power[channel] = share * (light.power[channel] - beams) + shaded;
  }
}

void FurryObject::set_light(const World& world, const LightSources& sources,
                            const Environment* environment) {
  const int bands = tile_->transfer.bands;
  Eigen::MatrixXd sky = Eigen::MatrixXd::Zero(harmonics_in(bands), 3);
  if (environment != nullptr) {
    const std::vector<Vector3d> directions = even_directions(65'536);
    for (const Vector3d& d : directions) {
      sky += 4.0 * std::numbers::pi / static_cast<double>(directions.size()) * harmonics(bands, d) *
             environment->radiance(d).matrix().transpose();
    }
  }
  const Turner turner(bands);
  light_.resize(object_.mesh.vertices.size());
  for_pieces(light_.size(), 256, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Eigen::Matrix3d world_from_skin = object_.world_from_object.rotation * frames_[v];
      const Vector3d out = world_from_skin.col(2);
      const Vector3d point =
          object_.world_from_object * object_.mesh.vertices[v] + length_mm(v) * out;
      Irradiance& here = light_[v];
      here.coefficients =
          Eigen::MatrixXd::Zero(harmonics_in(bands), 3 + static_cast<Eigen::Index>(sources.size()));
      if (environment != nullptr) {
        here.coefficients.leftCols(3) = turner.turned(sky, world_from_skin.transpose());
      }
      here.of_lamp.clear();
      here.direction.clear();
      for (std::size_t i = 0; i < sources.size(); ++i) {
        const Arrival arrival = sources[i]->at(point);
        const Vector3d towards = -arrival.direction;
        const bool dark = world.blocked(point, towards, arrival.distance);
        here.direction.emplace_back(world_from_skin.transpose() * towards);
        here.of_lamp.push_back(dark ? Array3d(Array3d::Zero()) : Array3d(arrival.irradiance));
        here.coefficients.col(3 + static_cast<Eigen::Index>(i)) =
            harmonics(bands, here.direction.back());
      }
    }
  });
}

double FurryObject::opacity(double density, double cosine) const {
  constexpr double grazing = 0.15;  // shells seen edge-on hold back no more than at this
  return forward::shells::opacity(tile_->texture, tile_->transfer.r, density,
                                  std::max(grazing, cosine));
}

/// Hair is interpolated first and then lit once, as on a graphics card.
FurryObject::Layer FurryObject::seen(std::size_t triangle, double u, double v, int layer,
                                     const Vector3d& towards_eye) const {
  Layer made{Array3d::Zero(), 0.0};
  const HairTexture& texture = tile_->texture;
  const auto& corners = object_.mesh.triangles[triangle];
  const std::array<double, 3> share{1.0 - u - v, u, v};
  const Placement::Places places = placement_->at(triangle, u, v);
  constexpr int most = most_bands * most_bands;
  const int size = harmonics_in(tile_->transfer.bands);
  Eigen::Matrix<float, Eigen::Dynamic, 1, 0, most, 1> transfers;
  transfers.setZero(size);
  Vector3d tangent = Vector3d::Zero();
  double sum = 0.0, depth = 0.0, shade = 0.0;
  for (int i = 0; i < places.count; ++i) {
    const auto& [tile, weight] = places.place[static_cast<std::size_t>(i)];
    const ShellTexels met = on_shell(texture, tile.x() * tile_width, tile.y() * tile_width, layer);
    if (met.density <= 0.0) continue;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t texel = met.texel[k];
      const double hair = weight * met.weight[k] * static_cast<double>(texture.density[texel]);
      if (hair <= 0.0) continue;
      const Eigen::Map<const Eigen::VectorXf> transfer(
          tile_->transfer.values.data() + texel * static_cast<std::size_t>(size), size);
      transfers += static_cast<float>(hair) * transfer;
      tangent += hair * texture.tangent[texel].cast<double>();
      depth += hair * static_cast<double>(texture.depth[texel]);
      shade += hair * static_cast<double>(texture.shade[texel]);
      sum += hair;
    }
  }
  double thinned = 0.0;
  Array3d tint = Array3d::Zero();
  for (std::size_t c = 0; c < 3; ++c) {
    const auto vertex = static_cast<std::size_t>(corners[c]);
    thinned += share[c] * static_cast<double>(coat_.density[vertex]);
    tint += share[c] * coat_.colour[vertex].cast<double>();
  }
  made.density = thinned * sum;
  if (made.density < 1e-4) return made;
  tangent = tangent.squaredNorm() > 0.0 ? Vector3d(tangent.normalized()) : Vector3d::UnitZ();
  const HairColour tinted{colour_.root * tint, colour_.tip * tint, colour_.variation};
  const Array3d own = tinted.at(depth / sum, shade / sum);
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most, 1> arriving = transfers.cast<double>();
  SkinFrame frame = SkinFrame::Zero();
  std::array<const Irradiance*, 3> light{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto vertex = static_cast<std::size_t>(corners[c]);
    frame += share[c] * frames_[vertex];
    light[c] = &light_[vertex];
  }
  const auto at_place = [&](const auto& of) {
    using Value = decltype(of(*light[0]));
    return Value(share[0] * of(*light[0]) + share[1] * of(*light[1]) + share[2] * of(*light[2]));
  };
  const auto lit = [&](Eigen::Index column) {
    return at_place([&](const Irradiance& here) {
             return here.coefficients.col(column).dot(arriving);
           }) /
           sum;
  };
  made.radiance = own * Array3d(lit(0), lit(1), lit(2)).max(0.0) * (0.25 / std::numbers::pi);
  const Vector3d eye =
      (frame.transpose() * (object_.world_from_object.rotation.transpose() * towards_eye))
          .normalized();
  for (std::size_t i = 0; i < light[0]->direction.size(); ++i) {
    const double t = std::clamp(lit(3 + static_cast<Eigen::Index>(i)), 0.0, 1.0);
    const Array3d irradiance =
        at_place([&](const Irradiance& here) -> Array3d { return here.of_lamp[i]; });
    if (t <= 0.0 || irradiance.maxCoeff() <= 0.0) continue;
    const Vector3d towards = at_place([&](const Irradiance& here) -> Vector3d {
                               return here.direction[i];
                             }).normalized();
    made.radiance += t * irradiance * reflectance_.towards(tangent, towards, eye, own);
  }
  return made;
}

}  // namespace kappamu::render

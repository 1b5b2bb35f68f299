// Every rank's piece against the serial reference on the whole block.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "forward/distributed/distributed_solver.h"

namespace kappamu::forward::distributed {
namespace {

struct Case {
  const char* name;
  GridSetup setup;
  Face seen;
  double contrast;  ///< largest κ over smallest
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.name;
}

class DistributedOperator : public testing::TestWithParam<Case> {
 protected:
  static constexpr int patterns = 3;

  DistributedOperator()
      : pieces(std::make_shared<BlockPieces>(PETSC_COMM_WORLD, setup())),
        whole(make_grid_operator(make_reference_solver(setup()), GetParam().seen)),
        piece(distributed_operators({pieces})->make(pieces->piece(), GetParam().seen, "", {}).op) {
    std::mt19937_64 random(20250807);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const auto draw = [&](std::size_t count, auto value) {
      std::vector<double> values(count);
      for (double& v : values) v = value(unit(random));
      return values;
    };
    const std::size_t cells = setup().shape.cells();
    const double range = std::log(GetParam().contrast);
    kappa = draw(cells, [&](double u) { return 0.3 * std::exp(range * (u - 0.5)); });
    mu = draw(cells, [](double u) { return 0.004 * std::exp(3.0 * u); });
    light = draw(patterns * whole->light_size(), [](double u) { return u; });
    weights = draw(patterns * whole->exitance_size(), [](double u) { return u - 0.3; });
    whole->set_medium(kappa, mu);
    piece->set_medium(of_piece(kappa), of_piece(mu));
  }

  const GridSetup& setup() const { return GetParam().setup; }
  std::vector<double> of_piece(const std::vector<double>& values) const {
    const Box& held = pieces->held();
    std::vector<double> result;
    for (int z = held.begin[2]; z < held.end[2]; ++z) {
      for (int y = held.begin[1]; y < held.end[1]; ++y) {
        for (int x = held.begin[0]; x < held.end[0]; ++x) {
          result.push_back(values[setup().shape.index(x, y, z)]);
        }
      }
    }
    return result;
  }
  /// f(pixel of the piece's face, pixel of the whole face), of the rank's own.
  template <class F>
  void for_own_pixels(Face face, F f) const {
    const FaceShape mine = face_shape(pieces->piece().shape, face);
    const FaceShape all = face_shape(setup().shape, face);
    const auto [u_axis, v_axis] = face_axes(face);
    for (int v = 0; v < mine.nv; ++v) {
      for (int u = 0; u < mine.nu; ++u) {
        if (!pieces->owns_pixel(face, u, v)) continue;
        f(static_cast<std::size_t>(v) * mine.nu + u,
          static_cast<std::size_t>(v + pieces->held().begin[v_axis]) * all.nu + u +
              pieces->held().begin[u_axis]);
      }
    }
  }
  std::vector<double> of_piece_face(Face face, const std::vector<double>& values) const {
    const std::size_t mine = face_shape(pieces->piece().shape, face).cells();
    const std::size_t all = face_shape(setup().shape, face).cells();
    std::vector<double> result(patterns * mine, 0.0);
    for (std::size_t m = 0; m < patterns; ++m) {
      for_own_pixels(face, [&](std::size_t k, std::size_t of_all) {
        result[m * mine + k] = values[m * all + of_all];
      });
    }
    return result;
  }

  struct Answer {
    std::unique_ptr<BatchField> phi, lambda;
    std::vector<double> exitance;
    CoefficientPair gradient;
  };
  static Answer answer(const DiffusionOperator& op, const std::vector<double>& lit,
                       const std::vector<double>& by_exitance, double tolerance) {
    const SolveOptions options{tolerance, 500};
    const std::size_t cells = op.space().cells();
    Answer result{op.make_field(patterns),
                  op.make_field(patterns),
                  std::vector<double>(patterns * op.exitance_size()),
                  {std::vector<double>(cells, 0.0), std::vector<double>(cells, 0.0)}};
    const auto b = op.make_field(patterns);
    op.load(lit, *b);
    EXPECT_EQ(op.solve(*b, *result.phi, options).termination, Termination::converged);
    op.exitance(*result.phi, lit, result.exitance);
    op.exitance_transpose(by_exitance, *b);
    EXPECT_EQ(op.solve(*b, *result.lambda, options).termination, Termination::converged);
    op.add_gradient({*result.phi, lit, result.exitance}, *result.lambda, by_exitance,
                    result.gradient);
    return result;
  }

  std::shared_ptr<const BlockPieces> pieces;
  std::unique_ptr<DiffusionOperator> whole, piece;
  std::vector<double> kappa, mu, light, weights;
};

double norm(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double v : values) squares += v * v;
  return std::sqrt(squares);
}

TEST_P(DistributedOperator, ExitanceAndGradientAreThoseOfTheReference) {
  const auto lit = of_piece_face(setup().lit_face, light);
  const auto by_exitance = of_piece_face(GetParam().seen, weights);
  const Answer expected = answer(*whole, light, weights, 1e-12);
  const Answer found = answer(*piece, lit, by_exitance, 1e-11);

  const std::size_t mine = piece->exitance_size(), all = whole->exitance_size();
  double worst = 0.0;
  for (std::size_t m = 0; m < patterns; ++m) {
    for_own_pixels(GetParam().seen, [&](std::size_t k, std::size_t of_all) {
      worst = std::max(
          worst, std::abs(found.exitance[m * mine + k] - expected.exitance[m * all + of_all]));
    });
  }
  const double scale = norm(expected.exitance) / std::sqrt(1.0 * expected.exitance.size());
  EXPECT_LE(worst, 1e-8 * scale);

  const auto compare = [&](const std::vector<double>& mine_of, const std::vector<double>& all_of) {
    const std::vector<double> should = of_piece(all_of);
    double error = 0.0;
    pieces->for_own([&](std::size_t i, std::size_t) {
      error = std::max(error, std::abs(mine_of[i] - should[i]));
    });
    EXPECT_LE(error, 1e-7 * norm(all_of) / std::sqrt(1.0 * all_of.size()));
  };
  compare(found.gradient.log_kappa, expected.gradient.log_kappa);
  compare(found.gradient.log_mu, expected.gradient.log_mu);
}

TEST_P(DistributedOperator, TangentIsTheTransposeOfTheGradient) {
  const auto lit = of_piece_face(setup().lit_face, light);
  const auto by_exitance = of_piece_face(GetParam().seen, weights);
  const Answer at = answer(*piece, lit, by_exitance, 1e-12);
  std::mt19937_64 random(77);
  std::normal_distribution<double> normal;
  CoefficientPair direction{kappa, mu};
  for (double& v : direction.log_kappa) v = normal(random);
  for (double& v : direction.log_mu) v = normal(random);
  const CoefficientPair mine{of_piece(direction.log_kappa), of_piece(direction.log_mu)};

  const auto b = piece->make_field(patterns), change = piece->make_field(patterns);
  std::vector<double> direct(at.exitance.size()), by_fluence(at.exitance.size());
  piece->linearise({*at.phi, lit, at.exitance}, mine, *b, direct);
  piece->solve(*b, *change, {1e-12, 500});
  piece->exitance(*change, std::vector<double>(lit.size(), 0.0), by_fluence);
  double forward = 0.0, backward = 0.0;
  for (std::size_t i = 0; i < direct.size(); ++i) {
    forward += by_exitance[i] * (direct[i] + by_fluence[i]);
  }
  pieces->for_own([&](std::size_t i, std::size_t) {
    backward +=
        at.gradient.log_kappa[i] * mine.log_kappa[i] + at.gradient.log_mu[i] * mine.log_mu[i];
  });
  forward = pieces->sum(forward);
  backward = pieces->sum(backward);
  EXPECT_NEAR(forward, backward, 1e-8 * std::abs(backward));
}

GridSetup block(int nx, int ny, int nz, Face lit, Sides sides, SourceModel source) {
  return {{nx, ny, nz, 0.31}, 1.37, lit, sides, source, Convention::physical};
}

INSTANTIATE_TEST_SUITE_P(
    Blocks, DistributedOperator,
    testing::Values(Case{"lit from below, seen from above",
                         block(13, 11, 7, Face::z_minus, Sides::open, SourceModel::first_collision),
                         Face::z_plus, 30.0},
                    Case{"mirror sides, diffuse light, seen where it is lit, contrast 1e4",
                         block(10, 9, 8, Face::z_plus, Sides::mirror, SourceModel::boundary),
                         Face::z_plus, 1e4},
                    Case{"lit along x, seen from a side, contrast 1e4",
                         block(6, 12, 9, Face::x_plus, Sides::open, SourceModel::first_collision),
                         Face::y_minus, 1e4}));

TEST(BlockPieces, MoreRanksThanColumnsAreRefused) {
  int ranks = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  const auto make = [](int nx) {
    return BlockPieces(PETSC_COMM_WORLD, block(nx, 1, 9, Face::z_minus, Sides::open, {}));
  };
  EXPECT_NO_THROW(make(ranks));
  if (ranks > 1) {
    EXPECT_THROW(make(ranks - 1), InputError);
  }
}

}  // namespace
}  // namespace kappamu::forward::distributed

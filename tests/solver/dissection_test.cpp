// SPDX-License-Identifier: MIT
#include "physics/solver/dissection.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <random>
#include <string>

#include "physics/solver/block_ldlt.h"

namespace skerry {
namespace dissection_test {

using Edges = std::vector<std::array<int, 2>>;

struct Net {
  int nodes = 0;
  Edges edges;
  std::vector<Vec2> places;
};

// Squares; turned, at a place, of a size.
Net make_net(int columns, int rows, double angle = 0, Vec2 origin = {}, double size = 1) {
  Net net;
  net.nodes = columns * rows;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int node = j * columns + i;
      if (i + 1 < columns) net.edges.push_back({node, node + 1});
      if (j + 1 < rows) net.edges.push_back({node, node + columns});
      net.places.push_back(origin + size * Vec2{std::cos(angle) * i - std::sin(angle) * j,
                                                std::sin(angle) * i + std::cos(angle) * j});
    }
  }
  return net;
}

// A body stands on two of the row below.
Net make_pyramid(int base) {
  Net net;
  for (int row = 0; row < base; ++row) {
    for (int i = 0; i < base - row; ++i) {
      const int node = net.nodes++;
      if (row > 0) {
        net.edges.push_back({node, node - (base - row + 1)});
        net.edges.push_back({node, node - (base - row)});
      }
      net.places.push_back({i + 0.5 * row, 1.0 * row});
    }
  }
  return net;
}

BlockPattern analysed(const Net& net, bool with_places) {
  BlockPattern pattern;
  pattern.analyse(net.nodes, net.edges, with_places ? std::span<const Vec2>(net.places) : std::span<Vec2>{});
  return pattern;
}

void expect_order(const BlockPattern& pattern) {
  std::vector<int> order = pattern.order();
  for (int i = 0; i < pattern.nodes(); ++i)
    ASSERT_EQ(pattern.position(order[static_cast<std::size_t>(i)]), i);
  std::sort(order.begin(), order.end());
  for (int i = 0; i < pattern.nodes(); ++i) ASSERT_EQ(order[static_cast<std::size_t>(i)], i);
}

/// Updates with places over those without.
double saving(const Net& net) {
  const BlockPattern by_degree = analysed(net, false), by_places = analysed(net, true);
  expect_order(by_places);
  return static_cast<double>(by_places.updates()) / static_cast<double>(by_degree.updates());
}

TEST(Dissection, SavesUpdatesWhereBodiesStandInRows) {
  EXPECT_LT(saving(make_net(100, 100)), 0.6);
  EXPECT_LT(saving(make_net(70, 70, 0.3)), 0.8);
  EXPECT_LT(saving(make_net(60, 60, 0, {1e9, -1e9})), 0.7);
  EXPECT_LT(saving(make_net(60, 60, 0, {}, 1e-9)), 0.7);
  EXPECT_LT(saving(make_pyramid(100)), 0.81);
}

TEST(Dissection, NeverTakesMoreUpdatesThanMinimumDegree) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    Net net;
    net.nodes = 1 + static_cast<int>((seed % 5 == 0 ? 300 : 1500) * unit(random));
    // Places in clusters, in lines or the same for all; edges between any or only between near ones.
    const double spread = seed % 3 == 0 ? 0 : 1, height = seed % 4 == 0 ? 0 : 1;
    for (int i = 0; i < net.nodes; ++i)
      net.places.push_back({spread * std::floor(30 * unit(random)), spread * height * 30 * unit(random)});
    std::uniform_int_distribution<int> any(0, net.nodes - 1);
    for (int k = 0; k < 6 * net.nodes; ++k) {
      const auto a = any(random), b = any(random);
      const Vec2 apart = net.places[static_cast<std::size_t>(a)] - net.places[static_cast<std::size_t>(b)];
      if (a != b && (seed % 5 == 0 || length(apart) < 4) && k < (seed % 5 == 0 ? 2 : 6) * net.nodes)
        net.edges.push_back({a, b});
    }
    const BlockPattern by_degree = analysed(net, false), by_places = analysed(net, true);
    expect_order(by_places);
    EXPECT_LE(by_places.updates(), by_degree.updates())
        << net.nodes << " nodes, " << net.edges.size() << " edges";
  }
}

TEST(Dissection, OrdersWhatHasNoEdgesAndBodiesInOnePlace) {
  for (const int nodes : {0, 1, 2, 10, 11, 500}) {
    const std::vector<int> none(static_cast<std::size_t>(nodes), 0);
    std::vector<int> position(none), order;
    std::iota(position.begin(), position.end(), 0);
    const std::vector<Vec2> places(none.size(), Vec2{3, 4});
    dissect({none, none, {}}, places, position, order);
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order, position) << nodes;
  }
}

TEST(Dissection, IsLeftAloneWithoutFinitePlaces) {
  Net net = make_net(60, 60);
  const BlockPattern by_degree = analysed(net, false);
  EXPECT_NE(by_degree.order(), analysed(net, true).order());
  for (const double wrong :
       {std::numeric_limits<double>::quiet_NaN(), 1e308, -std::numeric_limits<double>::infinity()}) {
    net.places[77].y = wrong;
    EXPECT_EQ(by_degree.order(), analysed(net, true).order()) << wrong;
  }
  net.places.pop_back();
  EXPECT_EQ(by_degree.order(), analysed(net, true).order());
}

TEST(Dissection, GivesTheSameOrderAgain) {
  Net net = make_net(60, 60, 0.1);
  const std::vector<int> order = analysed(net, true).order();
  std::mt19937 random(1);
  std::shuffle(net.edges.begin(), net.edges.end(), random);
  EXPECT_EQ(order, analysed(net, true).order());
}

}  // namespace dissection_test
}  // namespace skerry

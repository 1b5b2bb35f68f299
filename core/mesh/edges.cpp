#include "core/mesh/edges.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace kappamu {

std::vector<Edge> edges_of(const std::vector<Triangle>& triangles) {
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = triangles[t][k], to = triangles[t][(k + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), static_cast<int>(t), from < to});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return edges;
}

Orientation oriented_alike(const std::vector<Triangle>& triangles) {
  const std::vector<Edge> edges = edges_of(triangles);
  // Neighbours of each triangle across edges of two, three at the most.
  struct Neighbour {
    Edge edge;
    int triangle = 0;
    bool agrees = false;
  };
  std::vector<int> first(triangles.size() + 1);
  std::vector<Neighbour> list;
  for_each_edge(edges, [&](std::size_t begin, std::size_t end) {
    if (end - begin != 2) return;
    ++first[static_cast<std::size_t>(edges[begin].triangle) + 1];
    ++first[static_cast<std::size_t>(edges[begin + 1].triangle) + 1];
  });
  for (std::size_t t = 0; t < triangles.size(); ++t) first[t + 1] += first[t];
  list.resize(static_cast<std::size_t>(first.back()));
  std::vector<int> next(first.begin(), first.end() - 1);
  for_each_edge(edges, [&](std::size_t begin, std::size_t end) {
    if (end - begin != 2) return;
    const Edge &one = edges[begin], &two = edges[begin + 1];
    const bool agrees = one.rises != two.rises;
    const auto add = [&](int to, int other) {
      list[static_cast<std::size_t>(next[static_cast<std::size_t>(to)]++)] = {one, other, agrees};
    };
    add(one.triangle, two.triangle);
    add(two.triangle, one.triangle);
  });

  Orientation found;
  found.turned.resize(triangles.size());
  found.component.assign(triangles.size(), -1);
  std::vector<int> waiting;
  for (std::size_t start = 0; start < triangles.size(); ++start) {
    if (found.component[start] >= 0) continue;
    found.component[start] = found.components;
    waiting.push_back(static_cast<int>(start));
    while (!waiting.empty()) {
      const auto here = static_cast<std::size_t>(waiting.back());
      waiting.pop_back();
      for (int i = first[here]; i < first[here + 1]; ++i) {
        const Neighbour& neighbour = list[static_cast<std::size_t>(i)];
        const auto there = static_cast<std::size_t>(neighbour.triangle);
        const bool turn = found.turned[here] == neighbour.agrees;
        if (found.component[there] < 0) {
          found.component[there] = found.components;
          found.turned[there] = turn;
          waiting.push_back(neighbour.triangle);
        } else if (found.turned[there] != turn && !found.one_sided) {
          found.one_sided = neighbour.edge;
        }
      }
    }
    ++found.components;
  }
  return found;
}

std::optional<Edge> unbalanced_edge(const std::vector<Triangle>& triangles,
                                    const std::vector<int>& component) {
  const std::vector<Edge> edges = edges_of(triangles);
  std::optional<Edge> found;
  for_each_edge(edges, [&](std::size_t begin, std::size_t end) {
    if (end - begin <= 2 || found) return;
    std::map<int, int> balance;  // by component
    for (std::size_t i = begin; i < end; ++i) {
      balance[component[static_cast<std::size_t>(edges[i].triangle)]] += edges[i].rises ? 1 : -1;
    }
    for (const auto& [piece, sum] : balance) {
      if (sum != 0) found = edges[begin];
    }
  });
  return found;
}

std::size_t turn_caps(TriangleMesh& mesh, const std::vector<bool>& flat) {
  const auto length = [&](int a, int b) {
    return (mesh.vertices[static_cast<std::size_t>(a)] - mesh.vertices[static_cast<std::size_t>(b)])
        .norm();
  };
  const auto opposite = [&](const Edge& edge) {
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(edge.triangle)];
    return *std::find_if(t.begin(), t.end(),
                         [&](int v) { return v != edge.low && v != edge.high; });
  };
  const std::vector<Edge> edges = edges_of(mesh.triangles);
  std::vector<bool> touched(mesh.triangles.size());
  std::size_t turned = 0;
  for_each_edge(edges, [&](std::size_t begin, std::size_t end) {
    if (end - begin != 2) return;
    const bool first = flat[static_cast<std::size_t>(edges[begin].triangle)];
    const Edge& cap = edges[first ? begin : begin + 1];
    const Edge& neighbour = edges[first ? begin + 1 : begin];
    const auto t = static_cast<std::size_t>(cap.triangle);
    const auto u = static_cast<std::size_t>(neighbour.triangle);
    if (!flat[t] || flat[u] || touched[t] || touched[u]) return;
    const int c = opposite(cap), d = opposite(neighbour);
    if (length(c, cap.low) > length(cap.low, cap.high)) return;
    if (length(c, cap.high) > length(cap.low, cap.high)) return;
    const int from = cap.rises ? cap.low : cap.high, to = cap.rises ? cap.high : cap.low;
    mesh.triangles[t] = {from, d, c};
    mesh.triangles[u] = {d, to, c};
    touched[t] = touched[u] = true;
    ++turned;
  });
  return turned;
}

}  // namespace kappamu

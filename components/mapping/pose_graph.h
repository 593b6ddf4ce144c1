// Pose graph optimisation: the poses that agree best with all measurements between them (Lu and
// Milios 1997; Grisetti et al. 2010, "A tutorial on graph-based SLAM"). Pure.
//
// Each edge is a measured relative pose with its information. Gauss-Newton minimises the sum of all
// squared errors, weighted by information: linearised, the edges are a sparse symmetric system with
// three unknowns per pose, which Eigen solves by a Cholesky decomposition. Edges with large errors
// count less (Cauchy's weights), so that a wrong edge among many cannot bend the map. A correct
// loop also has a large error when it is closed for the first time; therefore all edges count fully
// at first, and the limit decreases from round to round (graduated non-convexity: Yang, Antonante,
// Tzoumas, Carlone 2020). The first pose is fixed.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "components/mapping/scan_match.h"

namespace rack::mapping {

struct Edge {
  std::size_t from;
  std::size_t to;
  Pose step;                // pose of `to` in the frame of `from`
  Information information;  // in the frame of `from`
};

// The squared error of an edge for these poses.
double disagreement(const Edge& edge, std::span<const Pose> poses);

enum class Doubt { kNotAtFirst, kAlways };

// Optimises the poses. False: there is no solution, and they are unchanged. Each pose must be
// connected to the first one by edges.
bool optimise(std::span<const Edge> edges, std::vector<Pose>& poses, Doubt doubt);

// How far each pose can be wrong by what the edges know: its standard deviation, mm, in the frame
// that fits all poses best. Long drives without loops bend; nothing contradicts a map that is bent
// evenly, but its edges allow many such maps. Estimated from poses that are drawn at random from
// what the edges allow. Empty: there is no solution.
std::vector<double> spread(std::span<const Edge> edges, std::span<const Pose> poses);

}  // namespace rack::mapping

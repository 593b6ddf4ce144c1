// Poses that agree best with all that was measured between them (Lu and Milios 1997; Grisetti et
// al. 2010, "A tutorial on graph-based SLAM"). Pure.
//
// Each edge says where one pose is seen from another, and how sure that is. The sum of all squared
// disagreements, by their information, is made small by Gauss-Newton: linearised, the edges are a
// sparse symmetric system of three unknowns a pose, which Eigen solves by a Cholesky decomposition.
// Edges that disagree much with the others count less (Cauchy's weights), so that a wrong one among
// many cannot bend the map. A loop that is closed for the first time disagrees with everything, and
// is right: then all edges count fully at first, and the limit comes down from round to round
// (graduated non-convexity: Yang, Antonante, Tzoumas, Carlone 2020). The first pose stays where it
// is.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "components/mapping/scan_match.h"

namespace rack::mapping {

struct Edge {
  std::size_t from;
  std::size_t to;
  Pose step;                // `to` as seen from `from`
  Information information;  // in the frame of `from`
};

// The squared disagreement of an edge with the poses.
double disagreement(const Edge& edge, std::span<const Pose> poses);

enum class Doubt { kNotAtFirst, kAlways };

// Changes the poses. False: there is no solution, and they are as before. Each pose must hang on
// the first one by some edges.
bool optimise(std::span<const Edge> edges, std::vector<Pose>& poses, Doubt doubt);

}  // namespace rack::mapping

// SPDX-License-Identifier: BSD-3-Clause
//
// The rules of the body (SurfaceConversion.cpp) and those of the layers above disagree by more than a thin first layer.
// So what the body rules changed is carried into the layers:
//
//   net_k <- layerRule(mesh_k) + w(d_k) (bodyNet - layerRule(mesh_0)),   w = max(0, 1 - d / (r h))
//
// d is the distance along the block edges that rise from the vertex, h the mean length of the surface's edges there, r the
// propagation range. Where these edges end sooner, so does w.
#include "Converter.h"

#include <algorithm>

namespace bsv
{

void Converter::propagateFeet()
{
  const auto given = [](const std::vector<const double*>& arrays) {
    return std::any_of(arrays.begin(), arrays.end(), [](const double* array) { return array != nullptr; });
  };
  if (this->Options.propagationRange == 0.0 ||
    (!this->Options.body && !given(this->Options.projectedPoints) && !given(this->Options.surfaceNormals)))
  {
    return;
  }
  // Collected first: the layer rule below must not see corrections.
  std::map<int, std::vector<Correction>> all;
  for (int v = 0; v < static_cast<int>(this->Complex.vertices.size()); ++v)
  {
    if (!this->Complex.vertices[v].boundary)
    {
      continue;
    }
    Star star = this->makeStar(v);
    this->convertSurface(star);
    const StackAxes axes = this->stackAxes(star);
    if (!star.hasFoot || axes.up < 0 || axes.down >= 0)
    {
      continue;
    }
    const Star::EdgeInfo& info = star.info[axes.up];
    Fan delta = this->starLayer(star, axes.up, 0);
    delta.center = star.center - delta.center;
    std::vector<double> lengths;
    for (int i = 0; i < delta.spokeCount(); ++i)
    {
      delta.spokes[i] = star.edgePoints[info.spokes[i]] - delta.spokes[i];
      lengths.push_back((star.edges[info.spokes[i]].point - star.point).norm());
    }
    for (int i = 0; i < delta.sectorCount(); ++i)
    {
      const int face = star.blocks[info.sectors[i]].faces[info.fan->sectors[i].along];
      delta.sectors[i] = star.facePoints[face] - delta.sectors[i];
    }
    std::sort(lengths.begin(), lengths.end()); // any numbering gives the same bits
    double reach = 0.0;
    for (const double length : lengths)
    {
      reach += this->Options.propagationRange * length / static_cast<double>(lengths.size());
    }

    // The chain of edges above the vertex, with the distance of every layer.
    struct Link
    {
      int edge;
      int end;
      Fan delta;
      std::vector<double> distances;
    };
    std::vector<Link> chain{ { star.edges[axes.up].edge, star.edges[axes.up].end, delta, {} } };
    double distance = 0.0;
    while (true)
    {
      Link& link = chain.back();
      const ComplexEdge& edge = this->Complex.edges[link.edge];
      const EdgeFan& fan = this->Rules.edges[link.edge].fans.front();
      const ComplexBlock& owner = this->Complex.blocks[fan.sectors.front().block];
      const auto pointAt = [&](int k) {
        return owner.points(fan.sectors.front().point(owner, link.end == 0 ? k : edge.cells - k, 0, 0));
      };
      link.distances.assign(edge.cells + 1, 0.0);
      for (int k = 0; k <= edge.cells; ++k)
      {
        distance += k > 0 ? (pointAt(k) - pointAt(k - 1)).norm() : 0.0;
        link.distances[link.end == 0 ? k : edge.cells - k] = distance;
      }
      const int top = edge.vertices[1 - link.end];
      if (distance >= reach || this->Complex.vertices[top].boundary || chain.size() > this->Complex.edges.size())
      {
        break;
      }
      const Star above = this->makeStar(top);
      int down = 0;
      while (above.edges[down].edge != link.edge || above.edges[down].end != 1 - link.end)
      {
        ++down;
      }
      int up = 0;
      while (up < static_cast<int>(above.edges.size()) && (up == down || !this->areStacked(above, up, down)))
      {
        ++up;
      }
      if (up == static_cast<int>(above.edges.size()))
      {
        break;
      }
      // The next edge has a fan order of its own.
      const Star::EdgeInfo& from = above.info[down];
      const Star::EdgeInfo& to = above.info[up];
      Link next{ above.edges[up].edge, above.edges[up].end, link.delta, {} };
      for (int i = 0; i < next.delta.spokeCount(); ++i)
      {
        const std::size_t at = std::find(from.spokes.begin(), from.spokes.end(), to.spokes[i]) - from.spokes.begin();
        next.delta.spokes[i] = link.delta.spokes[at];
      }
      for (int i = 0; i < next.delta.sectorCount(); ++i)
      {
        const auto& pair = above.faces[above.blocks[to.sectors[i]].faces[to.fan->sectors[i].along]].blocks;
        const int block = pair[0] == to.sectors[i] ? pair[1] : pair[0];
        const std::size_t at = std::find(from.sectors.begin(), from.sectors.end(), block) - from.sectors.begin();
        next.delta.sectors[i] = link.delta.sectors[at];
      }
      chain.push_back(next);
    }
    reach = std::min(reach, distance);
    for (const Link& link : chain)
    {
      Correction correction{ link.delta, {} };
      for (const double d : link.distances)
      {
        correction.weights.push_back(std::max(0.0, 1.0 - d / reach));
      }
      all[link.edge].push_back(correction);
    }
  }
  this->Corrections = std::move(all);
}

} // namespace bsv

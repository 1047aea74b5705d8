// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/BodyPropagation.h"

#include "Base/SortedSum.h"
#include "Conversion/SurfaceConversion.h"
#include "Ranks/OwnedValues.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

namespace bsv
{

namespace
{

/// A run of layers across one edge above an extraordinary body vertex, from one end of the edge to the other.
struct Link
{
  int edge = -1;
  int end = 0; ///< of the edge where the run starts
  Fan delta;
  std::vector<double> distances; ///< per layer, in the edge's order
};

/// A message of numbers, read as it was written.
class Numbers
{
public:
  explicit Numbers(std::vector<double> values = {})
    : Values(std::move(values))
  {
  }
  void put(double value) { this->Values.push_back(value); }
  double get() { return this->Values[this->Next++]; }
  bool atEnd() const { return this->Next == this->Values.size(); }
  std::vector<double> values() && { return std::move(this->Values); }

  void put(const Fan& fan)
  {
    this->put(fan.closed ? 1.0 : 0.0);
    this->put(static_cast<double>(fan.spokes.size()));
    this->put(static_cast<double>(fan.sectors.size()));
    const auto putPoint = [&](const Vec3& x) { this->Values.insert(this->Values.end(), x.data(), x.data() + 3); };
    putPoint(fan.center);
    std::for_each(fan.spokes.begin(), fan.spokes.end(), putPoint);
    std::for_each(fan.sectors.begin(), fan.sectors.end(), putPoint);
  }
  Fan getFan()
  {
    Fan fan;
    fan.closed = this->get() != 0.0;
    fan.spokes.resize(static_cast<std::size_t>(this->get()));
    fan.sectors.resize(static_cast<std::size_t>(this->get()));
    const auto getPoint = [&](Vec3& x) {
      x = Vec3(this->Values.data() + this->Next);
      this->Next += 3;
    };
    getPoint(fan.center);
    std::for_each(fan.spokes.begin(), fan.spokes.end(), getPoint);
    std::for_each(fan.sectors.begin(), fan.sectors.end(), getPoint);
    return fan;
  }

private:
  std::vector<double> Values;
  std::size_t Next = 0;
};

/// The first above a boundary vertex, or nothing, and the range of what is carried along it.
std::optional<std::pair<Link, double>> firstLink(const ConversionContext& context, int vertex)
{
  Star star = makeStar(context, vertex);
  convertSurface(context, star);
  const StackAxes axes = stackAxes(context, star);
  if (!star.hasFoot || axes.up < 0 || axes.down >= 0)
  {
    return {};
  }
  const Star::EdgeInfo& info = star.info[axes.up];
  Fan delta = starLayer(context, star, axes.up, 0);
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
  return std::make_pair(Link{ star.edges[axes.up].edge, star.edges[axes.up].end, delta, {} },
    propagationReach(context.options, std::move(lengths)));
}

/// Fills the link's distances, which start at `distance`; the link that continues it, if there is one.
std::optional<Link> measure(const ConversionContext& context, Link& link, double distance, double range)
{
  const ComplexEdge& edge = context.complex.edges[link.edge];
  const FanSector& sector = context.rules.edges[link.edge].fans.front().sectors.front();
  const ComplexBlock& owner = context.complex.blocks[sector.block];
  const auto pointAt = [&](
                         int k) { return owner.points(sector.point(owner, link.end == 0 ? k : edge.cells - k, 0, 0)); };
  link.distances.assign(edge.cells + 1, 0.0);
  for (int k = 0; k <= edge.cells; ++k)
  {
    distance += k > 0 ? (pointAt(k) - pointAt(k - 1)).norm() : 0.0;
    link.distances[link.end == 0 ? k : edge.cells - k] = distance;
  }
  const int top = edge.vertices[1 - link.end];
  if (distance >= range || context.complex.vertices[top].boundary)
  {
    return {};
  }
  const Star above = makeStar(context, top);
  int down = 0;
  while (above.edges[down].edge != link.edge || above.edges[down].end != 1 - link.end)
  {
    ++down;
  }
  int up = 0;
  while (up < static_cast<int>(above.edges.size()) && (up == down || !areStacked(context, above, up, down)))
  {
    ++up;
  }
  if (up == static_cast<int>(above.edges.size()))
  {
    return {};
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
  return next;
}

/// Whether the boundary where the link ends may move with the layers below it.
bool endMoves(const ConversionContext& context, const Link& link)
{
  const int top = context.complex.edges[link.edge].vertices[1 - link.end];
  if (!context.complex.vertices[top].boundary)
  {
    return false;
  }
  const Star star = makeStar(context, top);
  const StackAxes axes = stackAxes(context, star);
  if (axes.up < 0 || axes.down >= 0 || star.edges[axes.up].edge != link.edge || star.edges[axes.up].end == link.end)
  {
    return false;
  }
  const bool free = std::all_of(star.faces.begin(), star.faces.end(), [&](const VertexStar::Face& face) {
    const FaceRule& rule = context.rules.faces[face.face];
    return !face.boundary || (rule.role == BoundaryRole::Other && !rule.planar());
  });
  return free && std::all_of(star.edges.begin(), star.edges.end(), [&](const VertexStar::Edge& edge) {
    return !edge.boundary || !context.rules.edges[edge.edge].anchored;
  });
}

} // namespace

double propagationReach(const ConversionOptions& options, std::vector<double> lengths)
{
  for (double& length : lengths)
  {
    length = options.propagationRange * length / static_cast<double>(lengths.size());
  }
  return sortedSum(std::move(lengths));
}

void moveEnd(const ConversionContext& context, Star& star)
{
  for (std::size_t e = 0; e < star.edges.size(); ++e)
  {
    const VertexStar::Edge& edge = star.edges[e];
    const auto corrections = context.corrections.find(edge.edge);
    if (corrections == context.corrections.end())
    {
      continue;
    }
    for (const LayerCorrection& correction : corrections->second)
    {
      if (correction.movedEnd != edge.end)
      {
        continue;
      }
      const Star::EdgeInfo& info = star.info[e];
      const double weight = edge.end == 0 ? correction.weights.front() : correction.weights.back();
      star.center += weight * correction.delta.center;
      for (std::size_t i = 0; i < info.spokes.size(); ++i)
      {
        star.edgePoints[info.spokes[i]] += weight * correction.delta.spokes[i];
      }
      for (std::size_t i = 0; i < info.sectors.size(); ++i)
      {
        const int face = star.blocks[info.sectors[i]].faces[info.fan->sectors[i].along];
        star.facePoints[face] += weight * correction.delta.sectors[i];
      }
    }
  }
}

LayerCorrections bodyCorrections(const ConversionContext& context, const Ranks& ranks)
{
  LayerCorrections result;
  if (context.options.propagationRange == 0.0 ||
    (!context.options.body && context.given.points.empty() && context.given.normals.empty()))
  {
    return result;
  }
  const auto putLink = [](Numbers& numbers, const Link& link) {
    numbers.put(link.edge);
    numbers.put(link.end);
    numbers.put(link.delta);
  };
  const auto getLink = [](Numbers& numbers) {
    Link link;
    link.edge = static_cast<int>(numbers.get());
    link.end = static_cast<int>(numbers.get());
    link.delta = numbers.getFan();
    return link;
  };

  // The chain of edges above each vertex.
  struct Chain
  {
    double range;
    double distance;
    bool endMoves;
    std::vector<Link> links;
  };
  std::vector<int> vertices;
  for (int v = 0; v < static_cast<int>(context.complex.vertices.size()); ++v)
  {
    if (context.complex.vertices[v].boundary)
    {
      vertices.push_back(v);
    }
  }
  const auto starts = gatherListsFromOwners<double>(
    ranks, vertices.size(),
    [&](std::size_t i) {
      return context.complex.blocks[context.complex.vertices[vertices[i]].corners.front().block].rank;
    },
    [&](std::size_t i) {
      Numbers numbers;
      if (const auto first = firstLink(context, vertices[i]))
      {
        numbers.put(first->second);
        putLink(numbers, first->first);
      }
      return std::move(numbers).values();
    });
  std::vector<Chain> chains;
  for (const std::vector<double>& start : starts)
  {
    if (!start.empty())
    {
      Numbers numbers(start);
      const double range = numbers.get();
      chains.push_back({ range, 0.0, false, { getLink(numbers) } });
    }
  }
  // All chains grow by one edge at a time.
  std::vector<std::size_t> growing(chains.size());
  std::iota(growing.begin(), growing.end(), 0);
  while (!growing.empty())
  {
    const auto steps = gatherListsFromOwners<double>(
      ranks, growing.size(),
      [&](std::size_t i) {
        const Link& link = chains[growing[i]].links.back();
        return context.complex.blocks[context.rules.edges[link.edge].fans.front().sectors.front().block].rank;
      },
      [&](std::size_t i) {
        const Chain& chain = chains[growing[i]];
        Link link = chain.links.back();
        const auto next = measure(context, link, chain.distance, chain.range);
        Numbers numbers(link.distances);
        numbers.put(!next && endMoves(context, link) ? 1.0 : 0.0);
        if (next && chain.links.size() <= context.complex.edges.size())
        {
          putLink(numbers, *next);
        }
        return std::move(numbers).values();
      });
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < growing.size(); ++i)
    {
      Chain& chain = chains[growing[i]];
      Link& link = chain.links.back();
      Numbers numbers(steps[i]);
      link.distances.resize(context.complex.edges[link.edge].cells + 1);
      std::generate(link.distances.begin(), link.distances.end(), [&] { return numbers.get(); });
      chain.endMoves = numbers.get() != 0.0;
      chain.distance = link.end == 0 ? link.distances.back() : link.distances.front();
      if (!numbers.atEnd())
      {
        chain.links.push_back(getLink(numbers));
        left.push_back(growing[i]);
      }
    }
    growing = std::move(left);
  }
  for (const Chain& chain : chains)
  {
    const double range = chain.endMoves ? chain.range : std::min(chain.range, chain.distance);
    for (const Link& link : chain.links)
    {
      LayerCorrection correction{ link.delta, {}, -1 };
      for (const double d : link.distances)
      {
        correction.weights.push_back(std::max(0.0, 1.0 - d / range));
      }
      if (chain.endMoves && &link == &chain.links.back())
      {
        correction.movedEnd = 1 - link.end;
      }
      result[link.edge].push_back(correction);
    }
  }
  return result;
}

} // namespace bsv

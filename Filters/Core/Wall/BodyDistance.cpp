// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/BodyDistance.h"

#include "Base/Numbers.h"
#include "Mesh/BlockTopology.h"
#include "Ranks/Ranks.h"
#include "Volume/FaceGeometry.h"

#include <algorithm>
#include <optional>
#include <vector>

namespace bsv
{
namespace
{

struct Candidate
{
  double distance;
  Triple where;
  double inEdges;
};

/// Whether `a` is what is reported of the two.
bool isFarther(const Candidate& a, const Candidate& b)
{
  return a.distance > b.distance || (a.distance == b.distance && a.where < b.where);
}

/// A span of a face: the farthest of its corners and its centre.
struct Span
{
  Candidate farthest;
  std::size_t face;
  std::array<int, 2> at;
  /// Mean length of its chords.
  double edge;
};

void keepFarther(std::optional<Candidate>& worst, const Candidate& candidate)
{
  if (!worst || isFarther(candidate, *worst))
  {
    worst = candidate;
  }
}

/// Distances at the corners and centres of all spans of a face.
void addSpans(
  const VolumeFace& face, std::size_t number, const BodySurface& body, const Execution& run, std::vector<Span>& spans)
{
  const FaceGeometry geometry = faceGeometry(*face.volume, face.face, 2, run);
  const int ns = geometry.samples[0], nt = geometry.samples[1];
  const auto index = [&](int s, int t) { return s + std::size_t(ns) * t; };
  const auto at = [&](int s, int t) -> const Vec3& { return geometry.points[index(s, t)]; };
  std::vector<Vec3> samples;
  std::vector<std::size_t> sampleAt(geometry.points.size());
  for (int t = 0; t < nt; ++t)
  {
    for (int s = t % 2; s < ns; s += 2)
    {
      sampleAt[index(s, t)] = samples.size();
      samples.push_back(at(s, t));
    }
  }
  const std::vector<BodyPoint> found = body.closestPoints(samples, run);
  for (int t = 0; t + 2 < nt; t += 2)
  {
    for (int s = 0; s + 2 < ns; s += 2)
    {
      const double edge = ((at(s + 2, t) - at(s, t)).norm() + (at(s + 2, t + 2) - at(s, t + 2)).norm() +
                            (at(s, t + 2) - at(s, t)).norm() + (at(s + 2, t + 2) - at(s + 2, t)).norm()) /
        4.0;
      std::optional<Candidate> worst;
      for (const auto& [ds, dt] : { std::array<int, 2>{ 1, 1 }, { 0, 0 }, { 2, 0 }, { 0, 2 }, { 2, 2 } })
      {
        const std::size_t i = sampleAt[index(s + ds, t + dt)];
        keepFarther(worst, { found[i].distance, triple(samples[i]), edge > 0.0 ? found[i].distance / edge : 0.0 });
      }
      spans.push_back({ *worst, number, { s / 2, t / 2 }, edge });
    }
  }
}

/// Samples in and around a span, more of them.
std::vector<Vec3> finerSamples(const VolumeFace& face, const std::array<int, 2>& span)
{
  constexpr int Parts = 8;
  const BSplineVolume& volume = *face.volume;
  Vec3 uvw;
  const int normal = faceDirection(face.face);
  const std::vector<double>& across = volume.knots[normal];
  const std::size_t degree = volume.degree[normal];
  uvw[normal] = faceSide(face.face) ? across[across.size() - 1 - degree] : across[degree];
  std::array<std::array<double, 2>, 2> ends;
  for (int axis = 0; axis < 2; ++axis)
  {
    const int d = faceAxis(face.face, axis);
    const int first = nonEmptySpans(volume.degree[d], volume.knots[d])[span[axis]];
    ends[axis] = { volume.knots[d][first], volume.knots[d][first + 1] };
  }
  std::vector<Vec3> samples;
  for (int t = 0; t <= Parts; ++t)
  {
    for (int s = 0; s <= Parts; ++s)
    {
      for (int axis = 0; axis < 2; ++axis)
      {
        const int part = axis == 0 ? s : t;
        uvw[faceAxis(face.face, axis)] = ((Parts - part) * ends[axis][0] + part * ends[axis][1]) / Parts;
      }
      samples.push_back(evaluate(volume, uvw));
    }
  }
  return samples;
}

} // namespace

BodyDistance bodyDistance(const std::vector<VolumeFace>& faces, const BodySurface& body, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  Execution alone = run;
  alone.ranks = aloneRank();
  std::vector<Span> spans;
  for (std::size_t f = 0; f < faces.size(); ++f)
  {
    alone.progress = [&](double) {
      return run.progress(0.5 * static_cast<double>(f) / static_cast<double>(faces.size()));
    };
    addSpans(faces[f], f, body, alone, spans);
  }
  // Where the wall is farthest there is a farther place between the samples.
  constexpr std::size_t FinerSpans = 256;
  std::vector<Candidate> farthestSpans;
  for (const Span& span : spans)
  {
    farthestSpans.push_back(span.farthest);
  }
  std::sort(farthestSpans.begin(), farthestSpans.end(), isFarther);
  farthestSpans.resize(std::min(farthestSpans.size(), FinerSpans));
  farthestSpans = ranks.gatherAll(farthestSpans);
  std::sort(farthestSpans.begin(), farthestSpans.end(), isFarther);
  farthestSpans.resize(std::min(farthestSpans.size(), FinerSpans));

  alone.progress = [&](double fraction) { return run.progress(0.5 + 0.5 * fraction); };
  std::optional<Candidate> worst;
  std::vector<Vec3> samples;
  std::vector<double> edges;
  for (const Span& span : spans)
  {
    keepFarther(worst, span.farthest);
    if (!isFarther(farthestSpans.back(), span.farthest))
    {
      const std::vector<Vec3> finer = finerSamples(faces[span.face], span.at);
      samples.insert(samples.end(), finer.begin(), finer.end());
      edges.resize(samples.size(), span.edge);
    }
  }
  const std::vector<BodyPoint> found = body.closestPoints(samples, alone);
  for (std::size_t i = 0; i < samples.size(); ++i)
  {
    keepFarther(worst, { found[i].distance, triple(samples[i]), edges[i] > 0.0 ? found[i].distance / edges[i] : 0.0 });
  }
  BodyDistance result;
  const std::vector<Candidate> all =
    ranks.gatherAll(std::vector<Candidate>(worst ? 1 : 0, worst.value_or(Candidate{})));
  const auto farthest = std::min_element(all.begin(), all.end(), isFarther);
  if (farthest != all.end())
  {
    result = { farthest->distance, vec3(farthest->where), farthest->inEdges };
  }
  return result;
}

} // namespace bsv

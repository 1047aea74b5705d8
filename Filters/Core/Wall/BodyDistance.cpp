// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/BodyDistance.h"

#include "Base/Numbers.h"
#include "Mesh/BlockTopology.h"
#include "Ranks/Ranks.h"
#include "Volume/FaceGeometry.h"

#include <algorithm>
#include <utility>
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
      const auto candidate = [&](int ds, int dt) {
        const std::size_t i = sampleAt[index(s + ds, t + dt)];
        return Candidate{ found[i].distance, triple(samples[i]), edge > 0.0 ? found[i].distance / edge : 0.0 };
      };
      const std::array<Candidate, 5> all{ candidate(1, 1), candidate(0, 0), candidate(2, 0), candidate(0, 2),
        candidate(2, 2) };
      spans.push_back({ *std::min_element(all.begin(), all.end(), isFarther), number, { s / 2, t / 2 }, edge });
    }
  }
}

/// Samples in and around a span, at `parts` + 1 places in both directions.
std::vector<Vec3> finerSamples(const VolumeFace& face, const std::array<int, 2>& span, int parts)
{
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
  for (int t = 0; t <= parts; ++t)
  {
    for (int s = 0; s <= parts; ++s)
    {
      for (int axis = 0; axis < 2; ++axis)
      {
        const int part = axis == 0 ? s : t;
        uvw[faceAxis(face.face, axis)] = ((parts - part) * ends[axis][0] + part * ends[axis][1]) / parts;
      }
      samples.push_back(evaluate(volume, uvw));
    }
  }
  return samples;
}

/// Candidate `count` of those of all ranks, the farthest first, or the last one.
Candidate farthestOf(const std::vector<Span>& spans, std::size_t count, const Ranks& ranks)
{
  std::vector<Candidate> candidates;
  const auto keepFarthest = [&] {
    std::sort(candidates.begin(), candidates.end(), isFarther);
    candidates.resize(std::min(candidates.size(), count));
  };
  for (const Span& span : spans)
  {
    candidates.push_back(span.farthest);
  }
  keepFarthest();
  candidates = ranks.gatherAll(candidates);
  keepFarthest();
  return candidates.empty() ? Candidate{} : candidates.back();
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
      return run.progress(0.8 * static_cast<double>(f) / static_cast<double>(faces.size()));
    };
    addSpans(faces[f], f, body, alone, spans);
  }
  run.report(0.8);
  // Where the wall is farthest there is a farther place between the samples: in so many spans so many parts are looked
  // at.
  for (const auto& [count, parts] : { std::pair<std::size_t, int>{ 32, 4 }, { 8, 8 } })
  {
    const Candidate last = farthestOf(spans, count, ranks);
    for (Span& span : spans)
    {
      const std::vector<Vec3> samples =
        isFarther(last, span.farthest) ? std::vector<Vec3>() : finerSamples(faces[span.face], span.at, parts);
      for (const Vec3& sample : samples)
      {
        const double distance = body.closestPoint(sample).distance;
        const Candidate candidate{ distance, triple(sample), span.edge > 0.0 ? distance / span.edge : 0.0 };
        span.farthest = isFarther(candidate, span.farthest) ? candidate : span.farthest;
      }
    }
  }
  std::vector<Candidate> worst;
  if (!spans.empty())
  {
    const auto isWorse = [](const Span& x, const Span& y) { return isFarther(x.farthest, y.farthest); };
    worst.push_back(std::min_element(spans.begin(), spans.end(), isWorse)->farthest);
  }
  BodyDistance result;
  const std::vector<Candidate> all = ranks.gatherAll(worst);
  const auto farthest = std::min_element(all.begin(), all.end(), isFarther);
  if (farthest != all.end())
  {
    result = { farthest->distance, vec3(farthest->where), farthest->inEdges };
  }
  return result;
}

} // namespace bsv

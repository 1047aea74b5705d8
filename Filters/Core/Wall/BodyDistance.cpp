// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/BodyDistance.h"

#include "Base/Numbers.h"
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

} // namespace

BodyDistance bodyDistance(const std::vector<VolumeFace>& faces, const BodySurface& body, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  std::optional<Candidate> worst;
  for (std::size_t f = 0; f < faces.size(); ++f)
  {
    Execution alone = run;
    alone.ranks = aloneRank();
    alone.progress = [&](double) { return run.progress(static_cast<double>(f) / static_cast<double>(faces.size())); };
    const FaceGeometry geometry = faceGeometry(*faces[f].volume, faces[f].face, 2, alone);
    const int ns = geometry.samples[0], nt = geometry.samples[1];
    const auto at = [&](int s, int t) -> const Vec3& { return geometry.points[s + std::size_t(ns) * t]; };
    std::vector<Vec3> samples;
    std::vector<std::array<int, 2>> places;
    for (int t = 0; t < nt; ++t)
    {
      for (int s = t % 2; s < ns; s += 2)
      {
        samples.push_back(at(s, t));
        places.push_back({ s, t });
      }
    }
    const std::vector<BodyPoint> found = body.closestPoints(samples, alone);
    for (std::size_t i = 0; i < samples.size(); ++i)
    {
      // The span that has the sample as its centre or first corner, the last span at the end.
      const int s = std::min(places[i][0] / 2 * 2, ns - 3), t = std::min(places[i][1] / 2 * 2, nt - 3);
      const double edge = ((at(s + 2, t) - at(s, t)).norm() + (at(s + 2, t + 2) - at(s, t + 2)).norm() +
                            (at(s, t + 2) - at(s, t)).norm() + (at(s + 2, t + 2) - at(s + 2, t)).norm()) /
        4.0;
      const Candidate candidate{ found[i].distance, triple(samples[i]), edge > 0.0 ? found[i].distance / edge : 0.0 };
      if (!worst || isFarther(candidate, *worst))
      {
        worst = candidate;
      }
    }
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

// SPDX-License-Identifier: BSD-3-Clause
#include "Volume/VolumeInterfaces.h"

#include "Base/Numbers.h"
#include "Ranks/Ranks.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

namespace bsv
{

namespace
{

constexpr int Steps = 4;

struct ProbedFace
{
  std::array<std::array<Vec3, Steps + 1>, Steps + 1> points; ///< [t][s]
  double tolerance = 0.0;                                    ///< 0: meets nothing
  bool finite = true;

  const Vec3& centre() const { return this->points[Steps / 2][Steps / 2]; }
};

ProbedFace probe(const BSplineVolume& volume, int face, double fraction)
{
  const auto parameter = [&](int direction, double f) {
    const std::vector<double>& knots = volume.knots[direction];
    const double first = knots[volume.degree[direction]];
    const double last = knots[volume.count(direction)];
    return f == 1.0 ? last : first + f * (last - first);
  };
  const int across = faceDirection(face);
  const std::vector<int> spans = nonEmptySpans(volume.degree[across], volume.knots[across]);
  ProbedFace result;
  double shortest = std::numeric_limits<double>::infinity();
  double longest = 0.0;
  double size = 0.0;
  std::array<std::array<Vec3, Steps + 1>, Steps + 1> below;
  for (int t = 0; t <= Steps; ++t)
  {
    for (int s = 0; s <= Steps; ++s)
    {
      Vec3 uvw;
      uvw[faceAxis(face, 0)] = parameter(faceAxis(face, 0), double(s) / Steps);
      uvw[faceAxis(face, 1)] = parameter(faceAxis(face, 1), double(t) / Steps);
      uvw[across] = parameter(across, faceSide(face));
      const Vec3 x = evaluate(volume, uvw);
      // As far inside as the first span reaches: thin layers are thinner than the samples are apart.
      uvw[across] = volume.knots[across][faceSide(face) ? spans.back() : spans.front() + 1];
      below[t][s] = evaluate(volume, uvw);
      result.points[t][s] = x;
      result.finite = result.finite && x.allFinite() && below[t][s].allFinite();
      size = std::max(size, x.cwiseAbs().maxCoeff());
      const auto distance = [&](const Vec3& other) {
        const double d = (x - other).norm();
        longest = std::max(longest, d);
        // A pole or a collapsed side does not make the rest of the face small.
        shortest = d > 0.0 ? std::min(shortest, d) : shortest;
      };
      distance(below[t][s]);
      if (s > 0)
      {
        distance(result.points[t][s - 1]);
      }
      if (t > 0)
      {
        distance(result.points[t - 1][s]);
      }
    }
  }
  const double rounding = 64.0 * std::numeric_limits<double>::epsilon() * size;
  double area = 0.0;
  for (int t = 0; t < Steps; ++t)
  {
    for (int s = 0; s < Steps; ++s)
    {
      const auto& p = result.points;
      area = std::max(area, (p[t + 1][s + 1] - p[t][s]).cross(p[t + 1][s] - p[t][s + 1]).norm());
    }
  }
  result.tolerance = area > rounding * longest ? std::max(fraction * shortest, rounding) : 0.0;
  return result;
}

/// Gives every rank the faces of all blocks.
void shareFaces(const std::vector<BSplineVolume>& volumes, const Ranks& ranks, std::vector<ProbedFace>& faces)
{
  struct Packed
  {
    std::array<Triple, (Steps + 1) * (Steps + 1)> points;
    double tolerance;
    bool finite;
  };
  if (ranks.size() == 1)
  {
    return;
  }
  const auto point = [&](std::size_t f, int n) -> Vec3& { return faces[f].points[n / (Steps + 1)][n % (Steps + 1)]; };
  std::vector<Packed> all(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f)
  {
    all[f] = { {}, faces[f].tolerance, faces[f].finite };
    for (std::size_t n = 0; volumes[f / 6].rank == ranks.rank() && n < all[f].points.size(); ++n)
    {
      std::copy_n(point(f, static_cast<int>(n)).data(), 3, all[f].points[n].data());
    }
  }
  ranks.share(all, [&](Index f) { return volumes[f / 6].rank; });
  for (std::size_t f = 0; f < faces.size(); ++f)
  {
    faces[f].tolerance = all[f].tolerance;
    faces[f].finite = all[f].finite;
    for (std::size_t n = 0; n < all[f].points.size(); ++n)
    {
      point(f, static_cast<int>(n)) = Eigen::Map<const Vec3>(all[f].points[n].data());
    }
  }
}

/// Largest distance of the samples if `b` is seen in orientation `o` from `a`.
double mismatch(const ProbedFace& a, const ProbedFace& b, int o)
{
  double worst = 0.0;
  for (int t = 0; t <= Steps; ++t)
  {
    for (int s = 0; s <= Steps; ++s)
    {
      const auto m = mapFacePoint(o, s, t, Steps, Steps);
      worst = std::max(worst, (a.points[t][s] - b.points[m[1]][m[0]]).norm());
    }
  }
  return worst;
}

/// The part of a face that belongs to one span.
struct SpanQuad
{
  int face; ///< 6 * block + face
  int s;
  int t;
  double tolerance;
  std::array<Triple, 5> points; ///< corners around it, then the middle

  Eigen::Map<const Vec3> point(int n) const { return Eigen::Map<const Vec3>(this->points[n].data()); }
};

/// Appends the spans of a face that are not collapsed.
void appendSpans(const BSplineVolume& volume, int number, double fraction, std::vector<SpanQuad>& quads)
{
  const int face = number % 6;
  const int across = faceDirection(face);
  const std::array<int, 2> axes{ faceAxis(face, 0), faceAxis(face, 1) };
  const auto spansOf = [&](int d) { return nonEmptySpans(volume.degree[d], volume.knots[d]); };
  const std::array<std::vector<int>, 2> spans{ spansOf(axes[0]), spansOf(axes[1]) };
  const std::vector<int> down = spansOf(across);
  const double top = volume.knots[across][faceSide(face) ? down.back() + 1 : down.front()];
  const double below = volume.knots[across][faceSide(face) ? down.back() : down.front() + 1];
  for (std::size_t t = 0; t < spans[1].size(); ++t)
  {
    for (std::size_t s = 0; s < spans[0].size(); ++s)
    {
      const auto at = [&](double fs, double ft, double depth) {
        const double* knotS = volume.knots[axes[0]].data() + spans[0][s];
        const double* knotT = volume.knots[axes[1]].data() + spans[1][t];
        Vec3 uvw;
        uvw[axes[0]] = knotS[0] + fs * (knotS[1] - knotS[0]);
        uvw[axes[1]] = knotT[0] + ft * (knotT[1] - knotT[0]);
        uvw[across] = depth;
        return evaluate(volume, uvw);
      };
      const std::array<Vec3, 5> x{ at(0, 0, top), at(1, 0, top), at(1, 1, top), at(0, 1, top), at(0.5, 0.5, top) };
      double shortest = std::numeric_limits<double>::infinity();
      double longest = 0.0;
      double size = 0.0;
      const auto distance = [&](const Vec3& a, const Vec3& b) {
        const double d = (a - b).norm();
        longest = std::max(longest, d);
        shortest = d > 0.0 ? std::min(shortest, d) : shortest;
      };
      for (int c = 0; c < 4; ++c)
      {
        distance(x[c], x[(c + 1) % 4]);
        size = std::max(size, x[c].cwiseAbs().maxCoeff());
      }
      distance(x[4], at(0.5, 0.5, below));
      const double rounding = 64.0 * std::numeric_limits<double>::epsilon() * size;
      if ((x[2] - x[0]).cross(x[3] - x[1]).norm() > rounding * longest)
      {
        SpanQuad quad{ number, static_cast<int>(s), static_cast<int>(t), std::max(fraction * shortest, rounding), {} };
        for (int n = 0; n < 5; ++n)
        {
          std::copy_n(x[n].data(), 3, quad.points[n].data());
        }
        quads.push_back(quad);
      }
    }
  }
}

/// Whether the corners of two spans are the same, from any first corner and in either sense.
bool sameCorners(const SpanQuad& a, const SpanQuad& b, double tolerance)
{
  for (int o = 0; o < 8; ++o)
  {
    bool same = true;
    for (int c = 0; same && c < 4; ++c)
    {
      same = (a.point(c) - b.point(((o & 1 ? c : 4 - c) + o / 2) % 4)).norm() <= tolerance;
    }
    if (same)
    {
      return true;
    }
  }
  return false;
}

} // namespace

std::vector<Interface> findVolumeInterfaces(
  const std::vector<BSplineVolume>& volumes, const VolumeInterfaceOptions& options, const Execution& run)
{
  std::vector<ProbedFace> faces(6 * volumes.size());
  std::vector<bool> known(faces.size(), false);
  for (const BoundaryPatch& patch : options.boundaries)
  {
    known[6 * patch.block + patch.face] = true;
  }
  const auto name = [&](int face) { return options.blockName(face / 6) + " face " + std::to_string(face % 6); };
  run.parallelFor(static_cast<Index>(faces.size()), 1, [&](Index begin, Index end) {
    for (Index f = begin; f < end; ++f)
    {
      if (volumes[f / 6].rank == run.ranks->rank())
      {
        faces[f] = probe(volumes[f / 6], static_cast<int>(f % 6), options.tolerance);
      }
    }
  });
  shareFaces(volumes, *run.ranks, faces);
  std::vector<int> order;
  for (int f = 0; f < static_cast<int>(faces.size()); ++f)
  {
    if (!faces[f].finite)
    {
      throw Error(name(f) + " is not finite");
    }
    if (!known[f] && faces[f].tolerance > 0.0)
    {
      order.push_back(f);
    }
  }
  // The point in the middle is the same in all orientations.
  std::sort(order.begin(), order.end(),
    [&](int a, int b) { return std::make_pair(faces[a].centre()[0], a) < std::make_pair(faces[b].centre()[0], b); });

  std::vector<int> partner(faces.size(), -1);
  std::vector<Interface> result;
  for (std::size_t i = 0; i < order.size(); ++i)
  {
    run.report(static_cast<double>(i) / order.size());
    for (std::size_t j = i + 1; j < order.size(); ++j)
    {
      const ProbedFace& one = faces[order[i]];
      const ProbedFace& other = faces[order[j]];
      if (other.centre()[0] - one.centre()[0] > one.tolerance)
      {
        break;
      }
      const double tolerance = std::min(one.tolerance, other.tolerance);
      if ((one.centre() - other.centre()).norm() > tolerance)
      {
        continue;
      }
      const int a = std::min(order[i], order[j]);
      const int b = std::max(order[i], order[j]);
      int best = 0;
      for (int o = 1; o < 8; ++o)
      {
        best = mismatch(faces[a], faces[b], o) < mismatch(faces[a], faces[b], best) ? o : best;
      }
      if (mismatch(faces[a], faces[b], best) > tolerance)
      {
        continue;
      }
      for (const int face : { a, b })
      {
        if (partner[face] >= 0)
        {
          throw Error(name(face) + " meets both " + name(partner[face]) + " and " + name(a + b - face));
        }
      }
      partner[a] = b;
      partner[b] = a;
      Interface contact;
      contact.blockA = a / 6;
      contact.faceA = a % 6;
      contact.blockB = b / 6;
      contact.faceB = b % 6;
      contact.orientation = best;
      contact.rangeA.hi = { volumes[a / 6].count(faceAxis(a % 6, 0)) - 1,
        volumes[a / 6].count(faceAxis(a % 6, 1)) - 1 };
      result.push_back(contact);
    }
  }
  std::sort(result.begin(), result.end(), [](const Interface& one, const Interface& other) {
    return std::make_pair(one.blockA, one.faceA) < std::make_pair(other.blockA, other.faceA);
  });
  return result;
}

void requireWholeContacts(const std::vector<BSplineVolume>& volumes, const std::vector<Interface>& interfaces,
  const VolumeInterfaceOptions& options, const Execution& run)
{
  std::vector<bool> known(6 * volumes.size(), false);
  for (const BoundaryPatch& patch : options.boundaries)
  {
    known[6 * patch.block + patch.face] = true;
  }
  for (const Interface& contact : interfaces)
  {
    known[6 * contact.blockA + contact.faceA] = true;
    known[6 * contact.blockB + contact.faceB] = true;
  }
  std::vector<SpanQuad> quads;
  for (std::size_t f = 0; f < known.size(); ++f)
  {
    run.report(0.5 * static_cast<double>(f) / static_cast<double>(known.size()));
    if (!known[f] && volumes[f / 6].rank == run.ranks->rank())
    {
      appendSpans(volumes[f / 6], static_cast<int>(f), options.tolerance, quads);
    }
  }
  quads = run.ranks->gatherAll(quads);
  std::sort(quads.begin(), quads.end(), [](const SpanQuad& a, const SpanQuad& b) {
    return std::tie(a.points[4][0], a.face, a.t, a.s) < std::tie(b.points[4][0], b.face, b.t, b.s);
  });
  // The pair of the lowest numbers, so that the error is the same on any number of ranks.
  const SpanQuad* first = nullptr;
  const SpanQuad* second = nullptr;
  Index count = 0;
  for (std::size_t i = 0; i < quads.size(); ++i)
  {
    for (std::size_t j = i + 1; j < quads.size() && quads[j].points[4][0] - quads[i].points[4][0] <= quads[i].tolerance;
         ++j)
    {
      const double tolerance = std::min(quads[i].tolerance, quads[j].tolerance);
      if ((quads[i].point(4) - quads[j].point(4)).norm() > tolerance || !sameCorners(quads[i], quads[j], tolerance))
      {
        continue;
      }
      ++count;
      const auto key = [](const SpanQuad& quad) { return std::make_tuple(quad.face, quad.t, quad.s); };
      const bool ordered = key(quads[i]) < key(quads[j]);
      const SpanQuad& a = quads[ordered ? i : j];
      const SpanQuad& b = quads[ordered ? j : i];
      if (!first || std::make_pair(key(a), key(b)) < std::make_pair(key(*first), key(*second)))
      {
        first = &a;
        second = &b;
      }
    }
  }
  if (!first)
  {
    return;
  }
  const auto place = [&](const SpanQuad& quad) {
    return options.blockName(quad.face / 6) + ", face " + std::to_string(quad.face % 6) + ", span (" +
      std::to_string(quad.s) + ", " + std::to_string(quad.t) + ")";
  };
  throw Error(place(*first) + " and " + place(*second) + " are the same (" + std::to_string(count) +
    (count == 1 ? " such pair" : " such pairs") +
    "), but their faces are not: only whole faces can be joined. Cut the blocks where the contact ends, or name the "
    "faces as boundaries if they are no contact");
}

} // namespace bsv

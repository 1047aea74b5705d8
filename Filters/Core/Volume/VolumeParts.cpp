// SPDX-License-Identifier: BSD-3-Clause
#include "Volume/VolumeParts.h"

#include <algorithm>
#include <cmath>

namespace bsv
{

namespace
{

/// First of the knots of full multiplicity at each cut, per direction; the control point before it lies on the cut.
using Cuts = std::array<std::vector<int>, 3>;

std::vector<int> repeatedKnots(const BSplineVolume& volume, int direction)
{
  std::vector<int> cuts;
  for (int knot = 0; knot < static_cast<int>(volume.knots[direction].size()); ++knot)
  {
    if (isRepeatedKnot(volume.degree[direction], volume.knots[direction], knot))
    {
      cuts.push_back(knot);
    }
  }
  return cuts;
}

/// Place of a knot in the range of its direction, 0 to 1.
double placeOf(const BSplineVolume& volume, int direction, int knot)
{
  const std::vector<double>& knots = volume.knots[direction];
  const double first = knots[volume.degree[direction]];
  return (knots[knot] - first) / (knots[knots.size() - 1 - volume.degree[direction]] - first);
}

/// A direction of a face, as seen from the other side of its contact.
struct Across
{
  int direction;
  bool turned;
};

Across acrossContact(const Interface& contact, int axis)
{
  const int axisB = swapsAxes(contact.orientation) ? 1 - axis : axis;
  return { faceAxis(contact.faceB, axisB), (contact.orientation & (axisB == 0 ? 2 : 4)) != 0 };
}

/// Leaves out the cuts of A that B has not. @return whether there were any
bool keepShared(const BSplineVolume& a, int directionA, std::vector<int>& cutsA, const BSplineVolume& b, int directionB,
  const std::vector<int>& cutsB, bool turned)
{
  constexpr double Rounding = 1e-9;
  const auto isAlone = [&](int cut) {
    const double place = placeOf(a, directionA, cut);
    return std::none_of(cutsB.begin(), cutsB.end(), [&](int other) {
      const double there = placeOf(b, directionB, other);
      return std::abs((turned ? 1.0 - there : there) - place) < Rounding;
    });
  };
  const auto end = std::remove_if(cutsA.begin(), cutsA.end(), isAlone);
  const bool any = end != cutsA.end();
  cutsA.erase(end, cutsA.end());
  return any;
}

/// All cuts that both sides of every contact have.
std::vector<Cuts> sharedCuts(const std::vector<BSplineVolume>& volumes, const std::vector<Interface>& interfaces)
{
  std::vector<Cuts> cuts(volumes.size());
  bool any = false;
  for (std::size_t b = 0; b < volumes.size(); ++b)
  {
    for (int d = 0; d < 3; ++d)
    {
      cuts[b][d] = repeatedKnots(volumes[b], d);
      any = any || !cuts[b][d].empty();
    }
  }
  for (bool changed = any; changed;)
  {
    changed = false;
    for (const Interface& contact : interfaces)
    {
      const BSplineVolume &a = volumes[contact.blockA], &b = volumes[contact.blockB];
      for (int axis = 0; axis < 2; ++axis)
      {
        const int dA = faceAxis(contact.faceA, axis);
        const auto [dB, turned] = acrossContact(contact, axis);
        std::vector<int>&cutsA = cuts[contact.blockA][dA], &cutsB = cuts[contact.blockB][dB];
        changed = keepShared(a, dA, cutsA, b, dB, cutsB, turned) || changed;
        changed = keepShared(b, dB, cutsB, a, dA, cutsA, turned) || changed;
      }
    }
  }
  return cuts;
}

/// The control points first..first + count - 1 of a block as a volume.
BSplineVolume partOf(
  const BSplineVolume& whole, const Ijk& first, const Ijk& count, std::vector<std::vector<double>>& memory)
{
  BSplineVolume part = whole;
  for (int d = 0; d < 3; ++d)
  {
    // A knot at a cut is repeated once more.
    std::vector<double>& knots = part.knots[d];
    const int degree = whole.degree[d];
    knots.assign(whole.knots[d].begin() + first[d], whole.knots[d].begin() + first[d] + count[d] + degree + 1);
    knots.front() = first[d] > 0 ? knots[1] : knots.front();
    knots.back() = first[d] + count[d] < whole.count(d) ? knots[knots.size() - 2] : knots.back();
  }
  const auto copy = [&](const double* from, int components) -> const double* {
    if (!from)
    {
      return nullptr;
    }
    std::vector<double> values;
    values.reserve(std::size_t(components) * count[0] * count[1] * count[2]);
    for (int k = first[2]; k < first[2] + count[2]; ++k)
    {
      for (int j = first[1]; j < first[1] + count[1]; ++j)
      {
        const double* row = from + components * (first[0] + Index(whole.count(0)) * (j + Index(whole.count(1)) * k));
        values.insert(values.end(), row, row + Index(components) * count[0]);
      }
    }
    memory.push_back(std::move(values));
    return memory.back().data();
  };
  part.points = copy(whole.points, 3);
  part.weights = copy(whole.weights, 1);
  return part;
}

} // namespace

VolumeParts cutAtRepeatedKnots(const std::vector<BSplineVolume>& volumes, const std::vector<Interface>& interfaces)
{
  const std::vector<Cuts> cuts = sharedCuts(volumes, interfaces);
  VolumeParts parts;
  std::vector<int> firstPart;
  std::vector<Ijk> counts;
  for (std::size_t b = 0; b < volumes.size(); ++b)
  {
    const BSplineVolume& whole = volumes[b];
    // Control points at which parts begin, and the last one.
    std::array<std::vector<int>, 3> at;
    for (int d = 0; d < 3; ++d)
    {
      at[d] = { 0 };
      std::transform(
        cuts[b][d].begin(), cuts[b][d].end(), std::back_inserter(at[d]), [](int knot) { return knot - 1; });
      at[d].push_back(whole.count(d) - 1);
    }
    firstPart.push_back(static_cast<int>(parts.volumes.size()));
    counts.push_back(
      { static_cast<int>(at[0].size()) - 1, static_cast<int>(at[1].size()) - 1, static_cast<int>(at[2].size()) - 1 });
    const Ijk& n = counts.back();
    const bool isWhole = n[0] * n[1] * n[2] == 1;
    Ijk p;
    for (p[2] = 0; p[2] < n[2]; ++p[2])
    {
      for (p[1] = 0; p[1] < n[1]; ++p[1])
      {
        for (p[0] = 0; p[0] < n[0]; ++p[0])
        {
          Ijk first, count;
          for (int d = 0; d < 3; ++d)
          {
            first[d] = at[d][p[d]];
            count[d] = at[d][p[d] + 1] - first[d] + 1;
          }
          parts.blocks.push_back(static_cast<int>(b));
          parts.numbers.push_back(static_cast<int>(parts.volumes.size()) - firstPart.back());
          parts.first.push_back(first);
          parts.volumes.push_back(isWhole ? whole : partOf(whole, first, count, parts.memory));
        }
      }
    }
  }
  const auto part = [&](int block, const Ijk& p) {
    return firstPart[block] + p[0] + counts[block][0] * (p[1] + counts[block][1] * p[2]);
  };
  const auto atFace = [&](int block, int face, int s, int t) {
    Ijk p;
    p[faceDirection(face)] = faceSide(face) ? counts[block][faceDirection(face)] - 1 : 0;
    p[faceAxis(face, 0)] = s;
    p[faceAxis(face, 1)] = t;
    return part(block, p);
  };
  for (const Interface& contact : interfaces)
  {
    const int ns = counts[contact.blockA][faceAxis(contact.faceA, 0)] - 1;
    const int nt = counts[contact.blockA][faceAxis(contact.faceA, 1)] - 1;
    for (int t = 0; t <= nt; ++t)
    {
      for (int s = 0; s <= ns; ++s)
      {
        const auto there = mapFacePoint(contact.orientation, s, t, ns, nt);
        Interface one = contact;
        one.blockA = atFace(contact.blockA, contact.faceA, s, t);
        one.blockB = atFace(contact.blockB, contact.faceB, there[0], there[1]);
        parts.interfaces.push_back(one);
      }
    }
  }
  for (int b = 0; b < static_cast<int>(volumes.size()); ++b)
  {
    const Ijk& n = counts[b];
    for (int d = 0; d < 3; ++d)
    {
      Ijk p;
      for (p[2] = 0; p[2] < n[2]; ++p[2])
      {
        for (p[1] = 0; p[1] < n[1]; ++p[1])
        {
          for (p[0] = 0; p[0] < n[0]; ++p[0])
          {
            Ijk next = p;
            if (++next[d] < n[d])
            {
              parts.interfaces.push_back({ part(b, p), 2 * d + 1, part(b, next), 2 * d, 0, {}, {} });
            }
          }
        }
      }
    }
  }
  return parts;
}

} // namespace bsv

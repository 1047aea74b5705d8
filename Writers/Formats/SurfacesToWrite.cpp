// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/SurfacesToWrite.h"

#include "Body/FaceSurface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace bsv
{

namespace
{

/// Fraction of the body's size within which control points of two sides are the same.
constexpr double SameFraction = 1e-9;
/// Fraction of the body's size within which a side is one point.
constexpr double CollapsedFraction = 1e-12;
/// Fraction of the parameter range, and of a weight, within which they are the same.
constexpr double SameParameter = 1e-12;

/// The same surface with u running the other way.
NURBSSurface reversedSurface(const NURBSSurface& surface)
{
  NURBSSurface result = surface;
  const double sum = surface.knots[0].front() + surface.knots[0].back();
  std::transform(surface.knots[0].rbegin(), surface.knots[0].rend(), result.knots[0].begin(),
    [=](double knot) { return sum - knot; });
  const int count = surface.count(0);
  for (int j = 0; j < surface.count(1); ++j)
  {
    std::reverse(
      result.points.begin() + std::ptrdiff_t(j) * count, result.points.begin() + std::ptrdiff_t(j + 1) * count);
    if (result.rational())
    {
      std::reverse(
        result.weights.begin() + std::ptrdiff_t(j) * count, result.weights.begin() + std::ptrdiff_t(j + 1) * count);
    }
  }
  return result;
}

void turnOutward(BodyPatch& patch)
{
  if (patch.reversed)
  {
    patch.surface = reversedSurface(patch.surface);
    patch.reversed = false;
  }
}

/// Whether the boundary of the patch, counter-clockwise around its normal, runs along the parameter of a side.
bool runsAlong(int side)
{
  return side == 1 || side == 2;
}

/// Whether the normals of two patches agree at a join: their boundaries then run against each other.
bool normalsAgree(int sideA, int sideB, bool against)
{
  return runsAlong(sideA) != (runsAlong(sideB) != against);
}

std::string sideName(const BodyPatch& patch, int number, int side)
{
  return "patch " + std::to_string(number) + " '" + patch.name + "', side " + (side < 2 ? "u " : "v ") +
    (side % 2 ? "last" : "first");
}

/// Whether two sides are the same curve, the second one read backwards if `against`.
bool sameCurve(const SideCurve& a, const SideCurve& b, bool against, double tolerance)
{
  const std::size_t n = a.points.size();
  if (a.degree != b.degree || b.points.size() != n || a.weights.empty() != b.weights.empty())
  {
    return false;
  }
  const auto at = [&](std::size_t i, std::size_t count) { return against ? count - 1 - i : i; };
  for (std::size_t i = 0; i < n; ++i)
  {
    if (!((a.points[i] - b.points[at(i, n)]).cwiseAbs().maxCoeff() <= tolerance))
    {
      return false;
    }
    if (!a.weights.empty() &&
      std::abs(a.weights[i] * b.weights[at(0, n)] - b.weights[at(i, n)] * a.weights[0]) >
        SameParameter * a.weights[i] * b.weights[at(0, n)])
    {
      return false;
    }
  }
  const auto place = [](const SideCurve& side, std::size_t k) {
    const double first = side.knots[side.degree];
    const double last = side.knots[side.points.size()];
    return (side.knots[k] - first) / (last - first);
  };
  for (std::size_t k = 0; k < a.knots.size(); ++k)
  {
    const double other = place(b, at(k, b.knots.size()));
    if (std::abs(place(a, k) - (against ? 1.0 - other : other)) > SameParameter)
    {
      return false;
    }
  }
  return true;
}

} // namespace

SideCurve sideCurve(const NURBSSurface& surface, int side)
{
  const int along = side < 2 ? 1 : 0;
  const int fixed = side % 2 ? surface.count(1 - along) - 1 : 0;
  SideCurve curve;
  curve.degree = surface.degree[along];
  curve.knots = surface.knots[along];
  for (int i = 0; i < surface.count(along); ++i)
  {
    const Index row = surface.count(0);
    const Index place = along == 1 ? fixed + row * i : i + row * fixed;
    curve.points.push_back(surface.points[place]);
    if (surface.rational())
    {
      curve.weights.push_back(surface.weights[place]);
    }
  }
  return curve;
}

bool isCollapsed(const SideCurve& side, double size)
{
  return std::all_of(side.points.begin(), side.points.end(),
    [&](const Vec3& point) { return (point - side.points[0]).norm() <= CollapsedFraction * size; });
}

double sizeOf(const std::vector<BodyPatch>& patches)
{
  Eigen::AlignedBox3d box;
  for (const BodyPatch& patch : patches)
  {
    for (const Vec3& point : patch.surface.points)
    {
      box.extend(point);
    }
  }
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

SurfacesToWrite bodyToWrite(std::vector<BodyPatch> patches)
{
  SurfacesToWrite result;
  for (std::size_t p = 0; p < patches.size(); ++p)
  {
    if (!patches[p].loops.empty())
    {
      throw Error(
        "patch " + std::to_string(p) + " '" + patches[p].name + "' is trimmed; only untrimmed patches can be written");
    }
    turnOutward(patches[p]);
  }
  const double size = sizeOf(patches);

  struct Side
  {
    int patch;
    int side;
    SideCurve curve;
    /// Sum of the coordinates of both ends: the same for the same side.
    double key;
  };
  std::vector<Side> sides;
  for (std::size_t p = 0; p < patches.size(); ++p)
  {
    for (int s = 0; s < 4; ++s)
    {
      Side side{ static_cast<int>(p), s, sideCurve(patches[p].surface, s), 0.0 };
      if (!isCollapsed(side.curve, size))
      {
        side.key = side.curve.points.front().sum() + side.curve.points.back().sum();
        sides.push_back(std::move(side));
      }
    }
  }
  std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.key < b.key; });
  const double tolerance = SameFraction * size;
  std::vector<std::vector<std::pair<std::size_t, bool>>> same(sides.size());
  for (std::size_t a = 0; a < sides.size(); ++a)
  {
    for (std::size_t b = a + 1; b < sides.size() && sides[b].key - sides[a].key <= 6.0 * tolerance; ++b)
    {
      for (const bool against : { false, true })
      {
        if (sameCurve(sides[a].curve, sides[b].curve, against, tolerance))
        {
          same[a].emplace_back(b, against);
          same[b].emplace_back(a, against);
          break;
        }
      }
    }
  }
  std::vector<std::string> open;
  for (std::size_t a = 0; a < sides.size(); ++a)
  {
    const auto label = [&](std::size_t s) { return sideName(patches[sides[s].patch], sides[s].patch, sides[s].side); };
    if (same[a].empty())
    {
      continue;
    }
    const auto [b, against] = same[a][0];
    if (same[a].size() > 1 || same[b].size() > 1)
    {
      open.push_back(label(a) + " is shared by more than two");
    }
    else if (!normalsAgree(sides[a].side, sides[b].side, against))
    {
      open.push_back(label(a) + " meets a patch whose outward normal is on the other side");
    }
    else if (a < b)
    {
      result.joins.push_back({ { sides[a].patch, sides[b].patch }, { sides[a].side, sides[b].side }, against });
    }
  }
  if (!open.empty())
  {
    std::sort(open.begin(), open.end());
    result.notes.push_back(
      std::to_string(open.size()) + " sides of patches were not sewn to others; the first: " + open[0]);
  }
  std::sort(result.joins.begin(), result.joins.end(),
    [](const PatchJoin& a, const PatchJoin& b) { return std::tie(a.patch, a.side) < std::tie(b.patch, b.side); });
  result.patches = std::move(patches);
  return result;
}

SurfacesToWrite wallToWrite(const VolumeToWrite& volume, const std::vector<bool>& wall, const Execution& run)
{
  SurfacesToWrite result;
  std::vector<BoundaryPatch> faces;
  std::vector<int> patchOf(6 * volume.volumes.size(), -1);
  for (const BoundaryPatch& patch : volume.boundaries)
  {
    if (patch.tag >= 0 && wall[patch.tag])
    {
      patchOf[6 * std::size_t(patch.block) + patch.face] = static_cast<int>(faces.size());
      faces.push_back(patch);
    }
  }
  std::vector<NURBSSurface> surfaces = faceSurfaces(volume.volumes, faces, *run.ranks);
  for (std::size_t f = 0; f < faces.size(); ++f)
  {
    const int face = faces[f].face;
    BodyPatch patch;
    patch.name = volume.boundaryNames[faces[f].tag];
    patch.surface = std::move(surfaces[f]);
    // x_s x x_t of ascending axes points along the third one, but against the second.
    const bool alongDirection = (faceDirection(face) != 1) != (volume.leftHanded[faces[f].block] != 0);
    patch.reversed = alongDirection != (faceSide(face) == 0);
    result.patches.push_back(std::move(patch));
  }

  struct Neighbour
  {
    int block = -1;
    int face = 0;
    int orientation = 0;
  };
  std::vector<Neighbour> neighbours(patchOf.size());
  for (const Interface& contact : volume.interfaces)
  {
    neighbours[6 * std::size_t(contact.blockA) + contact.faceA] = { contact.blockB, contact.faceB,
      contact.orientation };
    neighbours[6 * std::size_t(contact.blockB) + contact.faceB] = { contact.blockA, contact.faceA,
      inverseOrientation(contact.orientation) };
  }
  // Side of the patch of a wall face where the block's face `beside` meets it.
  const auto sideAt = [](int face, int beside) {
    return 2 * (faceAxis(face, 0) == faceDirection(beside) ? 0 : 1) + faceSide(beside);
  };
  for (std::size_t f = 0; f < faces.size(); ++f)
  {
    for (int side = 0; side < 4; ++side)
    {
      // From the wall around the edge, through one block after the other. The edge lies between the faces `from` and
      // `to` of the block, and runs along its third direction, or against it.
      int block = faces[f].block;
      int from = faces[f].face;
      int to = 2 * faceAxis(from, side / 2) + side % 2;
      bool against = false;
      for (const Neighbour* next = &neighbours[6 * std::size_t(block) + to]; next->block >= 0;
           next = &neighbours[6 * std::size_t(block) + to])
      {
        const int across = faceAxis(to, 0) == faceDirection(from) ? 0 : 1;
        std::array<int, 2> ends[2];
        for (int end = 0; end < 2; ++end)
        {
          const int st[2] = { across == 0 ? faceSide(from) : end, across == 0 ? end : faceSide(from) };
          ends[end] = mapFacePoint(next->orientation, st[0], st[1], 1, 1);
        }
        const int along = ends[0][0] != ends[1][0] ? 0 : 1;
        against = against != (ends[0][along] > ends[1][along]);
        block = next->block;
        from = next->face;
        to = 2 * faceAxis(from, 1 - along) + ends[0][1 - along];
      }
      const int other = patchOf[6 * std::size_t(block) + to];
      const int otherSide = other < 0 ? 0 : sideAt(to, from);
      const std::array<int, 2> self{ static_cast<int>(f), side };
      const std::array<int, 2> met{ other, otherSide };
      if (other >= 0 && self < met)
      {
        result.joins.push_back({ { self[0], met[0] }, { self[1], met[1] }, against });
      }
    }
  }
  // Patches whose u is reversed below: their first and last u change places, and the sides along u run the other way.
  for (PatchJoin& join : result.joins)
  {
    for (int n = 0; n < 2; ++n)
    {
      if (result.patches[join.patch[n]].reversed)
      {
        join.against = join.against != (join.side[n] >= 2);
        join.side[n] = join.side[n] < 2 ? 1 - join.side[n] : join.side[n];
      }
    }
  }
  for (BodyPatch& patch : result.patches)
  {
    turnOutward(patch);
  }
  // Sides that are not the same curve stay apart: parts of the volume may meet with other knots.
  const double size = sizeOf(result.patches);
  const auto fits = [&](const PatchJoin& join) {
    return normalsAgree(join.side[0], join.side[1], join.against) &&
      sameCurve(sideCurve(result.patches[join.patch[0]].surface, join.side[0]),
        sideCurve(result.patches[join.patch[1]].surface, join.side[1]), join.against, SameFraction * size);
  };
  const auto apart = std::stable_partition(result.joins.begin(), result.joins.end(), fits);
  if (apart != result.joins.end())
  {
    result.notes.push_back(std::to_string(result.joins.end() - apart) +
      " edges of the wall were not sewn, since the patches there differ in degrees, knots or points; the first: " +
      sideName(result.patches[apart->patch[0]], apart->patch[0], apart->side[0]));
    result.joins.erase(apart, result.joins.end());
  }
  return result;
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/VolumeToWrite.h"

#include "Ranks/OwnedValues.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <deque>
#include <map>

namespace bsv
{

namespace
{

/// Parameters in the middle of at most four spans per direction, spread over all of them.
std::vector<double> midParameters(const BSplineVolume& volume, int direction)
{
  const std::vector<double>& knots = volume.knots[direction];
  const std::vector<int> spans = nonEmptySpans(volume.degree[direction], knots);
  std::vector<double> result;
  const std::size_t count = std::min<std::size_t>(spans.size(), 4);
  for (std::size_t n = 0; n < count; ++n)
  {
    const int s = spans[n * spans.size() / count];
    result.push_back(0.5 * (knots[s] + knots[s + 1]));
  }
  return result;
}

/// Sign of the sum of Jacobians.
bool isLeftHanded(const BSplineVolume& volume)
{
  double sum = 0.0;
  for (const double w : midParameters(volume, 2))
  {
    for (const double v : midParameters(volume, 1))
    {
      for (const double u : midParameters(volume, 0))
      {
        const Vec3 at(u, v, w);
        sum += evaluate(volume, at, { 1, 0, 0 })
                 .dot(evaluate(volume, at, { 0, 1, 0 }).cross(evaluate(volume, at, { 0, 0, 1 })));
      }
    }
  }
  return sum < 0.0;
}

/// A direction of a block, and whether it runs against that of the block where the search began.
struct SheetBlock
{
  int block;
  int direction;
  bool against;
};

} // namespace

bool VolumeToWrite::isRational() const
{
  return std::any_of(
    this->volumes.begin(), this->volumes.end(), [](const BSplineVolume& volume) { return volume.weights != nullptr; });
}

void completeVolume(VolumeToWrite& volume, const Execution& run)
{
  volume.leftHanded = gatherFromOwners<char>(
    *run.ranks, volume.volumes.size(), [&](std::size_t b) { return volume.volumes[b].rank; },
    [&](std::size_t b) { return isLeftHanded(volume.volumes[b]) ? 1 : 0; });
  std::vector<char> used(6 * volume.volumes.size(), 0);
  const auto use = [&](int block, int face) {
    if (used[6 * std::size_t(block) + face]++ != 0)
    {
      throw Error(volume.label(block) + ", face " + std::to_string(face) +
        ", is in two interfaces or boundaries, or in an interface and a boundary");
    }
  };
  for (const Interface& contact : volume.interfaces)
  {
    use(contact.blockA, contact.faceA);
    use(contact.blockB, contact.faceB);
  }
  for (const BoundaryPatch& patch : volume.boundaries)
  {
    use(patch.block, patch.face);
  }
  Index unnamed = 0;
  for (std::size_t f = 0; f < used.size(); ++f)
  {
    if (!used[f])
    {
      volume.boundaries.push_back({ static_cast<int>(f / 6), static_cast<int>(f % 6), {}, -1 });
      ++unnamed;
    }
  }
  if (unnamed > 0)
  {
    volume.notes.push_back(std::to_string(unnamed) + " block faces are in no interface and in no boundary with a name");
  }
}

void cutSheet(VolumeToWrite& volume, int block, int direction)
{
  // All blocks that face each other in this direction.
  std::map<std::array<int, 2>, bool> sheet{ { { block, direction }, false } };
  std::deque<SheetBlock> open{ { block, direction, false } };
  while (!open.empty())
  {
    const SheetBlock own = open.front();
    open.pop_front();
    for (const Interface& contact : volume.interfaces)
    {
      for (int side = 0; side < 2; ++side)
      {
        const int a = side ? contact.blockB : contact.blockA;
        const int faceA = side ? contact.faceB : contact.faceA;
        const int b = side ? contact.blockA : contact.blockB;
        const int faceB = side ? contact.faceA : contact.faceB;
        const int o = side ? inverseOrientation(contact.orientation) : contact.orientation;
        if (a != own.block || faceDirection(faceA) == own.direction)
        {
          continue;
        }
        const int axis = faceAxis(faceA, 0) == own.direction ? 0 : 1;
        const int axisB = swapsAxes(o) ? 1 - axis : axis;
        const bool turned = (o & (axisB == 0 ? 2 : 4)) != 0;
        const std::array<int, 2> key{ b, faceAxis(faceB, axisB) };
        const bool against = own.against != turned;
        const auto [found, isNew] = sheet.emplace(key, against);
        if (isNew)
        {
          open.push_back({ key[0], key[1], against });
        }
        else if (found->second != against)
        {
          throw Error(volume.label(b) + " faces itself turned round along " + std::string(1, "uvw"[key[1]]) +
            ": it cannot be cut there without a change of its neighbours");
        }
      }
    }
  }

  // Where each block is cut: the same span of all, counted from the same end.
  const auto spansOf = [&](int b, int d) {
    return nonEmptySpans(volume.volumes[b].degree[d], volume.volumes[b].knots[d]);
  };
  const std::size_t spans = spansOf(block, direction).size();
  std::map<int, std::vector<std::array<int, 2>>> directionsOf;
  for (const auto& [key, against] : sheet)
  {
    if (spansOf(key[0], key[1]).size() != spans)
    {
      throw Error(volume.label(key[0]) + " and " + volume.label(block) +
        " face each other, but have different numbers of spans: they cannot be cut together");
    }
    directionsOf[key[0]].push_back({ key[1], against ? 1 : 0 });
  }
  for (const auto& [b, directions] : directionsOf)
  {
    if (directions.size() > 1)
    {
      // Cut once more later, by the next call.
      throw Error(volume.label(b) + " faces itself in two directions: it cannot be cut in one of them alone");
    }
  }
  std::map<int, int> upper; // block to its second part
  for (const auto& [key, against] : sheet)
  {
    const auto [b, d] = key;
    const BSplineVolume whole = volume.volumes[b];
    const std::vector<double>& knots = whole.knots[d];
    const std::vector<int> own = spansOf(b, d);
    double at = 0.0;
    if (spans > 1)
    {
      const std::size_t n = against ? spans - spans / 2 : spans / 2;
      at = knots[own[n]];
    }
    else
    {
      at = 0.5 * (knots[own[0]] + knots[own[0] + 1]);
    }
    auto parts = std::make_shared<std::array<OwnedVolume, 2>>(cutVolume(whole, d, at));
    for (OwnedVolume& part : *parts)
    {
      part.view.points = whole.points ? part.points.data() : nullptr;
      part.view.weights = whole.weights ? part.weights.data() : nullptr;
    }
    upper[b] = static_cast<int>(volume.volumes.size());
    volume.volumes[b] = (*parts)[0].view;
    volume.volumes.push_back((*parts)[1].view);
    volume.memory.push_back(parts);
    volume.names.push_back(volume.names[b]);
    volume.parents.push_back(volume.parents[b]);
    volume.leftHanded.push_back(volume.leftHanded[b]);
  }

  // The part of a block that has a face, and for faces that were cut the two of them.
  const auto cutDirection = [&](int b) { return directionsOf.count(b) ? directionsOf[b][0][0] : -1; };
  std::vector<Interface> interfaces;
  for (const Interface& contact : volume.interfaces)
  {
    const int a = contact.blockA;
    const int b = contact.blockB;
    const int da = cutDirection(a);
    const int db = cutDirection(b);
    const bool along = da >= 0 && faceDirection(contact.faceA) != da;
    if (!along)
    {
      Interface one = contact;
      one.blockA = da == faceDirection(contact.faceA) && faceSide(contact.faceA) ? upper[a] : a;
      one.blockB = db == faceDirection(contact.faceB) && faceSide(contact.faceB) ? upper[b] : b;
      interfaces.push_back(one);
      continue;
    }
    const bool turned = (sheet[{ a, da }]) != (sheet[{ b, db }]);
    for (int half = 0; half < 2; ++half)
    {
      Interface one = contact;
      one.blockA = half ? upper[a] : a;
      one.blockB = (half != 0) != turned ? upper[b] : b;
      interfaces.push_back(one);
    }
  }
  std::vector<BoundaryPatch> boundaries;
  for (const BoundaryPatch& patch : volume.boundaries)
  {
    const int d = cutDirection(patch.block);
    BoundaryPatch one = patch;
    if (d < 0 || faceDirection(patch.face) == d)
    {
      one.block = d >= 0 && faceSide(patch.face) ? upper[patch.block] : patch.block;
      boundaries.push_back(one);
      continue;
    }
    boundaries.push_back(one);
    one.block = upper[patch.block];
    boundaries.push_back(one);
  }
  for (const auto& [b, second] : upper)
  {
    const int d = directionsOf[b][0][0];
    Interface inside;
    inside.blockA = b;
    inside.faceA = 2 * d + 1;
    inside.blockB = second;
    inside.faceB = 2 * d;
    interfaces.push_back(inside);
  }
  volume.interfaces = interfaces;
  volume.boundaries = boundaries;
}

} // namespace bsv

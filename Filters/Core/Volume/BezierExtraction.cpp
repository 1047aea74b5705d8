// SPDX-License-Identifier: BSD-3-Clause
#include "Volume/BezierExtraction.h"

#include "Base/UnionFind.h"
#include "Ranks/Ranks.h"
#include "Volume/BezierSegments.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace bsv
{

namespace
{

/// Points of a contact further apart than this fraction of the largest coordinate are not rounding, but a gap.
constexpr double WeldTolerance = 1e-14;

WeightTable bezierTable(int degree, const std::vector<double>& knots)
{
  const int size = degree + 1;
  std::vector<double> matrix(static_cast<std::size_t>(size) * size);
  int spanOfMatrix = -1;
  return weightTable(degree, knots, degree, [&](int span, int j, double* values) {
    if (span != spanOfMatrix)
    {
      bezierWeights(degree, knots, span, matrix.data());
      spanOfMatrix = span;
    }
    std::copy_n(matrix.data() + j * size, size, values);
  });
}

SurfaceNumbering surfacesOf(const std::vector<Ijk>& counts)
{
  BlockMesh mesh;
  for (const Ijk& n : counts)
  {
    MeshBlock block;
    block.points = GridView::elsewhere(n);
    mesh.blocks.push_back(block);
  }
  return SurfaceNumbering(mesh);
}

std::vector<Ijk> allCounts(const std::vector<BSplineVolume>& volumes)
{
  std::vector<Ijk> counts;
  for (std::size_t b = 0; b < volumes.size(); ++b)
  {
    counts.push_back(bezierCounts(volumes[b], "block " + std::to_string(b)));
  }
  return counts;
}

double largestCoordinate(const BSplineVolume& volume)
{
  const Index values = 3 * Index(volume.count(0)) * volume.count(1) * volume.count(2);
  double largest = 0.0;
  for (Index i = 0; i < values; ++i)
  {
    largest = std::max(largest, std::abs(volume.points[i]));
  }
  return largest;
}

} // namespace

Ijk bezierCounts(const BSplineVolume& volume, const std::string& name)
{
  Ijk counts;
  double bytes = 4 * sizeof(double);
  for (int d = 0; d < 3; ++d)
  {
    const Index spans = static_cast<Index>(nonEmptySpans(volume.degree[d], volume.knots[d]).size());
    const Index count = spans * volume.degree[d] + 1;
    bytes *= static_cast<double>(count);
    if (count > std::numeric_limits<int>::max() || bytes > 9e18)
    {
      throw Error(name + " has too many Bezier points");
    }
    counts[d] = static_cast<int>(count);
  }
  return counts;
}

BezierExtraction::BezierExtraction(const std::vector<BSplineVolume>& volumes, const std::vector<Interface>* interfaces,
  BezierCells cells, const Execution& run)
  : Volumes(volumes)
  , Rank(run.ranks->rank())
  , Counts(allCounts(volumes))
  , Surface(surfacesOf(this->Counts))
  , Tolerances(volumes.size(), 0.0)
{
  bool rational = false;
  for (std::size_t b = 0; b < volumes.size(); ++b)
  {
    const BSplineVolume& volume = volumes[b];
    rational = rational || volume.weights;
    this->Start.push_back(this->SurfacePoints);
    if (this->isHere(static_cast<int>(b)))
    {
      this->SurfacePoints +=
        this->Surface.firstPoint(static_cast<int>(b) + 1) - this->Surface.firstPoint(static_cast<int>(b));
      this->Tolerances[b] = WeldTolerance * largestCoordinate(volume);
    }
    std::array<WeightTable, 3> tables;
    Ijk spans;
    for (int d = 0; d < 3; ++d)
    {
      tables[d] = bezierTable(volume.degree[d], volume.knots[d]);
      spans[d] = (this->Counts[b][d] - 1) / volume.degree[d];
    }
    this->Tables.push_back(std::move(tables));
    this->Spans.push_back(spans);
  }
  this->Rational = run.ranks->any(rational);
  run.ranks->share(this->Tolerances, [&](Index b) { return volumes[b].rank; });
  this->evaluateSurfaces(run);
  this->number(interfaces ? *interfaces : this->coincidentFaces(*run.ranks), cells, *run.ranks);
}

Index BezierExtraction::point(int block, const Ijk& p) const
{
  const Ijk& n = this->Counts[block];
  for (int d = 0; d < 3; ++d)
  {
    if (p[d] == 0 || p[d] == n[d] - 1)
    {
      return this->SurfaceNumbers[this->surfacePoint(block, p)];
    }
  }
  return this->InsideStart.empty()
    ? -1
    : this->InsideStart[block] + (p[0] - 1) + Index(n[0] - 2) * ((p[1] - 1) + Index(n[1] - 2) * (p[2] - 1));
}

Ijk BezierExtraction::cornerOf(int block, int corner) const
{
  Ijk p;
  for (int d = 0; d < 3; ++d)
  {
    p[d] = cornerSide(corner, d) ? this->Counts[block][d] - 1 : 0;
  }
  return p;
}

/// Place of a point on the surface of a block on this rank.
Index BezierExtraction::surfacePoint(int block, const Ijk& p) const
{
  return this->Start[block] + (this->Surface.point(block, p) - this->Surface.firstPoint(block));
}

/// Place of the Bezier point (s, t) of a face.
Index BezierExtraction::surfacePoint(const BlockFace& at, int s, int t) const
{
  Ijk p;
  p[faceDirection(at.face)] = faceSide(at.face) ? this->Counts[at.block][faceDirection(at.face)] - 1 : 0;
  p[faceAxis(at.face, 0)] = s;
  p[faceAxis(at.face, 1)] = t;
  return this->surfacePoint(at.block, p);
}

/// The rows of the tables for a block: triples, or x, y, z, weight if the volume is rational.
void BezierExtraction::evaluateBox(
  int block, const std::array<WeightTable, 3>& tables, double* values, const Execution& run) const
{
  const BSplineVolume& volume = this->Volumes[block];
  const std::array<int, 3> counts{ volume.count(0), volume.count(1), volume.count(2) };
  if (!this->Rational)
  {
    tensorPasses({ counts, 3, volume.points }, tables, values, run);
    return;
  }
  const std::vector<double> net = homogeneousNet(volume);
  tensorPasses({ counts, 4, net.data() }, tables, values, run);
  const Index points = Index(tables[0].rows()) * tables[1].rows() * tables[2].rows();
  for (Index i = 0; i < points; ++i)
  {
    for (int c = 0; c < 3; ++c)
    {
      values[4 * i + c] /= values[4 * i + 3];
    }
  }
}

void BezierExtraction::evaluateSurfaces(const Execution& run)
{
  const int size = this->Rational ? 4 : 3;
  this->SurfaceValues.resize(static_cast<std::size_t>(size * this->SurfacePoints));
  Execution silent = run;
  silent.progress = [](double) { return true; };
  std::vector<double> plane;
  for (std::size_t b = 0; b < this->Volumes.size(); ++b)
  {
    run.report(static_cast<double>(b) / this->Volumes.size());
    for (int f = 0; this->isHere(static_cast<int>(b)) && f < 6; ++f)
    {
      const int d = faceDirection(f);
      std::array<WeightTable, 3> tables = this->Tables[b];
      const int row = faceSide(f) ? tables[d].rows() - 1 : 0;
      tables[d] = tables[d].slice(row, row + 1);
      const int ns = tables[faceAxis(f, 0)].rows();
      const int nt = tables[faceAxis(f, 1)].rows();
      plane.resize(static_cast<std::size_t>(size) * ns * nt);
      this->evaluateBox(static_cast<int>(b), tables, plane.data(), silent);
      for (int t = 0; t < nt; ++t)
      {
        for (int s = 0; s < ns; ++s)
        {
          std::copy_n(plane.data() + size * (s + Index(ns) * t), size,
            this->SurfaceValues.data() + size * this->surfacePoint({ static_cast<int>(b), f }, s, t));
        }
      }
    }
  }
}

/// Whether both faces of a contact have the same numbers of Bezier points.
bool BezierExtraction::faceCountsFit(const Interface& contact) const
{
  for (int axis = 0; axis < 2; ++axis)
  {
    const int other = swapsAxes(contact.orientation) ? 1 - axis : axis;
    if (this->Counts[contact.blockA][faceAxis(contact.faceA, axis)] !=
      this->Counts[contact.blockB][faceAxis(contact.faceB, other)])
    {
      return false;
    }
  }
  return true;
}

/// Whether two surface points, of blocks A and B, are equal up to rounding.
bool BezierExtraction::equal(const double* x, int blockA, const double* y, int blockB) const
{
  const double tolerance = std::max(this->Tolerances[blockA], this->Tolerances[blockB]);
  for (int c = 0; c < 3; ++c)
  {
    if (!(std::abs(x[c] - y[c]) <= tolerance))
    {
      return false;
    }
  }
  return !this->Rational || std::abs(x[3] - y[3]) <= WeldTolerance * std::max(x[3], y[3]);
}

/// For pairs of faces, the same on all ranks: the points of each for the rank of the other. Collective.
BezierExtraction::FaceValues BezierExtraction::fetchFaces(
  const std::vector<std::array<BlockFace, 2>>& pairs, const Ranks& ranks) const
{
  const std::size_t size = this->Rational ? 4 : 3;
  std::set<std::pair<int, int>> wanted; // face, rank
  for (const auto& pair : pairs)
  {
    for (int side = 0; side < 2; ++side)
    {
      const BlockFace& at = pair[side];
      const int to = this->Volumes[pair[1 - side].block].rank;
      if (to != this->Volumes[at.block].rank)
      {
        wanted.emplace(6 * at.block + at.face, to);
      }
    }
  }
  const auto points = [&](int face) {
    const Ijk& n = this->Counts[face / 6];
    return std::size_t(n[faceAxis(face % 6, 0)]) * n[faceAxis(face % 6, 1)];
  };
  std::vector<std::vector<double>> toRank(ranks.size());
  for (const auto& [face, to] : wanted)
  {
    const BlockFace at{ face / 6, face % 6 };
    if (this->isHere(at.block))
    {
      const int ns = this->Counts[at.block][faceAxis(at.face, 0)];
      for (std::size_t i = 0; i < points(face); ++i)
      {
        const double* x = this->SurfaceValues.data() +
          size * this->surfacePoint(at, static_cast<int>(i % ns), static_cast<int>(i / ns));
        toRank[to].insert(toRank[to].end(), x, x + size);
      }
    }
  }
  const std::vector<std::vector<double>> received = ranks.exchange(toRank);
  std::vector<std::size_t> next(ranks.size(), 0);
  FaceValues result;
  for (const auto& [face, to] : wanted)
  {
    if (to == this->Rank)
    {
      const int from = this->Volumes[face / 6].rank;
      const auto begin = received[from].begin() + next[from];
      next[from] += size * points(face);
      result[face].assign(begin, received[from].begin() + next[from]);
    }
  }
  return result;
}

/// Point (s, t) of a face, of this rank or fetched.
const double* BezierExtraction::valueAt(const BlockFace& at, int s, int t, const FaceValues& fetched) const
{
  const std::size_t size = this->Rational ? 4 : 3;
  return this->isHere(at.block) ? this->SurfaceValues.data() + size * this->surfacePoint(at, s, t)
                                : fetched.at(6 * at.block + at.face).data() +
      size * (s + std::size_t(this->Counts[at.block][faceAxis(at.face, 0)]) * t);
}

/// Pairs of faces that are equal up to rounding in some orientation. Each face is in at most one of them.
std::vector<Interface> BezierExtraction::coincidentFaces(const Ranks& ranks) const
{
  // Equal corners are found by a sweep along a direction in which hardly any others have the same place.
  struct Corner
  {
    double place;
    Index point;
    int block;
    std::array<double, 4> value;
  };
  const Vec3 sweep(0.577, 0.617, 0.535);
  const int size = this->Rational ? 4 : 3;
  const int blocks = static_cast<int>(this->Volumes.size());
  std::vector<Corner> corners;
  for (int b = 0; b < blocks; ++b)
  {
    for (int c = 0; this->isHere(b) && c < 8; ++c)
    {
      const Ijk at = this->cornerOf(b, c);
      const double* value = this->SurfaceValues.data() + size * this->surfacePoint(b, at);
      const double place = sweep.dot(Eigen::Map<const Vec3>(value));
      if (std::isfinite(place))
      {
        corners.push_back({ place, this->Surface.point(b, at), b, {} });
        std::copy_n(value, size, corners.back().value.data());
      }
    }
  }
  corners = ranks.gatherAll(corners);
  std::sort(corners.begin(), corners.end(),
    [](const Corner& a, const Corner& b) { return a.place < b.place || (a.place == b.place && a.point < b.point); });
  const double window =
    this->Tolerances.empty() ? 0.0 : 4.0 * *std::max_element(this->Tolerances.begin(), this->Tolerances.end());
  UnionFind groups(static_cast<Index>(corners.size()));
  std::map<Index, Index> groupOf; // of a surface point
  for (std::size_t i = 0; i < corners.size(); ++i)
  {
    groupOf[corners[i].point] = static_cast<Index>(i);
    for (std::size_t j = i + 1; j < corners.size() && corners[j].place - corners[i].place <= window; ++j)
    {
      if (this->equal(corners[i].value.data(), corners[i].block, corners[j].value.data(), corners[j].block))
      {
        groups.unite(static_cast<Index>(i), static_cast<Index>(j));
      }
    }
  }

  // Faces by their corners, in any order.
  using Key = std::array<Index, 4>;
  std::vector<std::pair<Key, BlockFace>> faces;
  for (int b = 0; b < blocks; ++b)
  {
    for (int f = 0; f < 6; ++f)
    {
      Key key{};
      bool known = true;
      for (int c = 0; c < 4; ++c)
      {
        const auto found = groupOf.find(this->Surface.point(b, this->cornerOf(b, faceCorner(f, c & 1, c >> 1))));
        known = known && found != groupOf.end();
        key[c] = known ? groups.find(found->second) : 0;
      }
      if (known)
      {
        std::sort(key.begin(), key.end());
        faces.push_back({ key, { b, f } });
      }
    }
  }
  const auto contactOf = [&](const BlockFace& one, const BlockFace& other, const FaceValues& fetched) {
    Interface contact;
    contact.blockA = one.block;
    contact.faceA = one.face;
    contact.blockB = other.block;
    contact.faceB = other.face;
    while (contact.orientation < 8 && !this->coincide(contact, fetched))
    {
      ++contact.orientation;
    }
    return contact;
  };
  const auto number = [](const BlockFace& at) { return 6 * at.block + at.face; };
  // A process that is alone compares as it goes. Of several that of the first face compares all pairs.
  std::map<std::pair<int, int>, Interface> compared;
  if (ranks.size() > 1)
  {
    std::map<Key, std::vector<BlockFace>> before;
    std::vector<std::array<BlockFace, 2>> pairs;
    for (const auto& [key, at] : faces)
    {
      for (const BlockFace& other : before[key])
      {
        pairs.push_back({ other, at });
      }
      before[key].push_back(at);
    }
    const FaceValues fetched = this->fetchFaces(pairs, ranks);
    std::vector<Interface> own;
    for (const auto& pair : pairs)
    {
      if (this->isHere(pair[0].block))
      {
        own.push_back(contactOf(pair[0], pair[1], fetched));
      }
    }
    for (const Interface& contact : ranks.gatherAll(own))
    {
      compared[{ 6 * contact.blockA + contact.faceA, 6 * contact.blockB + contact.faceB }] = contact;
    }
  }

  std::map<Key, std::vector<BlockFace>> waiting;
  std::vector<Interface> contacts;
  for (const auto& [key, face] : faces)
  {
    const BlockFace at = face;
    std::vector<BlockFace>& candidates = waiting[key];
    Interface contact;
    const auto found = std::find_if(candidates.begin(), candidates.end(), [&](const BlockFace& other) {
      contact = ranks.size() > 1 ? compared[{ number(other), number(at) }] : contactOf(other, at, {});
      return contact.orientation < 8;
    });
    if (found == candidates.end())
    {
      candidates.push_back(at);
    }
    else
    {
      contacts.push_back(contact);
      candidates.erase(found);
    }
  }
  return contacts;
}

/// Calls visit(s, t, m) with the points (s, t) and m of the two faces that a contact brings together, until it returns
/// false.
template <typename Visitor>
void BezierExtraction::overContact(const Interface& contact, Visitor&& visit) const
{
  const int ns = this->Counts[contact.blockA][faceAxis(contact.faceA, 0)] - 1;
  const int nt = this->Counts[contact.blockA][faceAxis(contact.faceA, 1)] - 1;
  for (int t = 0; t <= nt; ++t)
  {
    for (int s = 0; s <= ns; ++s)
    {
      if (!visit(s, t, mapFacePoint(contact.orientation, s, t, ns, nt)))
      {
        return;
      }
    }
  }
}

bool BezierExtraction::coincide(const Interface& contact, const FaceValues& fetched) const
{
  const BlockFace a{ contact.blockA, contact.faceA };
  const BlockFace b{ contact.blockB, contact.faceB };
  bool same = this->faceCountsFit(contact);
  if (same)
  {
    this->overContact(contact, [&](int s, int t, const std::array<int, 2>& m) {
      same = this->equal(this->valueAt(a, s, t, fetched), a.block, this->valueAt(b, m[0], m[1], fetched), b.block);
      return same;
    });
  }
  return same;
}

/// Continues groups of equal points across the borders of ranks: their first points get the smallest value of all, and
/// groups that are one through other ranks are united. Collective.
void BezierExtraction::shareGroups(const std::vector<Interface>& contacts, UnionFind& groups, const Ranks& ranks)
{
  /// What is known of a group, here and elsewhere.
  struct Group
  {
    std::array<double, 4> value{}; ///< the smallest
    Index origin = -1;             ///< the first point that has it, in the numbers of all ranks
    Index first = -1;              ///< the first of all its points

    bool offer(const Group& other)
    {
      const bool smaller =
        this->origin < 0 || other.value < this->value || (!(this->value < other.value) && other.origin < this->origin);
      if (smaller)
      {
        this->value = other.value;
        this->origin = other.origin;
      }
      const bool earlier = this->first < 0 || other.first < this->first;
      this->first = earlier ? other.first : this->first;
      return smaller || earlier;
    }
  };
  /// The points of a contact with another rank that are equal.
  struct Border
  {
    int rank;
    std::vector<Index> groups; ///< places in `known`
  };
  const int size = this->Rational ? 4 : 3;

  std::vector<const Interface*> between;
  std::vector<std::array<BlockFace, 2>> pairs;
  for (const Interface& contact : contacts)
  {
    if (this->Volumes[contact.blockA].rank != this->Volumes[contact.blockB].rank && this->faceCountsFit(contact))
    {
      between.push_back(&contact);
      pairs.push_back({ BlockFace{ contact.blockA, contact.faceA }, BlockFace{ contact.blockB, contact.faceB } });
    }
  }
  std::vector<Border> borders;
  std::vector<Group> known;
  std::vector<Index> firstPoint; // here, per known group
  std::vector<Index> placeOf(static_cast<std::size_t>(this->SurfacePoints), -1);
  const FaceValues fetched = this->fetchFaces(pairs, ranks);
  for (std::size_t n = 0; n < pairs.size(); ++n)
  {
    const auto& [a, b] = pairs[n];
    if (!this->isHere(a.block) && !this->isHere(b.block))
    {
      continue;
    }
    borders.push_back({ this->Volumes[this->isHere(a.block) ? b.block : a.block].rank, {} });
    this->overContact(*between[n], [&, &a = a, &b = b](int s, int t, const std::array<int, 2>& m) {
      if (this->equal(this->valueAt(a, s, t, fetched), a.block, this->valueAt(b, m[0], m[1], fetched), b.block))
      {
        const Index point = this->isHere(a.block) ? this->surfacePoint(a, s, t) : this->surfacePoint(b, m[0], m[1]);
        Index& place = placeOf[groups.find(point)];
        if (place < 0)
        {
          place = static_cast<Index>(known.size());
          known.emplace_back();
          firstPoint.push_back(groups.find(point));
        }
        borders.back().groups.push_back(place);
      }
      return true;
    });
  }
  for (int block = 0; block < static_cast<int>(this->Volumes.size()); ++block)
  {
    const Index first = this->Surface.firstPoint(block);
    const Index points = this->isHere(block) ? this->Surface.firstPoint(block + 1) - first : 0;
    for (Index i = 0; i < points; ++i)
    {
      const Index place = placeOf[groups.find(this->Start[block] + i)];
      if (place >= 0)
      {
        Group own;
        std::copy_n(this->SurfaceValues.data() + size * (this->Start[block] + i), size, own.value.data());
        own.origin = own.first = first + i;
        known[place].offer(own);
      }
    }
  }

  // Until nobody learns anything: as often as there are borders between the ranks around a block edge or corner.
  for (bool news = true; ranks.any(news);)
  {
    std::vector<std::vector<Group>> toRank(ranks.size());
    for (const Border& border : borders)
    {
      for (const Index place : border.groups)
      {
        toRank[border.rank].push_back(known[place]);
      }
    }
    const std::vector<std::vector<Group>> received = ranks.exchange(toRank);
    std::vector<std::size_t> next(ranks.size(), 0);
    news = false;
    for (const Border& border : borders)
    {
      for (const Index place : border.groups)
      {
        news = known[place].offer(received[border.rank][next[border.rank]++]) || news;
      }
    }
  }
  std::vector<std::pair<Index, Index>> sameFirst; // first of all points, first point here
  for (std::size_t n = 0; n < known.size(); ++n)
  {
    std::copy_n(known[n].value.data(), size, this->SurfaceValues.data() + size * firstPoint[n]);
    sameFirst.emplace_back(known[n].first, firstPoint[n]);
  }
  std::sort(sameFirst.begin(), sameFirst.end());
  for (std::size_t n = 1; n < sameFirst.size(); ++n)
  {
    if (sameFirst[n].first == sameFirst[n - 1].first)
    {
      groups.unite(sameFirst[n].second, sameFirst[n - 1].second);
    }
  }
}

void BezierExtraction::number(const std::vector<Interface>& contacts, BezierCells cells, const Ranks& ranks)
{
  const int size = this->Rational ? 4 : 3;
  UnionFind groups(this->SurfacePoints);
  for (const Interface& contact : contacts)
  {
    if (this->isHere(contact.blockA) && this->isHere(contact.blockB) && this->faceCountsFit(contact))
    {
      this->overContact(contact, [&](int s, int t, const std::array<int, 2>& m) {
        const Index a = this->surfacePoint({ contact.blockA, contact.faceA }, s, t);
        const Index b = this->surfacePoint({ contact.blockB, contact.faceB }, m[0], m[1]);
        const double* values = this->SurfaceValues.data();
        if (this->equal(values + size * a, contact.blockA, values + size * b, contact.blockB))
        {
          groups.unite(a, b);
        }
        return true;
      });
    }
  }
  if (ranks.size() > 1)
  {
    this->shareGroups(contacts, groups, ranks);
  }
  // Of values that differ by rounding the smallest is taken: no order of blocks decides.
  for (Index i = 0; i < this->SurfacePoints; ++i)
  {
    double* first = this->SurfaceValues.data() + size * groups.find(i);
    const double* other = this->SurfaceValues.data() + size * i;
    if (std::lexicographical_compare(other, other + size, first, first + size))
    {
      std::copy_n(other, size, first);
    }
  }

  const bool volume = cells == BezierCells::Volume;
  std::vector<bool> used(static_cast<std::size_t>(this->SurfacePoints), volume);
  if (!volume)
  {
    std::vector<std::array<bool, 6>> left(this->Volumes.size(), { false, false, false, false, false, false });
    for (const Interface& contact : contacts)
    {
      const bool aFirst =
        std::make_pair(contact.blockA, contact.faceA) <= std::make_pair(contact.blockB, contact.faceB);
      const bool all = cells == BezierCells::AllFaces;
      left[contact.blockA][contact.faceA] = !all || !aFirst;
      left[contact.blockB][contact.faceB] = !all || aFirst;
    }
    for (int b = 0; b < static_cast<int>(this->Volumes.size()); ++b)
    {
      for (int f = 0; f < 6; ++f)
      {
        if (left[b][f] || !this->isHere(b))
        {
          continue;
        }
        this->Faces.push_back({ b, f });
        for (int t = 0; t < this->Counts[b][faceAxis(f, 1)]; ++t)
        {
          for (int s = 0; s < this->Counts[b][faceAxis(f, 0)]; ++s)
          {
            used[groups.find(this->surfacePoint({ b, f }, s, t))] = true;
          }
        }
      }
    }
  }
  this->SurfaceNumbers.assign(static_cast<std::size_t>(this->SurfacePoints), -1);
  for (Index i = 0; i < this->SurfacePoints; ++i)
  {
    const Index first = groups.find(i);
    if (used[first])
    {
      this->SurfaceNumbers[i] = first == i ? this->PointCount++ : this->SurfaceNumbers[first];
    }
  }
  if (volume)
  {
    for (int b = 0; b < static_cast<int>(this->Volumes.size()); ++b)
    {
      const Ijk& n = this->Counts[b];
      this->InsideStart.push_back(this->PointCount);
      this->PointCount += this->isHere(b) ? Index(n[0] - 2) * (n[1] - 2) * (n[2] - 2) : 0;
    }
  }
}

void BezierExtraction::evaluate(double* points, double* weights, const Execution& run) const
{
  const int size = this->Rational ? 4 : 3;
  // A group's values are those of its first point, which comes last here.
  for (Index i = this->SurfacePoints - 1; i >= 0; --i)
  {
    const Index number = this->SurfaceNumbers[i];
    if (number >= 0)
    {
      const double* from = this->SurfaceValues.data() + size * i;
      std::copy_n(from, 3, points + 3 * number);
      if (this->Rational)
      {
        weights[number] = from[3];
      }
    }
  }

  std::vector<double> rational;
  for (std::size_t b = 0; b < this->InsideStart.size(); ++b)
  {
    std::array<WeightTable, 3> tables;
    Index inside = 1;
    for (int d = 0; d < 3; ++d)
    {
      tables[d] = this->Tables[b][d].slice(1, this->Counts[b][d] - 1);
      inside *= tables[d].rows();
    }
    if (inside == 0 || !this->isHere(static_cast<int>(b)))
    {
      continue;
    }
    Execution part = run;
    part.progress = [&](double fraction) { return run.progress((b + fraction) / this->InsideStart.size()); };
    double* to = points + 3 * this->InsideStart[b];
    if (!this->Rational)
    {
      this->evaluateBox(static_cast<int>(b), tables, to, part);
      continue;
    }
    rational.resize(static_cast<std::size_t>(4 * inside));
    this->evaluateBox(static_cast<int>(b), tables, rational.data(), part);
    for (Index i = 0; i < inside; ++i)
    {
      to = std::copy_n(rational.data() + 4 * i, 3, to);
      weights[this->InsideStart[b] + i] = rational[4 * i + 3];
    }
  }
  run.report(1.0);
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
#include "BezierExtraction.h"

#include "BezierSegments.h"
#include "UnionFind.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

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
    block.points = GridView(static_cast<const double*>(nullptr), n);
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
  , Counts(allCounts(volumes))
  , Surface(surfacesOf(this->Counts))
{
  for (std::size_t b = 0; b < volumes.size(); ++b)
  {
    const BSplineVolume& volume = volumes[b];
    this->Rational = this->Rational || volume.weights;
    std::array<WeightTable, 3> tables;
    Ijk spans;
    for (int d = 0; d < 3; ++d)
    {
      tables[d] = bezierTable(volume.degree[d], volume.knots[d]);
      spans[d] = (this->Counts[b][d] - 1) / volume.degree[d];
    }
    this->Tables.push_back(std::move(tables));
    this->Spans.push_back(spans);
    this->Tolerances.push_back(WeldTolerance * largestCoordinate(volume));
  }
  this->evaluateSurfaces(run);
  this->number(interfaces ? *interfaces : this->coincidentFaces(), cells);
}

Index BezierExtraction::point(int block, const Ijk& p) const
{
  const Ijk& n = this->Counts[block];
  for (int d = 0; d < 3; ++d)
  {
    if (p[d] == 0 || p[d] == n[d] - 1)
    {
      return this->SurfaceNumbers[this->Surface.point(block, p)];
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

/// Number of the Bezier point (s, t) of a face before any are shared.
Index BezierExtraction::surfacePoint(const BlockFace& at, int s, int t) const
{
  Ijk p;
  p[faceDirection(at.face)] = faceSide(at.face) ? this->Counts[at.block][faceDirection(at.face)] - 1 : 0;
  p[faceAxis(at.face, 0)] = s;
  p[faceAxis(at.face, 1)] = t;
  return this->Surface.point(at.block, p);
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
  this->SurfaceValues.resize(static_cast<std::size_t>(size * this->Surface.pointCount()));
  Execution silent = run;
  silent.progress = [](double) { return true; };
  std::vector<double> plane;
  for (std::size_t b = 0; b < this->Volumes.size(); ++b)
  {
    run.report(static_cast<double>(b) / this->Volumes.size());
    for (int f = 0; f < 6; ++f)
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
bool BezierExtraction::equal(Index a, int blockA, Index b, int blockB) const
{
  const int size = this->Rational ? 4 : 3;
  const double* x = this->SurfaceValues.data() + size * a;
  const double* y = this->SurfaceValues.data() + size * b;
  const double tolerance = std::max(this->Tolerances[blockA], this->Tolerances[blockB]);
  for (int c = 0; c < 3; ++c)
  {
    if (!(std::abs(x[c] - y[c]) <= tolerance))
    {
      return false;
    }
  }
  return size == 3 || std::abs(x[3] - y[3]) <= WeldTolerance * std::max(x[3], y[3]);
}

/// Pairs of faces that are equal up to rounding in some orientation. Each face is in at most one of them.
std::vector<Interface> BezierExtraction::coincidentFaces() const
{
  // Equal corners are found by a sweep along a direction in which hardly any others have the same place.
  struct Corner
  {
    double place;
    Index point;
    int block;
  };
  const Vec3 sweep(0.577, 0.617, 0.535);
  const int size = this->Rational ? 4 : 3;
  const int blocks = static_cast<int>(this->Volumes.size());
  std::vector<Corner> corners;
  for (int b = 0; b < blocks; ++b)
  {
    for (int c = 0; c < 8; ++c)
    {
      const Index point = this->Surface.point(b, this->cornerOf(b, c));
      const double place = sweep.dot(Eigen::Map<const Vec3>(this->SurfaceValues.data() + size * point));
      if (std::isfinite(place))
      {
        corners.push_back({ place, point, b });
      }
    }
  }
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
      if (this->equal(corners[i].point, corners[i].block, corners[j].point, corners[j].block))
      {
        groups.unite(static_cast<Index>(i), static_cast<Index>(j));
      }
    }
  }

  std::map<std::array<Index, 4>, std::vector<BlockFace>> waiting;
  std::vector<Interface> contacts;
  for (int b = 0; b < blocks; ++b)
  {
    for (int f = 0; f < 6; ++f)
    {
      std::array<Index, 4> key{};
      bool known = true;
      for (int c = 0; c < 4; ++c)
      {
        const auto found = groupOf.find(this->Surface.point(b, this->cornerOf(b, faceCorner(f, c & 1, c >> 1))));
        known = known && found != groupOf.end();
        key[c] = known ? groups.find(found->second) : 0;
      }
      if (!known)
      {
        continue;
      }
      std::sort(key.begin(), key.end());
      std::vector<BlockFace>& candidates = waiting[key];
      Interface contact;
      const auto found = std::find_if(candidates.begin(), candidates.end(), [&](const BlockFace& other) {
        contact = {};
        contact.blockA = other.block;
        contact.faceA = other.face;
        contact.blockB = b;
        contact.faceB = f;
        while (contact.orientation < 8 && !this->coincide(contact))
        {
          ++contact.orientation;
        }
        return contact.orientation < 8;
      });
      if (found == candidates.end())
      {
        candidates.push_back({ b, f });
      }
      else
      {
        contacts.push_back(contact);
        candidates.erase(found);
      }
    }
  }
  return contacts;
}

/// Calls visit(a, b) with the pairs of surface points that a contact brings together, until it returns false.
template <typename Visitor>
void BezierExtraction::overContact(const Interface& contact, Visitor&& visit) const
{
  const int ns = this->Counts[contact.blockA][faceAxis(contact.faceA, 0)] - 1;
  const int nt = this->Counts[contact.blockA][faceAxis(contact.faceA, 1)] - 1;
  for (int t = 0; t <= nt; ++t)
  {
    for (int s = 0; s <= ns; ++s)
    {
      const std::array<int, 2> m = mapFacePoint(contact.orientation, s, t, ns, nt);
      if (!visit(this->surfacePoint({ contact.blockA, contact.faceA }, s, t),
            this->surfacePoint({ contact.blockB, contact.faceB }, m[0], m[1])))
      {
        return;
      }
    }
  }
}

bool BezierExtraction::coincide(const Interface& contact) const
{
  bool same = this->faceCountsFit(contact);
  if (same)
  {
    this->overContact(contact, [&](Index a, Index b) {
      same = this->equal(a, contact.blockA, b, contact.blockB);
      return same;
    });
  }
  return same;
}

void BezierExtraction::number(const std::vector<Interface>& contacts, BezierCells cells)
{
  const int size = this->Rational ? 4 : 3;
  const Index surfacePoints = this->Surface.pointCount();
  UnionFind groups(surfacePoints);
  for (const Interface& contact : contacts)
  {
    if (this->faceCountsFit(contact))
    {
      this->overContact(contact, [&](Index a, Index b) {
        if (this->equal(a, contact.blockA, b, contact.blockB))
        {
          groups.unite(a, b);
        }
        return true;
      });
    }
  }
  // Of values that differ by rounding the smallest is taken: no order of blocks decides.
  for (Index i = 0; i < surfacePoints; ++i)
  {
    double* first = this->SurfaceValues.data() + size * groups.find(i);
    const double* other = this->SurfaceValues.data() + size * i;
    if (std::lexicographical_compare(other, other + size, first, first + size))
    {
      std::copy_n(other, size, first);
    }
  }

  const bool volume = cells == BezierCells::Volume;
  std::vector<bool> used(static_cast<std::size_t>(surfacePoints), volume);
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
        if (left[b][f])
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
  this->SurfaceNumbers.assign(static_cast<std::size_t>(surfacePoints), -1);
  for (Index i = 0; i < surfacePoints; ++i)
  {
    const Index first = groups.find(i);
    if (used[first])
    {
      this->SurfaceNumbers[i] = first == i ? this->PointCount++ : this->SurfaceNumbers[first];
    }
  }
  if (volume)
  {
    for (const Ijk& n : this->Counts)
    {
      this->InsideStart.push_back(this->PointCount);
      this->PointCount += Index(n[0] - 2) * (n[1] - 2) * (n[2] - 2);
    }
  }
}

void BezierExtraction::evaluate(double* points, double* weights, const Execution& run) const
{
  const int size = this->Rational ? 4 : 3;
  // A group's values are those of its first point, which comes last here.
  for (Index i = this->Surface.pointCount() - 1; i >= 0; --i)
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
    if (inside == 0)
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

// SPDX-License-Identifier: BSD-3-Clause
#include "Mesh/MeshCheck.h"

#include "Mesh/BlockSurface.h"
#include "Mesh/PlainCells.h"
#include "Ranks/Ranks.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace bsv
{

namespace
{

/// Layers [begin, end) of cells of one block.
struct Slab
{
  int block;
  int begin;
  int end;
};

enum class Fault
{
  None,
  NotFinite,
  Degenerate
};

/// Cells are numbered i fastest within their block.
struct CellCount
{
  double volume = 0.0;
  /// Cells by the sign of their corner Jacobians: all negative, mixed or zero, all positive; and the first of each.
  std::array<Index, 3> cells{ 0, 0, 0 };
  std::array<Ijk, 3> firstCell{};
};

/// What was found in a slab.
struct Finding : CellCount
{
  Fault fault = Fault::None;
  Ijk faultAt{ 0, 0, 0 };
  const char* faultText = "";
};

enum CellSign
{
  Negative,
  Mixed,
  Positive
};

/// True if the four corners of quadrilateral a b d c (a opposite d) have no area.
bool flat(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d)
{
  const auto noArea = [](const Vec3& u, const Vec3& v) {
    return u.cross(v).squaredNorm() <= FlatSquared * u.squaredNorm() * v.squaredNorm();
  };
  return noArea(b - a, c - a) && noArea(a - b, d - b) && noArea(a - c, d - c) && noArea(b - d, c - d);
}

class SlabCheck
{
public:
  SlabCheck(const GridView& points, double zeroLength, bool allowDegenerate)
    : Points(points)
    , ZeroLengthSquared(zeroLength * zeroLength)
    , AllowDegenerate(allowDegenerate)
  {
  }

  Finding operator()(const Slab& slab) const
  {
    Finding found;
    const Ijk& n = this->Points.counts();
    // Nearly all cells of nearly all meshes are plain; what follows would find the same of them.
    const PlainCells plain = plainCells(this->Points, slab.begin, slab.end, this->ZeroLengthSquared);
    if (plain.sign != 0)
    {
      const CellSign sign = plain.sign > 0 ? Positive : Negative;
      found.volume = plain.volume;
      found.cells[sign] = Index(n[0] - 1) * (n[1] - 1) * (slab.end - slab.begin);
      found.firstCell[sign] = { 0, 0, slab.begin };
      return found;
    }
    for (int k = slab.begin; k <= slab.end; ++k)
    {
      for (int j = 0; j < n[1]; ++j)
      {
        for (int i = 0; i < n[0]; ++i)
        {
          if (!this->Points(i, j, k).allFinite())
          {
            found.fault = Fault::NotFinite;
            found.faultAt = { i, j, k };
            return found;
          }
        }
      }
    }
    for (int k = slab.begin; k < slab.end; ++k)
    {
      for (int j = 0; j + 1 < n[1]; ++j)
      {
        for (int i = 0; i + 1 < n[0]; ++i)
        {
          this->checkCell({ i, j, k }, found);
          if (found.fault != Fault::None)
          {
            return found;
          }
        }
      }
    }
    return found;
  }

private:
  void checkCell(const Ijk& cell, Finding& found) const
  {
    std::array<Vec3, 8> x;
    for (int c = 0; c < 8; ++c)
    {
      x[c] = this->Points(cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2));
    }
    // Edge vectors in the numbering of the block's edges.
    std::array<Vec3, 12> edge;
    std::array<double, 12> lengthSquared;
    double shortest = std::numeric_limits<double>::max();
    for (int e = 0; e < 12; ++e)
    {
      edge[e] = x[edgeCorner(e, 1)] - x[edgeCorner(e, 0)];
      lengthSquared[e] = edge[e].squaredNorm();
      shortest = std::min(shortest, lengthSquared[e]);
    }
    int positive = 0;
    int negative = 0;
    for (int c = 0; c < 8; ++c)
    {
      const int ei = edgeIndex(0, c >> 1 & 1, c >> 2);
      const int ej = edgeIndex(1, c & 1, c >> 2);
      const int ek = edgeIndex(2, c & 1, c >> 1 & 1);
      const double jacobian = edge[ei].cross(edge[ej]).dot(edge[ek]);
      const bool zero = jacobian * jacobian <= FlatSquared * lengthSquared[ei] * lengthSquared[ej] * lengthSquared[ek];
      positive += !zero && jacobian > 0.0;
      negative += !zero && jacobian < 0.0;
      found.volume += jacobian;
    }
    const CellSign sign = positive == 8 ? Positive : negative == 8 ? Negative : Mixed;
    if (found.cells[sign]++ == 0)
    {
      found.firstCell[sign] = cell;
    }
    if (!this->AllowDegenerate)
    {
      if (shortest <= this->ZeroLengthSquared)
      {
        this->degenerate(found, cell, "has an edge of no length");
      }
      else if (positive + negative == 0)
      {
        this->degenerate(found, cell, "has no volume");
      }
      else if (positive + negative <= 4)
      {
        for (int face = 0; face < 6; ++face)
        {
          if (flat(x[faceCorner(face, 0, 0)], x[faceCorner(face, 1, 0)], x[faceCorner(face, 0, 1)],
                x[faceCorner(face, 1, 1)]))
          {
            this->degenerate(found, cell, "has a face of no area");
            return;
          }
        }
      }
    }
  }

  void degenerate(Finding& found, const Ijk& cell, const char* what) const
  {
    found.fault = Fault::Degenerate;
    found.faultAt = cell;
    found.faultText = what;
  }

  const GridView& Points;
  double ZeroLengthSquared;
  bool AllowDegenerate;
};

double largestCoordinate(const GridView& points)
{
  const Ijk& n = points.counts();
  double largest = 0.0;
  // The corners are enough for a scale.
  for (int c = 0; c < 8; ++c)
  {
    const Vec3 x = points(cornerSide(c, 0) * (n[0] - 1), cornerSide(c, 1) * (n[1] - 1), cornerSide(c, 2) * (n[2] - 1));
    largest = std::max(largest, x.cwiseAbs().maxCoeff());
  }
  return largest;
}

void checkSizes(const BlockMesh& mesh, const Ranks& ranks)
{
  for (int b = 0; b < static_cast<int>(mesh.blocks.size()); ++b)
  {
    const MeshBlock& block = mesh.blocks[b];
    for (int d = 0; d < 3; ++d)
    {
      if (block.points.counts()[d] < 2)
      {
        throw ErrorAt(b,
          blockLabel(mesh, b) + " has " + std::to_string(block.points.counts()[d]) + " points in direction " +
            "ijk"[d] + ", at least 2 are needed");
      }
    }
    const bool alone = ranks.size() == 1;
    if (block.points.isHere() != (alone || block.rank == ranks.rank()) ||
      (!alone && (block.rank < 0 || block.rank >= ranks.size())))
    {
      throw ErrorAt(b,
        blockLabel(mesh, b) + " belongs to rank " + std::to_string(block.rank) + " of " + std::to_string(ranks.size()) +
          ", where its points are not");
    }
    if (block.creaseSharpness.empty())
    {
      continue;
    }
    if (static_cast<Index>(block.creaseSharpness.size()) != block.points.size())
    {
      throw ErrorAt(b,
        blockLabel(mesh, b) + " has " + std::to_string(block.creaseSharpness.size()) +
          " values of crease sharpness for " + std::to_string(block.points.size()) + " points");
    }
    for (Index n = 0; n < block.points.size(); ++n)
    {
      const double sharpness = block.creaseSharpness[n];
      if (!(sharpness == 0.0 || sharpness >= SharpnessInfinite))
      {
        const Ijk& counts = block.points.counts();
        const Ijk at{ static_cast<int>(n % counts[0]), static_cast<int>(n / counts[0] % counts[1]),
          static_cast<int>(n / counts[0] / counts[1]) };
        throw ErrorAt(b,
          blockLabel(mesh, b) + ", point " + text(at) + ": crease sharpness " + text(sharpness) +
            " is neither 0 nor infinite (at least " + text(SharpnessInfinite) +
            "); semi-sharp creases are not supported");
      }
    }
  }
}

[[noreturn]] void throwNotFinite(const BlockMesh& mesh, int block, const Ijk& point)
{
  throw ErrorAt(block,
    blockLabel(mesh, block) + ", point " + text(point) + ": coordinates " + text(mesh.blocks[block].points(point)) +
      " are not finite");
}

/// Counts the cells of the blocks that are here.
std::vector<CellCount> checkCells(const BlockMesh& mesh, bool allowDegenerate, const Execution& run)
{
  // Slabs of some ten thousand cells, over all blocks, so that many small blocks cost as little as a large one.
  constexpr Index CellsPerSlab = 1 << 15;
  constexpr Index SlabsPerReport = 128;
  const int blockCount = static_cast<int>(mesh.blocks.size());
  std::vector<Slab> slabs;
  std::vector<double> zeroLength(blockCount, 0.0);
  for (int b = 0; b < blockCount; ++b)
  {
    if (!mesh.blocks[b].points.isHere())
    {
      continue;
    }
    const GridView& points = mesh.blocks[b].points;
    const Ijk& n = points.counts();
    const Index layers = std::max<Index>(1, CellsPerSlab / (Index(n[0]) * n[1]));
    for (Index k = 0; k < n[2] - 1; k += layers)
    {
      slabs.push_back({ b, static_cast<int>(k), static_cast<int>(std::min<Index>(k + layers, n[2] - 1)) });
    }
    zeroLength[b] = 16.0 * std::numeric_limits<double>::epsilon() * largestCoordinate(points);
  }

  std::vector<CellCount> perBlock(blockCount);
  std::vector<Finding> findings;
  const Index slabCount = static_cast<Index>(slabs.size());
  for (Index first = 0; first < slabCount; first += SlabsPerReport)
  {
    const Index count = std::min(SlabsPerReport, slabCount - first);
    findings.assign(count, Finding());
    run.parallelFor(count, 1, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        const Slab& slab = slabs[first + n];
        findings[n] = SlabCheck(mesh.blocks[slab.block].points, zeroLength[slab.block], allowDegenerate)(slab);
      }
    });
    for (Index n = 0; n < count; ++n)
    {
      const int b = slabs[first + n].block;
      const Finding& found = findings[n];
      if (found.fault == Fault::NotFinite)
      {
        throwNotFinite(mesh, b, found.faultAt);
      }
      if (found.fault == Fault::Degenerate)
      {
        throw ErrorAt(b,
          blockLabel(mesh, b) + ": cell " + text(found.faultAt) + " " + found.faultText + " (near " +
            text(mesh.blocks[b].points(found.faultAt)) + "); Allow Degenerate accepts collapsed cells");
      }
      perBlock[b].volume += found.volume;
      for (int sign = Negative; sign <= Positive; ++sign)
      {
        if (perBlock[b].cells[sign] == 0 && found.cells[sign] > 0)
        {
          perBlock[b].firstCell[sign] = found.firstCell[sign];
        }
        perBlock[b].cells[sign] += found.cells[sign];
      }
    }
    run.report(double(first + count) / slabCount);
  }
  return perBlock;
}

} // namespace

MeshCheck checkMesh(const BlockMesh& mesh, bool allowDegenerate, const Execution& run)
{
  std::vector<CellCount> perBlock;
  checkSizes(mesh, *run.ranks);
  run.ranks->nextStep();
  perBlock = checkCells(mesh, allowDegenerate, run);
  run.ranks->share(perBlock, [&](Index b) { return mesh.blocks[b].rank; });

  MeshCheck check;
  const int blockCount = static_cast<int>(mesh.blocks.size());
  check.leftHanded.resize(blockCount);

  const auto before = [](const Ijk& a, const Ijk& b) {
    return std::make_tuple(a[2], a[1], a[0]) < std::make_tuple(b[2], b[1], b[0]);
  };
  for (int b = 0; b < blockCount; ++b)
  {
    check.leftHanded[b] = perBlock[b].volume < 0.0;
    for (int sign : { check.leftHanded[b] ? Positive : Negative, Mixed })
    {
      if (perBlock[b].cells[sign] == 0)
      {
        continue;
      }
      const Ijk& cell = perBlock[b].firstCell[sign];
      if (check.tangledBlock < 0 || (check.tangledBlock == b && before(cell, check.tangledCell)))
      {
        check.tangledBlock = b;
        check.tangledCell = cell;
      }
      check.tangledCells += perBlock[b].cells[sign];
    }
  }
  return check;
}

void checkFinitePoints(const BlockMesh& mesh, const Execution& run)
{
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    const GridView& points = mesh.blocks[b].points;
    if (!points.isHere())
    {
      continue;
    }
    const Ijk counts = points.counts();
    // The exception of the lowest range is that of the first point.
    run.parallelFor(counts[2], 1, [&](Index begin, Index end) {
      for (int k = static_cast<int>(begin); k < end; ++k)
      {
        for (int j = 0; j < counts[1]; ++j)
        {
          for (int i = 0; i < counts[0]; ++i)
          {
            if (!points(i, j, k).allFinite())
            {
              throwNotFinite(mesh, static_cast<int>(b), { i, j, k });
            }
          }
        }
      }
    });
  }
  run.ranks->nextStep();
}

double minimumScaledJacobian(const GridView& points, const Execution& run)
{
  const Ijk& counts = points.counts();
  std::vector<double> layers(counts[2] - 1, 1.0);
  run.parallelFor(counts[2] - 1, 1, [&](Index begin, Index end) {
    for (int k = static_cast<int>(begin); k < end; ++k)
    {
      for (int j = 0; j + 1 < counts[1]; ++j)
      {
        for (int i = 0; i + 1 < counts[0]; ++i)
        {
          std::array<Vec3, 8> x;
          for (int v = 0; v < 8; ++v)
          {
            x[v] = points(i + (v & 1), j + (v >> 1 & 1), k + (v >> 2));
          }
          for (int v = 0; v < 8; ++v)
          {
            const Vec3 a = x[v | 1] - x[v & ~1], b = x[v | 2] - x[v & ~2], c = x[v | 4] - x[v & ~4];
            const double lengths = a.norm() * b.norm() * c.norm();
            layers[k] = std::min(layers[k], lengths > 0.0 ? a.cross(b).dot(c) / lengths : -1.0);
          }
        }
      }
    }
  });
  return *std::min_element(layers.begin(), layers.end());
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
/// @file VolumeCases.h
/// Random B-spline volumes for the tests: one lattice of control points, cut into blocks that are stored in random
/// orientations.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Volume/BSplineVolume.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <thread>
#include <vector>

namespace bsvtest
{

using bsv::BSplineVolume;
using bsv::Ijk;
using bsv::Index;
using bsv::Interface;

/// A block that owns its points, and its weights if it is rational.
struct Block
{
  BSplineVolume volume;
  std::vector<double> points;
  std::vector<double> weights;

  Ijk counts() const { return { volume.count(0), volume.count(1), volume.count(2) }; }
  Index at(const Ijk& i) const { return i[0] + Index(volume.count(0)) * (i[1] + Index(volume.count(1)) * i[2]); }
  BSplineVolume view() const
  {
    BSplineVolume result = volume;
    result.points = points.data();
    result.weights = weights.empty() ? nullptr : weights.data();
    return result;
  }
};

/// One of the 48 ways to store a block: new direction d runs along old direction order[d], backwards if flip[d].
struct Orientation
{
  std::array<int, 3> order{ 0, 1, 2 };
  std::array<bool, 3> flip{ false, false, false };

  /// Old position of the new position `i`; `counts` are the old ones.
  Ijk old(const Ijk& i, const Ijk& counts) const
  {
    Ijk result{};
    for (int d = 0; d < 3; ++d)
    {
      result[order[d]] = flip[d] ? counts[order[d]] - 1 - i[d] : i[d];
    }
    return result;
  }
};

inline std::vector<Orientation> allOrientations()
{
  std::vector<Orientation> all;
  Orientation o;
  do
  {
    for (int flips = 0; flips < 8; ++flips)
    {
      o.flip = { (flips & 1) != 0, (flips & 2) != 0, (flips & 4) != 0 };
      all.push_back(o);
    }
  } while (std::next_permutation(o.order.begin(), o.order.end()));
  return all;
}

inline std::vector<double> reversedKnots(const std::vector<double>& knots)
{
  std::vector<double> result;
  for (auto k = knots.rbegin(); k != knots.rend(); ++k)
  {
    result.push_back(knots.front() + (knots.back() - *k));
  }
  return result;
}

template <typename Visitor>
void forEach(const Ijk& counts, Visitor&& visit)
{
  Ijk i;
  for (i[2] = 0; i[2] < counts[2]; ++i[2])
  {
    for (i[1] = 0; i[1] < counts[1]; ++i[1])
    {
      for (i[0] = 0; i[0] < counts[0]; ++i[0])
      {
        visit(i);
      }
    }
  }
}

inline Block reoriented(const Block& block, const Orientation& o)
{
  Block result;
  for (int d = 0; d < 3; ++d)
  {
    const std::vector<double>& knots = block.volume.knots[o.order[d]];
    result.volume.degree[d] = block.volume.degree[o.order[d]];
    result.volume.knots[d] = o.flip[d] ? reversedKnots(knots) : knots;
  }
  forEach(result.counts(), [&](const Ijk& i) {
    const double* p = block.points.data() + 3 * block.at(o.old(i, block.counts()));
    result.points.insert(result.points.end(), p, p + 3);
    if (!block.weights.empty())
    {
      result.weights.push_back(block.weights[block.at(o.old(i, block.counts()))]);
    }
  });
  return result;
}

/// Coordinates over many magnitudes and of both signs.
inline double randomCoordinate(std::mt19937& random)
{
  const double mantissa = std::uniform_real_distribution<double>(-1.0, 1.0)(random);
  return std::ldexp(mantissa, std::uniform_int_distribution<int>(-30, 30)(random));
}

inline Block randomBlock(std::mt19937& random, const std::array<int, 3>& degree,
  const std::array<std::vector<double>, 3>& knots, bool manyMagnitudes = true)
{
  Block block;
  block.volume.degree = degree;
  block.volume.knots = knots;
  const Ijk n = block.counts();
  block.points.resize(static_cast<std::size_t>(3) * n[0] * n[1] * n[2]);
  for (double& x : block.points)
  {
    x = manyMagnitudes ? randomCoordinate(random) : std::uniform_real_distribution<double>(-1.0, 1.0)(random);
  }
  return block;
}

/// Several blocks and their whole-face contacts.
struct Volumes
{
  std::vector<Block> blocks;
  std::vector<Interface> interfaces;
};

/// Position of the control or sample point (s, t) of a face in a grid of `counts` points.
inline Ijk facePosition(const Ijk& counts, int face, int s, int t)
{
  Ijk i{};
  i[bsv::faceDirection(face)] = bsv::faceSide(face) ? counts[bsv::faceDirection(face)] - 1 : 0;
  i[bsv::faceAxis(face, 0)] = s;
  i[bsv::faceAxis(face, 1)] = t;
  return i;
}

/// Cuts one random lattice into tricubic blocks: cells[d] lists the cells of the blocks along direction d. A direction
/// in `periodic` closes on itself (with one block there it meets itself). Blocks are stored in random order and
/// orientation.
inline Volumes cutLattice(std::mt19937& random, const std::array<std::vector<int>, 3>& cells,
  const std::array<bool, 3>& periodic = { false, false, false }, bool manyMagnitudes = true)
{
  Ijk size{};
  std::array<std::vector<int>, 3> start;
  for (int d = 0; d < 3; ++d)
  {
    for (const int n : cells[d])
    {
      start[d].push_back(size[d]);
      size[d] += n + 2; // the last layer is the next block's first
    }
    size[d] += periodic[d] ? 0 : 1;
  }
  const auto latticeIndex = [&](const Ijk& i) {
    return i[0] % size[0] + size[0] * (i[1] % size[1] + Index(size[1]) * (i[2] % size[2]));
  };
  std::vector<double> lattice(static_cast<std::size_t>(3) * size[0] * size[1] * size[2]);
  for (double& x : lattice)
  {
    x = manyMagnitudes ? randomCoordinate(random) : std::uniform_real_distribution<double>(-1.0, 1.0)(random);
  }

  struct Piece
  {
    Ijk start, counts;
    Orientation orientation;
    Block block;
  };
  std::vector<Piece> pieces;
  const std::vector<Orientation> orientations = allOrientations();
  forEach({ int(cells[0].size()), int(cells[1].size()), int(cells[2].size()) }, [&](const Ijk& at) {
    Piece piece;
    Block plain;
    for (int d = 0; d < 3; ++d)
    {
      piece.start[d] = start[d][at[d]];
      plain.volume.knots[d] = bsv::clampedIntegerKnots(cells[d][at[d]]);
    }
    piece.counts = plain.counts();
    forEach(piece.counts, [&](const Ijk& i) {
      const Index l = latticeIndex({ i[0] + piece.start[0], i[1] + piece.start[1], i[2] + piece.start[2] });
      plain.points.insert(plain.points.end(), lattice.data() + 3 * l, lattice.data() + 3 * l + 3);
    });
    piece.orientation = orientations[std::uniform_int_distribution<std::size_t>(0, 47)(random)];
    piece.block = reoriented(plain, piece.orientation);
    pieces.push_back(piece);
  });
  std::shuffle(pieces.begin(), pieces.end(), random);

  Volumes result;
  const auto key = [&](const Piece& piece, int face, int s, int t) {
    const Ijk i = piece.orientation.old(facePosition(piece.block.counts(), face, s, t), piece.counts);
    return latticeIndex({ i[0] + piece.start[0], i[1] + piece.start[1], i[2] + piece.start[2] });
  };
  for (std::size_t a = 0; a < 6 * pieces.size(); ++a)
  {
    for (std::size_t b = a + 1; b < 6 * pieces.size(); ++b)
    {
      const Piece& pa = pieces[a / 6];
      const Piece& pb = pieces[b / 6];
      const int fa = static_cast<int>(a % 6);
      const int fb = static_cast<int>(b % 6);
      const int ns = pa.block.counts()[bsv::faceAxis(fa, 0)] - 1;
      const int nt = pa.block.counts()[bsv::faceAxis(fa, 1)] - 1;
      for (int o = 0; o < 8; ++o)
      {
        bool equal = pb.block.counts()[bsv::faceAxis(fb, bsv::swapsAxes(o) ? 1 : 0)] - 1 == ns &&
          pb.block.counts()[bsv::faceAxis(fb, bsv::swapsAxes(o) ? 0 : 1)] - 1 == nt;
        for (int s = 0; equal && s <= ns; ++s)
        {
          for (int t = 0; equal && t <= nt; ++t)
          {
            const auto m = bsv::mapFacePoint(o, s, t, ns, nt);
            equal = key(pa, fa, s, t) == key(pb, fb, m[0], m[1]);
          }
        }
        if (equal)
        {
          result.interfaces.push_back({ int(a / 6), fa, int(b / 6), fb, o, { { 0, 0 }, { ns, nt } }, { 0, 0 } });
        }
      }
    }
  }
  for (Piece& piece : pieces)
  {
    result.blocks.push_back(std::move(piece.block));
  }
  return result;
}

/// What `rank` has of volumes whose block b is on rank owners[b].
inline std::vector<BSplineVolume> partOf(std::vector<BSplineVolume> volumes, const std::vector<int>& owners, int rank)
{
  for (std::size_t b = 0; b < volumes.size(); ++b)
  {
    volumes[b].rank = owners[b];
    if (owners[b] != rank)
    {
      volumes[b].points = nullptr;
      volumes[b].weights = nullptr;
    }
  }
  return volumes;
}

/// Ways to share blocks out over ranks: at random, all on the last one, and in turn.
inline std::vector<std::vector<int>> distributions(std::mt19937& random, std::size_t blocks, int ranks)
{
  std::vector<std::vector<int>> result(3);
  for (std::size_t b = 0; b < blocks; ++b)
  {
    result[0].push_back(std::uniform_int_distribution<int>(0, ranks - 1)(random));
    result[1].push_back(ranks - 1);
    result[2].push_back(static_cast<int>(b % ranks));
  }
  return result;
}

/// Runs ranges of `grain` in two threads, last range first.
inline bsv::Execution scrambledExecution(Index grain = 1)
{
  bsv::Execution run;
  run.parallelFor = [grain](Index count, Index, const bsv::Execution::Body& body) {
    const auto work = [&](Index parity) {
      for (Index i = (count - 1) / grain; i >= 0; --i)
      {
        if (i % 2 == parity)
        {
          body(i * grain, std::min(count, (i + 1) * grain));
        }
      }
    };
    std::thread other(work, 1);
    work(0);
    other.join();
  };
  return run;
}

} // namespace bsvtest

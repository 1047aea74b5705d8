// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/PointFrame.h"

#include "Base/SortedSum.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <set>

namespace bsv
{

namespace
{

/// The sum of v v^T.
Eigen::Matrix3d sumOfSquares(const std::vector<Vec3>& vectors)
{
  std::vector<Vec3> diagonal, mixed;
  for (const Vec3& v : vectors)
  {
    diagonal.push_back(v.cwiseProduct(v));
    mixed.emplace_back(v[1] * v[2], v[2] * v[0], v[0] * v[1]);
  }
  const Vec3 d = sortedSum(diagonal), m = sortedSum(mixed);
  Eigen::Matrix3d result;
  result << d[0], m[2], m[1], m[2], d[1], m[0], m[1], m[0], d[2];
  return result;
}

} // namespace

Freedom freedomOf(const ConversionContext& context, const MeshPointKey& key)
{
  bool boundary = false;
  std::set<std::pair<int, int>> features;
  for (const MeshPointCopy& copy : copiesOf(context.complex, key))
  {
    const ComplexBlock& block = context.complex.blocks[copy.block];
    std::array<bool, 3> atEnd;
    std::array<int, 3> side;
    for (int d = 0; d < 3; ++d)
    {
      side[d] = copy.ijk[d] == 0 ? 0 : 1;
      atEnd[d] = copy.ijk[d] == 0 || copy.ijk[d] == block.cells(d);
      if (!atEnd[d])
      {
        continue;
      }
      const int face = block.faces[2 * d + side[d]];
      const FaceRule& rule = context.rules.faces[face];
      if (rule.connection || context.isWall(face))
      {
        return Freedom::Fixed;
      }
      boundary = boundary || context.complex.faces[face].boundary();
    }
    for (int along = 0; along < 3; ++along)
    {
      const int a = faceAxis(2 * along, 0), b = faceAxis(2 * along, 1);
      if (atEnd[a] && atEnd[b])
      {
        const int blockEdge = edgeIndex(along, side[a], side[b]);
        const int edge = block.edges[blockEdge];
        if (context.rules.edges[edge].feature)
        {
          const bool second = atEnd[along] && (side[along] == 1) != block.edgeReversed[blockEdge];
          features.insert({ edge, atEnd[along] ? (second ? 1 : 0) : 0 });
        }
      }
    }
  }
  if (!boundary)
  {
    return Freedom::Inner;
  }
  if (features.empty())
  {
    return Freedom::Surface;
  }
  return key[0] == 1 || features.size() == 2 ? Freedom::Curve : Freedom::Fixed;
}

PointFrame pointFrame(const ConversionContext& context, const MeshPointKey& key)
{
  const Freedom freedom = freedomOf(context, key);
  std::vector<Vec3> edges, normals, along;
  double cells = 0.0;
  for (const MeshPointCopy& copy : copiesOf(context.complex, key))
  {
    const ComplexBlock& block = context.complex.blocks[copy.block];
    const Vec3 x = block.points(copy.ijk);
    const auto edge = [&](int d, int way) {
      Ijk other = copy.ijk;
      other[d] += way;
      return Vec3(block.points(other) - x);
    };
    const auto inside = [&](int d, int way) { return copy.ijk[d] + way >= 0 && copy.ijk[d] + way <= block.cells(d); };
    for (int corner = 0; corner < 8; ++corner)
    {
      const std::array<int, 3> way{ corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1 };
      if (!inside(0, way[0]) || !inside(1, way[1]) || !inside(2, way[2]))
      {
        continue;
      }
      cells += 1.0;
      for (int d = 0; d < 3; ++d)
      {
        edges.push_back(edge(d, way[d]));
        // A cell's face on a plane of the outer surface.
        const bool atEnd = copy.ijk[d] == (way[d] > 0 ? 0 : block.cells(d));
        const int face = block.faces[2 * d + (way[d] > 0 ? 0 : 1)];
        const FaceRule& rule = context.rules.faces[face];
        if (atEnd && context.complex.faces[face].boundary() && (rule.planar() || rule.role == BoundaryRole::Symmetry))
        {
          const int a = faceAxis(2 * d, 0), b = faceAxis(2 * d, 1);
          normals.push_back(edge(a, way[a]).cross(edge(b, way[b])).normalized());
        }
      }
    }
    for (int d = 0; d < 3 && freedom == Freedom::Curve; ++d)
    {
      // Edges of the block with a feature through the point.
      const int a = faceAxis(2 * d, 0), b = faceAxis(2 * d, 1);
      const auto isEnd = [&](int axis) { return copy.ijk[axis] == 0 || copy.ijk[axis] == block.cells(axis); };
      if (isEnd(a) && isEnd(b) &&
        context.rules.edges[block.edges[edgeIndex(d, copy.ijk[a] == 0 ? 0 : 1, copy.ijk[b] == 0 ? 0 : 1)]].feature)
      {
        for (const int way : { -1, 1 })
        {
          if (inside(d, way))
          {
            along.push_back(edge(d, way).normalized());
          }
        }
      }
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sumOfSquares(edges) / cells);
  Eigen::Matrix3d matrix = solver.operatorSqrt();
  const Eigen::Matrix3d inverse = solver.operatorInverseSqrt();
  if (freedom == Freedom::Curve)
  {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> lines(sumOfSquares(along));
    const Vec3 tangent = lines.eigenvectors().col(2);
    matrix = (tangent * (tangent.transpose() * matrix)).eval();
  }
  else if (!normals.empty())
  {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> planes(sumOfSquares(normals));
    Eigen::Matrix3d projection = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 3; ++i)
    {
      if (planes.eigenvalues()[i] < 0.01 * planes.eigenvalues()[2])
      {
        projection += planes.eigenvectors().col(i) * planes.eigenvectors().col(i).transpose();
      }
    }
    matrix = (projection * matrix).eval();
  }
  PointFrame frame;
  Eigen::Map<Eigen::Matrix3d>(frame.step.data()) = matrix;
  Eigen::Map<Eigen::Matrix3d>(frame.cells.data()) = inverse;
  return frame;
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/SingularNode.h"

#include "Base/CanonicalOrder.h"
#include "Base/OrderFreeSum.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace bsv
{
namespace
{

/// Ranks of the points in lexicographic order.
template <typename Entity>
std::vector<int> canonicalOrder(const std::vector<Entity>& entities)
{
  std::vector<int> order(entities.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(
    order.begin(), order.end(), [&](int a, int b) { return comesBefore(entities[a].point, entities[b].point); });
  std::vector<int> rank(entities.size());
  for (std::size_t i = 0; i < order.size(); ++i)
  {
    rank[order[i]] = static_cast<int>(i);
  }
  return rank;
}

/// Of a matrix with eigenvalue 1 once, columns that span the invariant subspace of the next three; none if these are
/// not apart from the others.
std::optional<Eigen::MatrixXd> nextSubspace(const Eigen::MatrixXd& matrix)
{
  // The fifth eigenvalue is at most 0.78 of the fourth in all common types of nodes.
  constexpr double Apart = 0.9;
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(matrix);
  std::vector<int> order(matrix.rows());
  std::iota(order.begin(), order.end(), 0);
  const auto size = [&](int i) { return std::abs(solver.eigenvalues()[i]); };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return size(a) > size(b); });
  if (solver.info() != Eigen::Success || matrix.rows() < 5 || size(order[4]) > Apart * size(order[3]) ||
    size(order[1]) > Apart)
  {
    return std::nullopt;
  }
  Eigen::MatrixXd result(matrix.rows(), 3);
  for (int d = 0; d < 3; ++d)
  {
    const Eigen::VectorXcd vector = solver.eigenvectors().col(order[d + 1]);
    if (solver.eigenvalues()[order[d + 1]].imag() != 0.0)
    {
      return std::nullopt;
    }
    result.col(d) = vector.real();
  }
  return result;
}

/// The least over a star's blocks of det(e_i, e_j, e_k) / |e_i| |e_j| |e_k|, with the sign of the block's corner.
double leastShape(const VertexStar& star, const std::vector<Vec3>& edges, const std::vector<Vec3>& given)
{
  double least = 1.0;
  for (const VertexStar::Block& block : star.blocks)
  {
    const auto volume = [&block](const std::vector<Vec3>& e) {
      const Vec3 &a = e[block.edges[0]], &b = e[block.edges[1]], &c = e[block.edges[2]];
      return a.cross(b).dot(c) / (a.norm() * b.norm() * c.norm());
    };
    const double shape = volume(given) < 0.0 ? -volume(edges) : volume(edges);
    least = shape > least ? least : shape; // of NaN, too
  }
  return least;
}

} // namespace

SolidLimit solidLimit(const VertexStar& star)
{
  // Numbering: the vertex, then edges, faces and blocks by rank.
  const int edges = static_cast<int>(star.edges.size());
  const int faces = static_cast<int>(star.faces.size());
  const int blocks = static_cast<int>(star.blocks.size());
  const int count = 1 + edges + faces + blocks;
  const std::vector<int> edgeRank = canonicalOrder(star.edges);
  const std::vector<int> faceRank = canonicalOrder(star.faces);
  const std::vector<int> blockRank = canonicalOrder(star.blocks);
  const auto edgeAt = [&](int i) { return 1 + edgeRank[i]; };
  const auto faceAt = [&](int i) { return 1 + edges + faceRank[i]; };
  const auto blockAt = [&](int i) { return 1 + edges + faces + blockRank[i]; };

  // Centroids as rows over the star's points; every row sum of few equal terms is exact in any order.
  Eigen::MatrixXd cell = Eigen::MatrixXd::Zero(blocks, count);
  for (int i = 0; i < blocks; ++i)
  {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(count);
    row[0] = row[blockAt(i)] = 0.125;
    for (int d = 0; d < 3; ++d)
    {
      row[edgeAt(star.blocks[i].edges[d])] += 0.125;
      row[faceAt(star.blocks[i].faces[d])] += 0.125;
    }
    cell.row(blockRank[i]) = row;
  }
  Eigen::MatrixXd quad = Eigen::MatrixXd::Zero(faces, count);
  for (int i = 0; i < faces; ++i)
  {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(count);
    row[0] = row[faceAt(i)] = 0.25;
    row[edgeAt(star.faces[i].edges[0])] += 0.25;
    row[edgeAt(star.faces[i].edges[1])] += 0.25;
    quad.row(faceRank[i]) = row;
  }

  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count);
  Eigen::MatrixXd facesAtEdge = Eigen::MatrixXd::Zero(edges, faces);
  Eigen::MatrixXd blocksAtEdge = Eigen::MatrixXd::Zero(edges, blocks);
  for (int i = 0; i < faces; ++i)
  {
    for (const int edge : star.faces[i].edges)
    {
      facesAtEdge(edgeRank[edge], faceRank[i]) += 1.0;
    }
    // F = (C0 + 2 A + C1) / 4
    matrix.row(faceAt(i)) = 0.5 * quad.row(faceRank[i]) +
      0.25 * (cell.row(blockRank[star.faces[i].blocks[0]]) + cell.row(blockRank[star.faces[i].blocks[1]]));
  }
  for (int i = 0; i < blocks; ++i)
  {
    for (const int edge : star.blocks[i].edges)
    {
      blocksAtEdge(edgeRank[edge], blockRank[i]) += 1.0;
    }
    matrix.row(blockAt(i)) = cell.row(blockRank[i]);
  }
  for (int i = 0; i < edges; ++i)
  {
    // E = (C + 2 A + (n - 3) M) / n with the averages C, A over the n cells and faces at the edge
    const int rank = edgeRank[i];
    const double n = blocksAtEdge.row(rank).sum();
    Eigen::RowVectorXd middle = Eigen::RowVectorXd::Zero(count);
    middle[0] = middle[edgeAt(i)] = 0.5;
    matrix.row(edgeAt(i)) = (blocksAtEdge.row(rank) * cell / n +
                              2.0 * (facesAtEdge.row(rank) * quad) / facesAtEdge.row(rank).sum() + (n - 3.0) * middle) /
      n;
  }
  // V = (C + 3 A + 3 M + P) / 8
  Eigen::RowVectorXd middles = Eigen::RowVectorXd::Zero(count);
  middles[0] = 0.5;
  for (int i = 0; i < edges; ++i)
  {
    middles[1 + i] = 0.5 / edges;
  }
  matrix.row(0) = (cell.colwise().mean() + 3.0 * quad.colwise().mean() + 3.0 * middles) / 8.0;
  matrix(0, 0) += 0.125;

  const std::optional<Eigen::MatrixXd> right = nextSubspace(matrix), left = nextSubspace(matrix.transpose());

  // Rows of the matrix's powers converge to the left eigenvector of eigenvalue 1; squaring doubles the power each time,
  // and nothing is left of the next eigenvalue (1/2 in a regular star) after 2^10 steps.
  for (int i = 0; i < 10; ++i)
  {
    matrix = (matrix * matrix).eval();
  }
  const Eigen::RowVectorXd weights = matrix.row(0) / matrix.row(0).sum();

  OrderFreeSum sum;
  sum.add(weights[0], star.point);
  for (int i = 0; i < edges; ++i)
  {
    sum.add(weights[edgeAt(i)], star.edges[i].point);
  }
  for (int i = 0; i < faces; ++i)
  {
    sum.add(weights[faceAt(i)], star.faces[i].point);
  }
  for (int i = 0; i < blocks; ++i)
  {
    sum.add(weights[blockAt(i)], star.blocks[i].point);
  }
  SolidLimit limit{ sum.result(1.0), {} };
  if (!right || !left)
  {
    return limit;
  }
  Eigen::MatrixX3d points(count, 3);
  points.row(0) = star.point;
  std::vector<Vec3> given(edges);
  for (int i = 0; i < edges; ++i)
  {
    points.row(edgeAt(i)) = star.edges[i].point;
    given[i] = star.edges[i].point - star.point;
  }
  for (int i = 0; i < faces; ++i)
  {
    points.row(faceAt(i)) = star.faces[i].point;
  }
  for (int i = 0; i < blocks; ++i)
  {
    points.row(blockAt(i)) = star.blocks[i].point;
  }
  const Eigen::Matrix3d map =
    Eigen::Matrix3d(left->transpose() * *right).fullPivLu().solve(Eigen::Matrix3d(left->transpose() * points));
  limit.slopes.resize(edges);
  for (int i = 0; i < edges; ++i)
  {
    limit.slopes[i] = Vec3((right->row(edgeAt(i)) - right->row(0)) * map);
  }
  // Where cells are distorted the best linear map of all may be a bad one for some.
  constexpr double Shape = 0.2;
  if (!(leastShape(star, limit.slopes, given) > std::min(Shape, leastShape(star, given, given))))
  {
    limit.slopes.clear();
  }
  return limit;
}

} // namespace bsv

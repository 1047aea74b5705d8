// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/LimitMasks.h"

#include "Base/Numbers.h"

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>

#include <opensubdiv/sdc/catmarkScheme.h>

#include <cmath>
#include <complex>

namespace bsv
{
namespace
{

namespace Sdc = OpenSubdiv::Sdc;

/// What Sdc::Scheme asks of the neighbourhood of a vertex.
class Neighbourhood
{
public:
  Neighbourhood(int edges, int faces)
    : Edges(edges)
    , Faces(faces)
  {
  }
  int GetNumEdges() const { return this->Edges; }
  int GetNumFaces() const { return this->Faces; }
  float GetSharpness() const { return 0.0f; }
  float* GetSharpnessPerEdge(float sharpness[]) const
  {
    for (int i = 0; i < this->Edges; ++i)
    {
      sharpness[i] = 0.0f;
    }
    if (this->Edges > this->Faces) // open: the first and last edge are the border
    {
      sharpness[0] = sharpness[this->Edges - 1] = Sdc::Crease::SHARPNESS_INFINITE;
    }
    return sharpness;
  }

private:
  int Edges;
  int Faces;
};

/// What Sdc::Scheme asks of a mask.
class MaskAdapter
{
public:
  using Weight = double;

  explicit MaskAdapter(FanMask& mask)
    : Mask(mask)
  {
  }
  int GetNumVertexWeights() const { return 1; }
  int GetNumEdgeWeights() const { return static_cast<int>(this->Mask.spokes.size()); }
  int GetNumFaceWeights() const { return static_cast<int>(this->Mask.sectors.size()); }
  void SetNumVertexWeights(int) {}
  // Masks without face weights must still have room for the sectors: they are zero.
  void SetNumEdgeWeights(int) {}
  void SetNumFaceWeights(int) {}
  bool AreFaceWeightsForFaceCenters() const { return false; }
  void SetFaceWeightsForFaceCenters(bool) {}
  double& VertexWeight(int) { return this->Mask.center; }
  double& EdgeWeight(int i) { return this->Mask.spokes[i]; }
  double& FaceWeight(int i) { return this->Mask.sectors[i]; }

private:
  FanMask& Mask;
};

LimitMasks compute(int edges, int faces, Sdc::Crease::Rule rule)
{
  LimitMasks masks;
  for (FanMask* mask : { &masks.position, &masks.tangent1, &masks.tangent2 })
  {
    mask->spokes.assign(edges, 0.0);
    mask->sectors.assign(faces, 0.0);
  }
  MaskAdapter position(masks.position), tangent1(masks.tangent1), tangent2(masks.tangent2);
  const Sdc::Scheme<Sdc::SCHEME_CATMARK> scheme;
  scheme.ComputeVertexLimitMask(Neighbourhood(edges, faces), position, tangent1, tangent2, rule);
  return masks;
}

/// Tangent across a crease with three sectors or more: the left eigenvector of the fan's subdivision matrix that
/// belongs to the mode sin(i pi / n), eigenvalue (5 + c + sqrt((1 + c) (9 + c))) / 16 with c = cos(pi / n).
/// OpenSubdiv's own mask is that of Biermann, Levin and Zorin, whose subdivision rules near creases it does not use:
/// the normals of the two differ by several degrees.
FanMask tangentAcrossCrease(int sectors)
{
  const int spokes = sectors + 1;
  const int count = 1 + spokes + sectors;
  const auto spoke = [](int i) { return 1 + i; };
  const auto sector = [&](int i) { return 1 + spokes + i; };
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count);
  for (int i = 0; i < sectors; ++i)
  {
    for (const int corner : { 0, spoke(i), spoke(i + 1), sector(i) })
    {
      matrix(sector(i), corner) = 0.25;
    }
  }
  for (int i = 1; i < sectors; ++i)
  {
    matrix.row(spoke(i)) = 0.25 * (matrix.row(sector(i - 1)) + matrix.row(sector(i)));
    matrix(spoke(i), 0) += 0.25;
    matrix(spoke(i), spoke(i)) += 0.25;
  }
  for (const int border : { spoke(0), spoke(sectors) })
  {
    matrix(border, 0) = matrix(border, border) = 0.5;
    matrix(0, border) = 0.125;
  }
  matrix(0, 0) = 0.75;

  const double c = std::cos(Pi / sectors);
  const double eigenvalue = (5.0 + c + std::sqrt((1.0 + c) * (9.0 + c))) / 16.0;
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(matrix.transpose());
  int best = 0;
  for (int i = 1; i < count; ++i)
  {
    if (std::abs(solver.eigenvalues()[i] - eigenvalue) < std::abs(solver.eigenvalues()[best] - eigenvalue))
    {
      best = i;
    }
  }
  Eigen::VectorXd weights = solver.eigenvectors().col(best).real();
  weights /= weights.segment(spoke(1), sectors - 1).sum(); // points into the fan
  FanMask mask;
  mask.center = weights[0];
  for (int i = 0; i < spokes; ++i)
  {
    mask.spokes.push_back(weights[spoke(i)]);
  }
  for (int i = 0; i < sectors; ++i)
  {
    mask.sectors.push_back(weights[sector(i)]);
  }
  return mask;
}

} // namespace

LimitMasks closedFanLimitMasks(int valence)
{
  return compute(valence, valence, Sdc::Crease::RULE_SMOOTH);
}

LimitMasks openFanLimitMasks(int sectors)
{
  LimitMasks masks = compute(sectors + 1, sectors, Sdc::Crease::RULE_CREASE);
  if (sectors > 2)
  {
    masks.tangent2 = tangentAcrossCrease(sectors);
  }
  return masks;
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMirrorHexBlocks.h"

#include "Base/MemoryCheck.h"
#include "Data/BlockTags.h"
#include "Data/BoundarySelection.h"
#include "Data/HexBlockData.h"
#include "Data/MeshInput.h"
#include "Execution/FilterExecution.h"
#include "Mesh/BlockSurface.h"
#include "Mesh/MeshCheck.h"
#include "Ranks/Ranks.h"

#include "vtkDataObject.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkStructuredGrid.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

vtkStandardNewMacro(vtkMirrorHexBlocks);

namespace
{

/// A plane: points x with normal . x = offset.
struct Plane
{
  bsv::Vec3 normal = bsv::Vec3::Zero();
  double offset = 0.0;
  /// x, y or z if the normal is that axis, else -1.
  int axis = -1;

  double distance(const bsv::Vec3& x) const
  {
    return this->axis >= 0 ? x[this->axis] - this->offset : this->normal.dot(x) - this->offset;
  }
  bsv::Vec3 image(const bsv::Vec3& x) const
  {
    if (this->axis < 0)
    {
      return x - 2.0 * this->distance(x) * this->normal;
    }
    bsv::Vec3 result = x;
    result[this->axis] = 2.0 * this->offset - x[this->axis];
    return result;
  }
  bsv::Vec3 onto(const bsv::Vec3& x) const
  {
    if (this->axis < 0)
    {
      return x - this->distance(x) * this->normal;
    }
    bsv::Vec3 result = x;
    result[this->axis] = this->offset;
    return result;
  }
  bsv::Vec3 direction(const bsv::Vec3& v) const { return v - 2.0 * this->normal.dot(v) * this->normal; }
};

bsv::Ijk facePoint(const bsv::Ijk& counts, int face, int s, int t)
{
  bsv::Ijk p{};
  p[bsv::faceDirection(face)] = bsv::faceSide(face) ? counts[bsv::faceDirection(face)] - 1 : 0;
  p[bsv::faceAxis(face, 0)] = s;
  p[bsv::faceAxis(face, 1)] = t;
  return p;
}

/// Calls visit(point) for the mesh points of a patch.
template <typename Visit>
void forEachPoint(const bsv::BoundaryPatch& patch, const bsv::Ijk& counts, const Visit& visit)
{
  for (int t = patch.range.lo[1]; t <= patch.range.hi[1]; ++t)
  {
    for (int s = patch.range.lo[0]; s <= patch.range.hi[0]; ++s)
    {
      visit(facePoint(counts, patch.face, s, t));
    }
  }
}

/// The plane of patches. Sums are made of sorted places, so that the order of the blocks makes no difference.
/// @param[out] farthest distance of a point from it. @param[out] size of all patches
Plane planeOf(const bsv::BlockMesh& mesh, const std::vector<bsv::BoundaryPatch>& patches, const bsv::Ranks& ranks,
  double& farthest, double& size)
{
  std::vector<std::array<double, 3>> mine;
  for (const bsv::BoundaryPatch& patch : patches)
  {
    const bsv::GridView& points = mesh.blocks[patch.block].points;
    if (points.isHere())
    {
      forEachPoint(patch, points.counts(), [&](const bsv::Ijk& p) {
        const bsv::Vec3 x = points(p);
        mine.push_back({ x[0], x[1], x[2] });
      });
    }
  }
  std::vector<std::array<double, 3>> all = ranks.gatherAll(mine);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  bsv::Vec3 lo = bsv::Vec3(all.front().data());
  bsv::Vec3 hi = lo;
  bsv::Vec3 mean = bsv::Vec3::Zero();
  for (const std::array<double, 3>& x : all)
  {
    lo = lo.cwiseMin(bsv::Vec3(x.data()));
    hi = hi.cwiseMax(bsv::Vec3(x.data()));
    mean += bsv::Vec3(x.data());
  }
  mean /= static_cast<double>(all.size());
  size = (hi - lo).norm();

  // A coordinate plane if it is one as exactly as any other: its points then mirror without rounding.
  Plane plane;
  int thin = 0;
  (hi - lo).minCoeff(&thin);
  constexpr double AsGoodAsAny = 1e-3;
  if ((hi - lo)[thin] <= AsGoodAsAny * size)
  {
    plane.axis = thin;
    plane.normal[thin] = 1.0;
    // The place that most points have, which rounding has not touched: the middle one.
    std::vector<double> places;
    for (const std::array<double, 3>& x : all)
    {
      places.push_back(x[thin]);
    }
    std::nth_element(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(places.size() / 2), places.end());
    plane.offset = places[places.size() / 2];
    // A plane through the origin up to rounding goes through it.
    if (std::abs(plane.offset) <= 1e-9 * size)
    {
      plane.offset = 0.0;
    }
  }
  else
  {
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    for (const std::array<double, 3>& x : all)
    {
      const bsv::Vec3 d = bsv::Vec3(x.data()) - mean;
      moments += d * d.transpose();
    }
    plane.normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments).eigenvectors().col(0);
    plane.offset = plane.normal.dot(mean);
  }
  farthest = 0.0;
  for (const std::array<double, 3>& x : all)
  {
    farthest = std::max(farthest, std::abs(plane.distance(bsv::Vec3(x.data()))));
  }
  return plane;
}

/// Face of the mirrored block, which runs backwards in i.
int mirroredFace(int face)
{
  return bsv::faceDirection(face) == 0 ? 1 - face : face;
}

bsv::FaceRange mirroredRange(const bsv::FaceRange& range, int face, const bsv::Ijk& counts)
{
  bsv::FaceRange result = range;
  // i is the first axis of the faces that have it.
  if (bsv::faceDirection(face) != 0)
  {
    result.lo[0] = counts[0] - 1 - range.hi[0];
    result.hi[0] = counts[0] - 1 - range.lo[0];
  }
  return result;
}

/// Orientation code where the first axis of A, of B, or of both runs backwards now.
int mirroredOrientation(int code, int faceA, int faceB)
{
  const bool flipA = bsv::faceDirection(faceA) != 0;
  const bool flipB = bsv::faceDirection(faceB) != 0;
  // The first axis of A is B's second one if they are exchanged.
  code ^= flipA ? (bsv::swapsAxes(code) ? 4 : 2) : 0;
  code ^= flipB ? 2 : 0;
  return code;
}

/// The image of a block, backwards in i.
vtkSmartPointer<vtkStructuredGrid> imageOf(vtkStructuredGrid* grid, const bsv::Ijk& counts, const Plane& plane)
{
  double* x = nullptr;
  vtkSmartPointer<vtkStructuredGrid> image = bsv::blockGrid(counts, x);
  std::vector<vtkIdType> from;
  for (int k = 0; k < counts[2]; ++k)
  {
    for (int j = 0; j < counts[1]; ++j)
    {
      for (int i = counts[0] - 1; i >= 0; --i)
      {
        from.push_back(i + counts[0] * (j + vtkIdType(counts[1]) * k));
      }
    }
  }
  for (std::size_t n = 0; n < from.size(); ++n)
  {
    bsv::Vec3 p;
    grid->GetPoint(from[n], p.data());
    p = plane.image(p);
    std::copy(p.data(), p.data() + 3, x + 3 * n);
  }
  for (int a = 0; a < grid->GetPointData()->GetNumberOfArrays(); ++a)
  {
    vtkAbstractArray* array = grid->GetPointData()->GetAbstractArray(a);
    const auto copy = vtkSmartPointer<vtkAbstractArray>::Take(array->NewInstance());
    copy->SetName(array->GetName());
    copy->SetNumberOfComponents(array->GetNumberOfComponents());
    copy->SetNumberOfTuples(array->GetNumberOfTuples());
    const std::string name = array->GetName() ? array->GetName() : "";
    auto* numbers = vtkDataArray::SafeDownCast(array);
    const bool place = numbers && name == "ProjectedPoint" && numbers->GetNumberOfComponents() == 3;
    const bool direction = numbers && name == "SurfaceNormal" && numbers->GetNumberOfComponents() == 3;
    for (std::size_t n = 0; n < from.size(); ++n)
    {
      if (place || direction)
      {
        bsv::Vec3 v;
        numbers->GetTuple(from[n], v.data());
        v = place ? plane.image(v) : plane.direction(v);
        vtkDataArray::SafeDownCast(copy)->SetTuple(static_cast<vtkIdType>(n), v.data());
      }
      else
      {
        copy->SetTuple(static_cast<vtkIdType>(n), from[n], array);
      }
    }
    image->GetPointData()->AddArray(copy);
  }
  return image;
}

} // namespace

//------------------------------------------------------------------------------
void vtkMirrorHexBlocks::AddSymmetryBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->SymmetryBoundaries.emplace_back(pattern);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkMirrorHexBlocks::ClearSymmetryBoundaries()
{
  this->SymmetryBoundaries.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
const char* vtkMirrorHexBlocks::GetSymmetryBoundary(int index) const
{
  return index >= 0 && index < this->GetNumberOfSymmetryBoundaries() ? this->SymmetryBoundaries[index].c_str()
                                                                     : nullptr;
}

//------------------------------------------------------------------------------
int vtkMirrorHexBlocks::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMissing(info);
  bsv::acceptMeshes(info);
  return 1;
}

//------------------------------------------------------------------------------
int vtkMirrorHexBlocks::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataObject* input = vtkDataObject::GetData(inputVector[0], 0);
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector, 0);
  if (!output)
  {
    vtkErrorMacro("The output is missing.");
    return 0;
  }
  this->Report.clear();

  return bsv::execute(this, [&] {
    bsv::requiredInput(inputVector, 0);
    const bsv::Execution run = bsv::filterExecution(this);
    const bsv::Ranks& ranks = *run.ranks;
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
    bsv::BlockMesh mesh = bsv::blockMesh(input, grids, bsv::filterExecution(this, 0.0, 0.3));
    bsv::requireBlocks(mesh);
    bsv::requireMesh(grids, ranks, "mirror the mesh and convert the whole");
    bsv::checkFinitePoints(mesh, run);
    double points = 0.0;
    for (const bsv::MeshBlock& block : mesh.blocks)
    {
      points += block.points.isHere() ? static_cast<double>(block.points.size()) : 0.0;
    }
    bsv::requireMemory(2.0 * points * 3.0 * sizeof(double), "the mesh", "it and its image");
    std::vector<bsv::BoundaryPatch> onPlane;
    std::vector<bsv::BoundaryPatch> others;
    for (const bsv::BoundaryPatch& patch : mesh.boundaries)
    {
      const bool symmetry = bsv::selectsBoundary(
        this->SymmetryBoundaries, bsv::defaultSymmetryBoundaries(), mesh.boundaryNames, mesh.boundaryTypes, patch.tag);
      (symmetry ? onPlane : others).push_back(patch);
    }
    if (onPlane.empty())
    {
      throw bsv::Error("there is no symmetry boundary to mirror at: Symmetry Boundaries are " +
        bsv::quotedList(this->SymmetryBoundaries) + ", the mesh has the boundaries " +
        bsv::quotedList(mesh.boundaryNames));
    }
    double farthest = 0.0;
    double size = 0.0;
    const Plane plane = planeOf(mesh, onPlane, ranks, farthest, size);
    if (farthest > this->PlaneTolerance * size)
    {
      std::ostringstream text;
      text << "the symmetry boundaries are not in one plane: a point is " << farthest << " away from it, allowed is "
           << this->PlaneTolerance * size << " (Plane Tolerance times their size); choose those of one plane";
      throw bsv::Error(text.str());
    }
    run.report(0.2);

    // The blocks with their points of the plane on it, then their images.
    const int count = static_cast<int>(mesh.blocks.size());
    std::vector<vtkSmartPointer<vtkStructuredGrid>> all(2 * grids.size());
    for (int b = 0; b < count; ++b)
    {
      if (!grids[b])
      {
        continue;
      }
      const bsv::GridView& points = mesh.blocks[b].points;
      const bsv::Ijk& counts = points.counts();
      vtkNew<vtkPoints> moved;
      moved->SetDataTypeToDouble();
      moved->DeepCopy(grids[b]->GetPoints());
      for (const bsv::BoundaryPatch& patch : onPlane)
      {
        if (patch.block == b)
        {
          forEachPoint(patch, counts, [&](const bsv::Ijk& p) {
            const bsv::Vec3 x = plane.onto(points(p));
            moved->SetPoint(p[0] + counts[0] * (p[1] + vtkIdType(counts[1]) * p[2]), x.data());
          });
        }
      }
      all[b] = vtkSmartPointer<vtkStructuredGrid>::New();
      all[b]->ShallowCopy(grids[b]);
      all[b]->SetPoints(moved);
      all[b + count] = imageOf(all[b], counts, plane);
      // The same bits, also where the plane is no coordinate plane.
      for (const bsv::BoundaryPatch& patch : onPlane)
      {
        if (patch.block == b)
        {
          forEachPoint(patch, counts, [&](const bsv::Ijk& p) {
            double x[3];
            moved->GetPoint(p[0] + counts[0] * (p[1] + vtkIdType(counts[1]) * p[2]), x);
            all[b + count]->GetPoints()->SetPoint(
              counts[0] - 1 - p[0] + counts[0] * (p[1] + vtkIdType(counts[1]) * p[2]), x);
          });
        }
      }
      run.report(0.2 + 0.7 * (b + 1) / count);
    }

    bsv::BlockMesh whole;
    std::vector<std::string> names;
    for (int half = 0; half < 2; ++half)
    {
      for (const bsv::MeshBlock& block : mesh.blocks)
      {
        bsv::MeshBlock copy = block;
        copy.points = bsv::GridView::elsewhere(block.points.counts());
        copy.name += half == 1 ? " mirrored" : "";
        names.push_back(copy.name);
        whole.blocks.push_back(copy);
      }
    }
    const auto counts = [&](int b) -> const bsv::Ijk& { return mesh.blocks[b].points.counts(); };
    whole.interfaces = mesh.interfaces;
    for (const bsv::Interface& c : mesh.interfaces)
    {
      const bsv::FaceRange rangeB = mirroredRange(c.rangeB(), c.faceB, counts(c.blockB));
      whole.interfaces.push_back({ c.blockA + count, mirroredFace(c.faceA), c.blockB + count, mirroredFace(c.faceB),
        mirroredOrientation(c.orientation, c.faceA, c.faceB), mirroredRange(c.rangeA, c.faceA, counts(c.blockA)),
        rangeB.lo });
    }
    for (const bsv::BoundaryPatch& p : onPlane)
    {
      const bsv::FaceRange image = mirroredRange(p.range, p.face, counts(p.block));
      const bool flips = bsv::faceDirection(p.face) != 0;
      whole.interfaces.push_back(
        { p.block, p.face, p.block + count, mirroredFace(p.face), flips ? 2 : 0, p.range, image.lo });
    }
    whole.boundaryNames = mesh.boundaryNames;
    whole.boundaryTypes = mesh.boundaryTypes;
    whole.boundaries = others;
    for (const bsv::BoundaryPatch& p : others)
    {
      whole.boundaries.push_back(
        { p.block + count, mirroredFace(p.face), mirroredRange(p.range, p.face, counts(p.block)), p.tag });
    }
    whole.creases = mesh.creases;
    for (bsv::CreaseLine line : mesh.creases)
    {
      const int last = counts(line.block)[0] - 1;
      line.from[0] = last - line.from[0];
      line.to[0] = last - line.to[0];
      line.block += count;
      whole.creases.push_back(line);
    }
    bsv::setBlocks(output, all, names, "HexBlockMesh");
    bsv::setConnectivity(output->GetFieldData(), whole);
    bsv::tagBlocks(output, whole, "mirrored");

    std::ostringstream text;
    text << count << " blocks and their images at the plane ";
    if (plane.axis >= 0)
    {
      text << "xyz"[plane.axis] << " = " << plane.offset;
    }
    else
    {
      text << "of the normal " << bsv::text(plane.normal) << " at the distance " << plane.offset << " from the origin";
    }
    text << "\npoints were moved onto it by up to " << farthest << '\n';
    for (const std::string& note : mesh.notes)
    {
      text << note << '\n';
    }
    this->Report = text.str();
    bsv::warn(this, mesh.warnings);
    bsv::warn(this,
      bsv::uselessPatterns("Symmetry Boundaries", this->SymmetryBoundaries, bsv::defaultSymmetryBoundaries(),
        mesh.boundaryNames, mesh.boundaryTypes));
    this->UpdateProgress(1.0);
  });
}

//------------------------------------------------------------------------------
void vtkMirrorHexBlocks::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SymmetryBoundaries: " << bsv::quotedList(this->SymmetryBoundaries) << '\n';
  os << indent << "PlaneTolerance: " << this->PlaneTolerance << '\n';
  os << indent << "Report: " << this->Report << '\n';
}

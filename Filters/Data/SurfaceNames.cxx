// SPDX-License-Identifier: BSD-3-Clause
#include "Data/SurfaceNames.h"

#include "Complex/BlockComplex.h"
#include "Ranks/Texts.h"

#include <vtkCellType.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkStructuredGrid.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <string>

namespace bsv
{

namespace
{

/// A quadrilateral by its points, in an order that does not depend on it.
struct SurfaceQuad
{
  std::array<std::array<double, 3>, 4> points;
  int tag;

  void sort()
  {
    for (auto& point : this->points)
    {
      for (double& x : point)
      {
        x += 0.0; // one zero
      }
    }
    std::sort(this->points.begin(), this->points.end());
  }
  bool operator<(const SurfaceQuad& other) const
  {
    return this->points != other.points ? this->points < other.points : this->tag < other.tag;
  }
};

/// The names of all ranks, each once.
std::vector<std::string> sharedNames(const std::vector<NamedLeaf>& surfaces, const Ranks& ranks)
{
  std::vector<std::string> mine, names;
  for (const NamedLeaf& surface : surfaces)
  {
    mine.push_back(surface.name);
  }
  for (const std::string& name : textsOf(ranks.gatherAll(lettersOf(mine))))
  {
    if (std::find(names.begin(), names.end(), name) == names.end())
    {
      names.push_back(name);
    }
  }
  return names;
}

/// Ascending; of several at one place the first.
std::vector<SurfaceQuad> sharedQuads(
  const std::vector<NamedLeaf>& surfaces, const std::vector<std::string>& names, const Ranks& ranks)
{
  std::vector<SurfaceQuad> quads;
  vtkNew<vtkIdList> points;
  for (const NamedLeaf& surface : surfaces)
  {
    auto* data = vtkDataSet::SafeDownCast(surface.data);
    const int tag = static_cast<int>(std::find(names.begin(), names.end(), surface.name) - names.begin());
    for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c)
    {
      data->GetCellPoints(c, points);
      const int type = data->GetCellType(c);
      SurfaceQuad quad{ {}, tag };
      if (points->GetNumberOfIds() != 4 || (type != VTK_QUAD && type != VTK_PIXEL && type != VTK_POLYGON))
      {
        continue;
      }
      for (int p = 0; p < 4; ++p)
      {
        data->GetPoint(points->GetId(p), quad.points[p].data());
      }
      quad.sort();
      quads.push_back(quad);
    }
  }
  quads = ranks.gatherAll(quads);
  std::sort(quads.begin(), quads.end());
  quads.erase(std::unique(quads.begin(), quads.end(),
                [](const SurfaceQuad& a, const SurfaceQuad& b) { return a.points == b.points; }),
    quads.end());
  return quads;
}

/// The quadrilaterals of a block face, [s + t * ns], as numbers of what lies there.
class FaceQuads
{
public:
  FaceQuads(const MeshBlock& block, int face)
    : Points(block.points)
    , Face(face)
    , Cells{ block.points.counts()[0] - 1, block.points.counts()[1] - 1, block.points.counts()[2] - 1 }
    , Count{ Cells[faceAxis(face, 0)], Cells[faceAxis(face, 1)] }
    , Number(static_cast<std::size_t>(Count[0]) * Count[1], -1)
  {
  }

  Index& at(int s, int t) { return this->Number[s + static_cast<std::size_t>(t) * this->Count[0]]; }
  std::vector<Index>& numbers() { return this->Number; }

  void find(const std::vector<SurfaceQuad>& quads)
  {
    for (int t = 0; t < this->Count[1]; ++t)
    {
      for (int s = 0; s < this->Count[0]; ++s)
      {
        SurfaceQuad quad{ {}, -1 };
        for (int p = 0; p < 4; ++p)
        {
          const Vec3 x = this->Points(facePoint(this->Cells, this->Face, s + p % 2, t + p / 2));
          std::copy_n(x.data(), 3, quad.points[p].data());
        }
        quad.sort();
        const auto found = std::lower_bound(quads.begin(), quads.end(), quad);
        this->at(s, t) = found != quads.end() && found->points == quad.points ? found - quads.begin() : -1;
      }
    }
  }

  void exclude(const FaceRange& range)
  {
    for (int t = range.lo[1]; t < range.hi[1]; ++t)
    {
      for (int s = range.lo[0]; s < range.hi[0]; ++s)
      {
        this->at(s, t) = -1;
      }
    }
  }

  /// Calls add(range, number) for rectangles of one number, as long and then as high as they can be.
  template <typename Add>
  void cut(const Add& add)
  {
    for (int t0 = 0; t0 < this->Count[1]; ++t0)
    {
      for (int s0 = 0; s0 < this->Count[0]; ++s0)
      {
        const Index number = this->at(s0, t0);
        if (number < 0)
        {
          continue;
        }
        int s1 = s0;
        while (s1 < this->Count[0] && this->at(s1, t0) == number)
        {
          ++s1;
        }
        const auto same = [&](int t) {
          const auto row = this->Number.begin() + s0 + static_cast<std::ptrdiff_t>(t) * this->Count[0];
          return std::all_of(row, row + (s1 - s0), [&](Index n) { return n == number; });
        };
        int t1 = t0 + 1;
        while (t1 < this->Count[1] && same(t1))
        {
          ++t1;
        }
        const FaceRange range{ { s0, t0 }, { s1, t1 } };
        this->exclude(range);
        add(range, number);
      }
    }
  }

private:
  const GridView& Points;
  int Face;
  Ijk Cells;
  std::array<int, 2> Count;
  std::vector<Index> Number;
};

} // namespace

bool isSurface(vtkDataObject* leaf)
{
  if (auto* grid = vtkStructuredGrid::SafeDownCast(leaf))
  {
    std::array<int, 3> counts{};
    grid->GetDimensions(counts.data());
    return std::count(counts.begin(), counts.end(), 1) == 1 && grid->GetNumberOfPoints() > 0;
  }
  return vtkPolyData::SafeDownCast(leaf) != nullptr;
}

void nameBySurfaces(BlockMesh& mesh, const std::vector<NamedLeaf>& surfaces, const Ranks& ranks)
{
  if (!ranks.any(!surfaces.empty()))
  {
    return;
  }
  const std::vector<std::string> names = sharedNames(surfaces, ranks);
  const std::vector<SurfaceQuad> quads = sharedQuads(surfaces, names, ranks);

  // What each of my faces is covered by, and how many faces have each quadrilateral.
  std::vector<std::array<std::unique_ptr<FaceQuads>, 6>> covers(mesh.blocks.size());
  std::vector<Index> found;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    for (int face = 0; mesh.blocks[b].points.isHere() && face < 6; ++face)
    {
      covers[b][face] = std::make_unique<FaceQuads>(mesh.blocks[b], face);
      covers[b][face]->find(quads);
      std::copy_if(covers[b][face]->numbers().begin(), covers[b][face]->numbers().end(), std::back_inserter(found),
        [](Index number) { return number >= 0; });
    }
  }
  std::vector<int> faces(quads.size(), 0);
  for (const Index number : ranks.gatherAll(found))
  {
    ++faces[number];
  }
  for (const BoundaryPatch& patch : mesh.boundaries)
  {
    if (covers[patch.block][patch.face])
    {
      covers[patch.block][patch.face]->exclude(patch.range);
    }
  }
  std::vector<BoundaryPatch> patches;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    for (int face = 0; covers[b][face] && face < 6; ++face)
    {
      for (Index& number : covers[b][face]->numbers())
      {
        number = number >= 0 && faces[number] == 1 ? quads[number].tag : -1;
      }
      covers[b][face]->cut([&](const FaceRange& range, Index tag) {
        patches.push_back({ static_cast<int>(b), face, range, static_cast<int>(tag) });
      });
    }
  }
  patches = ranks.gatherAll(patches);
  std::stable_sort(
    patches.begin(), patches.end(), [](const BoundaryPatch& a, const BoundaryPatch& b) { return a.block < b.block; });

  // Names that the mesh has already are the same boundaries.
  std::vector<int> tagOf(names.size(), -1);
  for (BoundaryPatch& patch : patches)
  {
    int& tag = tagOf[patch.tag];
    if (tag < 0)
    {
      const auto known = std::find(mesh.boundaryNames.begin(), mesh.boundaryNames.end(), names[patch.tag]);
      tag = static_cast<int>(known - mesh.boundaryNames.begin());
      if (known == mesh.boundaryNames.end())
      {
        mesh.boundaryNames.push_back(names[patch.tag]);
        if (!mesh.boundaryTypes.empty())
        {
          mesh.boundaryTypes.emplace_back("BCTypeUserDefined");
        }
      }
    }
    patch.tag = tag;
  }
  mesh.boundaries.insert(mesh.boundaries.end(), patches.begin(), patches.end());
  const Index used = static_cast<Index>(tagOf.size()) - std::count(tagOf.begin(), tagOf.end(), -1);
  mesh.notes.push_back("Surfaces beside the blocks name " + std::to_string(used) + " boundaries.");
  const Index left = std::count(faces.begin(), faces.end(), 0);
  if (left > 0)
  {
    const auto first = std::find(faces.begin(), faces.end(), 0) - faces.begin();
    mesh.warnings.push_back(std::to_string(left) + " of " + std::to_string(quads.size()) +
      " quadrilaterals of surfaces beside the blocks lie on no block face and are left out, the first of '" +
      names[quads[first].tag] + "'.");
  }
}

} // namespace bsv

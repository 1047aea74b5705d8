// SPDX-License-Identifier: BSD-3-Clause
// The named boundaries of blocks that became unstructured.
#include "Data/BlockTagArrays.h"

#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>

namespace bsv
{

FormerBoundaries::FormerBoundaries(vtkFieldData* mesh, vtkDataSet* grid)
{
  if (!grid->GetPointData()->HasArray("MeshPointIds"))
  {
    return;
  }
  const std::vector<int> dimensions = intsOf(mesh, "MeshBlockDimensions", 3);
  if (!dimensions.empty())
  {
    Index first = 0;
    for (std::size_t b = 0; 3 * b + 3 <= dimensions.size(); ++b)
    {
      this->Counts.push_back({ dimensions[3 * b], dimensions[3 * b + 1], dimensions[3 * b + 2] });
      this->First.push_back(first);
      first += sizeOf(this->Counts.back());
    }
    const std::vector<std::string> names = stringsOf(mesh, "BoundaryNames");
    const std::vector<std::string> types = stringsOf(mesh, "BoundaryTypes");
    for (int components : { 3, 7 })
    {
      const std::vector<int> values = intsOf(mesh, "Boundaries", components);
      for (std::size_t n = 0; n + components <= values.size(); n += components)
      {
        const int* v = values.data() + n;
        if (v[0] >= 0 && v[0] < static_cast<int>(this->Counts.size()) && v[1] >= 0 && v[1] < 6 && v[2] >= 0 &&
          v[2] < static_cast<int>(names.size()))
        {
          const FaceRange range =
            components == 3 ? wholeFace(this->Counts[v[0]], v[1]) : FaceRange{ { v[3], v[5] }, { v[4], v[6] } };
          this->addPatch(v[0], v[1], range, names[v[2]], types.size() == names.size() ? types[v[2]] : std::string());
        }
      }
    }
    this->addContacts(mesh);
    if (!this->Patches.empty())
    {
      this->addMergedPoints(grid);
    }
    return;
  }
  const std::vector<int> counts = intsOf(grid->GetFieldData(), "BlockDimensions", 3);
  auto* first = vtkDataArray::SafeDownCast(grid->GetFieldData()->GetAbstractArray("BlockFirstPoint"));
  if (counts.size() != 3 || !first || first->GetNumberOfTuples() != 1)
  {
    return;
  }
  this->Counts.push_back({ counts[0], counts[1], counts[2] });
  this->First.push_back(static_cast<Index>(first->GetTuple1(0)));
  const std::vector<int> values = intsOf(grid->GetFieldData(), "BlockBoundaries", 5);
  const std::vector<std::string> names = stringsOf(grid->GetFieldData(), "BlockBoundaryNames");
  const std::vector<std::string> types = stringsOf(grid->GetFieldData(), "BlockBoundaryTypes");
  for (std::size_t n = 0; 5 * n + 5 <= values.size() && n < names.size(); ++n)
  {
    const int* v = values.data() + 5 * n;
    if (v[0] >= 0 && v[0] < 6)
    {
      this->addPatch(
        0, v[0], { { v[1], v[3] }, { v[2], v[4] } }, names[n], n < types.size() ? types[n] : std::string());
    }
  }
}

void FormerBoundaries::addPatch(
  int block, int face, const FaceRange& range, const std::string& name, const std::string& type)
{
  this->OfBlock.resize(this->Counts.size());
  this->OfBlock[block].push_back({ face, range, this->Patches.size() });
  this->Patches.push_back({ name, type });
}

void FormerBoundaries::addContacts(vtkFieldData* mesh)
{
  this->Contacts.resize(this->Counts.size());
  const std::vector<int> values = intsOf(mesh, "Interfaces", 12);
  const int blocks = static_cast<int>(this->Counts.size());
  for (std::size_t n = 0; n + 12 <= values.size(); n += 12)
  {
    const int* v = values.data() + n;
    if (v[0] < 0 || v[0] >= blocks || v[1] < 0 || v[1] > 5 || v[2] < 0 || v[2] >= blocks || v[3] < 0 || v[3] > 5 ||
      v[4] < 0 || v[4] > 7)
    {
      continue;
    }
    Interface c{ v[0], v[1], v[2], v[3], v[4], wholeFace(this->Counts[v[0]], v[1]), { 0, 0 } };
    if (v[5] == 1)
    {
      c.rangeA = { { v[6], v[8] }, { v[7], v[9] } };
      c.originB = { v[10], v[11] };
    }
    this->Contacts[c.blockA].push_back(c);
    this->Contacts[c.blockB].push_back(
      { c.blockB, c.faceB, c.blockA, c.faceA, inverseOrientation(c.orientation), c.rangeB(), c.rangeA.lo });
  }
}

void FormerBoundaries::addMergedPoints(vtkDataSet* grid)
{
  vtkDataArray* numbers = grid->GetPointData()->GetArray("MeshPointIds");
  // A cell as it was: its first corner in a block.
  struct Cell
  {
    int block;
    Ijk place;
    int corners;
  };
  constexpr std::array<int, 8> BlockCorner{ 0, 1, 3, 2, 4, 5, 7, 6 };
  vtkNew<vtkIdList> list;
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c)
  {
    const int type = grid->GetCellType(c);
    if (type != VTK_HEXAHEDRON && type != VTK_VOXEL)
    {
      continue;
    }
    vtkIdType count = 0;
    const vtkIdType* points = nullptr;
    grid->GetCellPoints(c, count, points, list);
    std::array<Index, 8> ids{};
    std::vector<Cell> found;
    for (int v = 0; v < 8; ++v)
    {
      const int corner = type == VTK_VOXEL ? v : BlockCorner[v];
      ids[corner] = static_cast<Index>(numbers->GetTuple1(points[v]));
      const std::pair<int, Ijk> before = this->placeOf(ids[corner]);
      const int block = before.first;
      Ijk place = before.second;
      bool inside = block >= 0;
      for (int d = 0; d < 3 && inside; ++d)
      {
        place[d] -= cornerSide(corner, d);
        inside = place[d] >= 0 && place[d] < this->Counts[block][d] - 1;
      }
      if (!inside)
      {
        continue;
      }
      auto same = std::find_if(
        found.begin(), found.end(), [&](const Cell& cell) { return cell.block == block && cell.place == place; });
      if (same == found.end())
      {
        same = found.insert(found.end(), { block, place, 0 });
      }
      ++same->corners;
    }
    const auto [lowest, highest] = std::minmax_element(ids.begin(), ids.end());
    const int firstBlock = this->placeOf(*lowest).first;
    if (firstBlock >= 0 && firstBlock == this->placeOf(*highest).first &&
      this->idAt(firstBlock, { 1, 1, 1 }) - this->idAt(firstBlock, { 0, 0, 0 }) == *highest - *lowest)
    {
      // A whole cell of the block. In another order of corners, as Reflect makes them, the others say nothing.
      if (found.empty() || found.front().corners < 8)
      {
        this->Merged.clear();
        return;
      }
      continue;
    }
    // Most corners have their numbers in the block that the cell is of.
    const auto fewer = [](const Cell& a, const Cell& b) { return a.corners < b.corners; };
    const auto most = std::max_element(found.begin(), found.end(), fewer);
    if (most == found.end() || most->corners == 8 ||
      std::any_of(std::next(most), found.end(), [&](const Cell& cell) { return cell.corners == most->corners; }))
    {
      continue;
    }
    const Cell best = *most;
    for (int corner = 0; corner < 8; ++corner)
    {
      Ijk p = best.place;
      for (int d = 0; d < 3; ++d)
      {
        p[d] += cornerSide(corner, d);
      }
      const Index own = this->idAt(best.block, p);
      if (own != ids[corner])
      {
        this->Merged.insert(this->Merged.end(), { { own, ids[corner] }, { ids[corner], own } });
      }
    }
  }
  std::sort(this->Merged.begin(), this->Merged.end());
  this->Merged.erase(std::unique(this->Merged.begin(), this->Merged.end()), this->Merged.end());
}

std::pair<int, Ijk> FormerBoundaries::placeOf(Index meshPointId) const
{
  const auto after = std::upper_bound(this->First.begin(), this->First.end(), meshPointId);
  if (after == this->First.begin())
  {
    return { -1, {} };
  }
  const int block = static_cast<int>(after - this->First.begin()) - 1;
  const Index n = meshPointId - this->First[block];
  return { n < sizeOf(this->Counts[block]) ? block : -1, pointAt(this->Counts[block], n) };
}

Index FormerBoundaries::idAt(int block, const Ijk& p) const
{
  const Ijk& counts = this->Counts[block];
  return this->First[block] + p[0] + counts[0] * (p[1] + Index(counts[1]) * p[2]);
}

std::vector<Index> FormerBoundaries::copies(Index meshPointId) const
{
  std::vector<Index> ids{ meshPointId };
  const auto add = [&ids](Index id) {
    if (std::find(ids.begin(), ids.end(), id) == ids.end())
    {
      ids.push_back(id);
    }
  };
  // The list grows while it is walked. NOLINTNEXTLINE(modernize-loop-convert)
  for (std::size_t n = 0; n < ids.size(); ++n)
  {
    for (auto at = std::lower_bound(this->Merged.begin(), this->Merged.end(), std::make_pair(ids[n], Index(0)));
         at != this->Merged.end() && at->first == ids[n]; ++at)
    {
      add(at->second);
    }
    const auto [block, p] = this->placeOf(ids[n]);
    for (std::size_t i = 0;
         block >= 0 && block < static_cast<int>(this->Contacts.size()) && i < this->Contacts[block].size(); ++i)
    {
      const Interface& c = this->Contacts[block][i];
      const int d = faceDirection(c.faceA);
      const int s = p[faceAxis(c.faceA, 0)];
      const int t = p[faceAxis(c.faceA, 1)];
      const FaceRange& a = c.rangeA;
      if (p[d] != (faceSide(c.faceA) ? this->Counts[block][d] - 1 : 0) || s < a.lo[0] || s > a.hi[0] || t < a.lo[1] ||
        t > a.hi[1])
      {
        continue;
      }
      const auto onB = mapFacePoint(c.orientation, s - a.lo[0], t - a.lo[1], a.hi[0] - a.lo[0], a.hi[1] - a.lo[1]);
      add(this->idAt(c.blockB, pointOn(this->Counts[c.blockB], c.faceB, c.originB[0] + onB[0], c.originB[1] + onB[1])));
    }
  }
  return ids;
}

const FormerBoundaries::Name* FormerBoundaries::find(const std::array<Index, 4>& meshPointIds) const
{
  const int block = this->placeOf(meshPointIds[0]).first;
  if (const Name* found = block < 0 ? nullptr : this->findIn(block, meshPointIds))
  {
    return found;
  }
  // Where blocks meet a point may have the number that it has in another block.
  std::array<std::vector<Index>, 4> all;
  for (int c = 0; c < 4; ++c)
  {
    all[c] = this->copies(meshPointIds[c]);
  }
  for (Index first : all[0])
  {
    std::array<Index, 4> ids{ first, -1, -1, -1 };
    const int wanted = this->placeOf(first).first;
    for (int c = 1; c < 4; ++c)
    {
      for (Index id : all[c])
      {
        ids[c] = wanted >= 0 && this->placeOf(id).first == wanted ? id : ids[c];
      }
    }
    if (const Name* found = wanted < 0 ? nullptr : this->findIn(wanted, ids))
    {
      return found;
    }
  }
  return nullptr;
}

const FormerBoundaries::Name* FormerBoundaries::findIn(int block, const std::array<Index, 4>& meshPointIds) const
{
  if (block >= static_cast<int>(this->OfBlock.size()))
  {
    return nullptr;
  }
  const Ijk& counts = this->Counts[block];
  Ijk lo = counts;
  Ijk hi{ -1, -1, -1 };
  for (Index id : meshPointIds)
  {
    const auto [own, p] = this->placeOf(id);
    if (own != block)
    {
      return nullptr;
    }
    for (int d = 0; d < 3; ++d)
    {
      lo[d] = std::min(lo[d], p[d]);
      hi[d] = std::max(hi[d], p[d]);
    }
  }
  for (const Patch& patch : this->OfBlock[block])
  {
    const int d = faceDirection(patch.face);
    const int layer = faceSide(patch.face) ? counts[d] - 1 : 0;
    const int s = faceAxis(patch.face, 0);
    const int t = faceAxis(patch.face, 1);
    if (lo[d] == layer && hi[d] == layer && lo[s] >= patch.range.lo[0] && hi[s] <= patch.range.hi[0] &&
      lo[t] >= patch.range.lo[1] && hi[t] <= patch.range.hi[1])
    {
      return &this->Patches[patch.name];
    }
  }
  return nullptr;
}

} // namespace bsv

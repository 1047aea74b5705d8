// SPDX-License-Identifier: BSD-3-Clause
#include "Data/HexMeshData.h"

#include "Base/MemoryCheck.h"
#include "Base/ProgressPart.h"
#include "Data/BlockTagArrays.h"
#include "Data/BlockTags.h"
#include "Data/BoundaryPatterns.h"
#include "Data/HexBlockData.h"
#include "Data/SurfaceNames.h"
#include "Data/TreeLeaves.h"
#include "Mesh/BlockSurface.h"
#include "Ranks/Ranks.h"
#include "Ranks/Texts.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataSetAttributes.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>
#include <type_traits>

#if __has_include(<vtkCellTypeUtilities.h>)
#include <vtkCellTypeUtilities.h> // since VTK 9.6
using CellTypeNames = vtkCellTypeUtilities;
#else
#include <vtkCellTypes.h>
using CellTypeNames = vtkCellTypes;
#endif

namespace bsv
{

namespace
{

/// What a cell is to a hexahedral mesh.
enum class CellKind
{
  Hexahedron,
  HighOrderHexahedron,
  Voxel,
  Quadrilateral,
  Pixel,
  Triangle,
  Line,
  Other,
};

CellKind kindOf(int type, vtkIdType points)
{
  switch (type)
  {
    case VTK_HEXAHEDRON:
      return CellKind::Hexahedron;
    case VTK_QUADRATIC_HEXAHEDRON:
    case VTK_TRIQUADRATIC_HEXAHEDRON:
    case VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON:
    case VTK_LAGRANGE_HEXAHEDRON:
    case VTK_BEZIER_HEXAHEDRON:
      return CellKind::HighOrderHexahedron;
    case VTK_VOXEL:
      return CellKind::Voxel;
    case VTK_QUAD:
    case VTK_QUADRATIC_QUAD:
    case VTK_BIQUADRATIC_QUAD:
    case VTK_QUADRATIC_LINEAR_QUAD:
    case VTK_LAGRANGE_QUADRILATERAL:
    case VTK_BEZIER_QUADRILATERAL:
      return CellKind::Quadrilateral;
    case VTK_PIXEL:
      return CellKind::Pixel;
    case VTK_POLYGON:
      return points == 4 ? CellKind::Quadrilateral : CellKind::Triangle;
    case VTK_TRIANGLE:
    case VTK_TRIANGLE_STRIP:
    case VTK_QUADRATIC_TRIANGLE:
    case VTK_BIQUADRATIC_TRIANGLE:
    case VTK_QUADRATIC_POLYGON:
    case VTK_LAGRANGE_TRIANGLE:
    case VTK_BEZIER_TRIANGLE:
      return CellKind::Triangle;
    case VTK_EMPTY_CELL:
    case VTK_VERTEX:
    case VTK_POLY_VERTEX:
    case VTK_LINE:
    case VTK_POLY_LINE:
    case VTK_QUADRATIC_EDGE:
    case VTK_CUBIC_LINE:
    case VTK_LAGRANGE_CURVE:
    case VTK_BEZIER_CURVE:
      return CellKind::Line;
    default:
      return CellKind::Other;
  }
}

/// Type of a boundary of which nobody says what it is.
constexpr const char* UnknownType = "BCTypeUserDefined";

/// Point of a cell, in VTK's order, per block corner.
constexpr std::array<int, 8> HexahedronCorners{ 0, 1, 3, 2, 4, 5, 7, 6 };

/// A leaf of the tree with what it adds to the mesh.
struct HexLeaf
{
  vtkDataSet* data;
  std::string name;
  /// Numbers of its first point and cell among all leaves.
  Index firstPoint = 0;
  Index firstCell = 0;
};

class Collector
{
public:
  Collector(const HexMeshOptions& options, HexMesh& mesh)
    : Options(options)
    , Mesh(mesh)
  {
  }

  /// Adds the leaves of a tree. `surfaces`: only quadrilaterals count.
  void add(vtkDataObject* tree, bool surfaces)
  {
    std::vector<NamedLeaf> leaves = namedLeaves(tree);
    for (std::size_t n = 0; n < leaves.size(); ++n)
    {
      if (!leaves[n].data)
      {
        continue;
      }
      auto* data = vtkDataSet::SafeDownCast(leaves[n].data);
      std::string name = leaves[n].name.empty() ? "block " + std::to_string(n) : leaves[n].name;
      if (!data || !(data->IsA("vtkUnstructuredGrid") || data->IsA("vtkPolyData") || data->IsA("vtkStructuredGrid")))
      {
        throw Error("'" + name + "' is a " + leaves[n].data->GetClassName() +
          "; hexahedra come in vtkUnstructuredGrid or vtkStructuredGrid, boundaries also in vtkPolyData.");
      }
      if (data->GetNumberOfCells() == 0)
      {
        continue;
      }
      // The points of a volume that another filter made unstructured.
      if (data->GetFieldData()->HasArray("KnotsW"))
      {
        throw Error("'" + name +
          "' has the control points of a B-spline volume, which are no mesh: apply this filter to the mesh before the "
          "conversion, or to samples of the volume (BSpline Volume Sampler)");
      }
      // A reader may know what a boundary is.
      auto* type = vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray("BoundaryType"));
      if (type && type->GetNumberOfValues() == 1)
      {
        // Boundaries of one name and of several types are several.
        const std::string own = type->GetValue(0);
        std::string& known = this->TypeOf.emplace(name, own).first->second;
        if (known == UnknownType)
        {
          known = own;
        }
        if (known != own && own != UnknownType)
        {
          name += " (" + own + ")";
          this->TypeOf[name] = own;
        }
      }
      this->Leaves.push_back({ data, name, this->PointCount, this->CellCount });
      this->addCells(this->Leaves.back(), surfaces);
      this->PointCount += data->GetNumberOfPoints();
      this->CellCount += data->GetNumberOfCells();
    }
    if (!surfaces)
    {
      this->addStructuredNames(tree);
      this->addFormerNames(tree);
      if (this->FormerNames.empty() && this->QuadNames.empty())
      {
        this->LostNames = stringsOf(tree->GetFieldData(), "BoundaryNames");
      }
    }
  }

  /// To be called after all add().
  void finish()
  {
    std::map<std::string, int> tags;
    for (const std::string& name : this->QuadNames)
    {
      tags[name] = 0;
    }
    for (const std::string& name : this->FormerNames)
    {
      tags[name] = 0;
    }
    for (auto& tag : tags)
    {
      tag.second = static_cast<int>(this->Mesh.boundaryNames.size());
      this->Mesh.boundaryNames.push_back(tag.first);
    }
    for (std::size_t n = 0; n < this->Mesh.quads.size(); ++n)
    {
      this->Mesh.quads[n].tag = tags[this->QuadNames[n]];
    }
    for (const std::string& name : this->FormerNames)
    {
      this->FormerTags.push_back(tags[name]);
    }
    for (const auto& type : this->TypeOf)
    {
      const auto tag = tags.find(type.first);
      if (tag != tags.end())
      {
        this->Mesh.boundaryTypes.resize(this->Mesh.boundaryNames.size(), UnknownType);
        this->Mesh.boundaryTypes[tag->second] = type.second;
      }
    }
    if (!this->Options.boundaryArray.empty() && this->Quads > 0 && this->QuadNames.empty())
    {
      throw Error("there is no cell array '" + this->Options.boundaryArray + "' that names quadrilaterals; there are " +
        this->listedArrays());
    }
    if (this->Nameless > 0)
    {
      this->warnings.push_back("The mesh has " + std::to_string(this->Nameless) +
        " quadrilaterals without a name: choose the Boundary Array that names them, of " + this->listedArrays() + ".");
    }
    if (!this->LostNames.empty() && this->Mesh.boundaryNames.empty())
    {
      this->warnings.push_back("Where the boundaries " + quotedList(this->LostNames) +
        " were is lost: a filter before this one made the blocks unstructured, and their points have no MeshPointIds, "
        "which samples and choices of arrays leave out.");
    }
    const auto count = [&](Index number, const std::string& what) {
      if (number > 0)
      {
        this->notes.push_back(std::to_string(number) + what);
      }
    };
    count(this->HighOrder, " hexahedra are of higher order: only their corners are used.");
    if (this->Hidden > 0)
    {
      this->warnings.push_back(
        std::to_string(this->Hidden) + " hidden or duplicate cells (vtkGhostType) are left out.");
    }
    count(this->Lines, " vertices and lines are left out.");
    count(this->Triangles, " triangles and polygons are left out: no boundary of hexahedra has them.");
  }

  /// The points of all leaves as one array, which is the leaf's own if there is one of floats or doubles.
  void makePoints()
  {
    vtkDataArray* only = this->Leaves.size() == 1 ? pointsOf(this->Leaves[0].data)->GetData() : nullptr;
    const std::array<int, 3> counts{ static_cast<int>(this->PointCount), 1, 1 };
    if (auto* floats = vtkAOSDataArrayTemplate<float>::FastDownCast(only))
    {
      this->Mesh.points = GridView(floats->GetPointer(0), counts);
      return;
    }
    if (auto* doubles = vtkAOSDataArrayTemplate<double>::FastDownCast(only))
    {
      this->Mesh.points = GridView(doubles->GetPointer(0), counts);
      return;
    }
    this->Points.resize(3 * this->PointCount);
    for (const HexLeaf& leaf : this->Leaves)
    {
      vtkPoints* points = pointsOf(leaf.data);
      for (vtkIdType p = 0; p < points->GetNumberOfPoints(); ++p)
      {
        points->GetPoint(p, this->Points.data() + 3 * (leaf.firstPoint + p));
      }
    }
    this->Mesh.points = GridView(this->Points.data(), counts);
  }

  /// Lets faces of grids that were blocks have the names that they had there.
  void nameFormerFaces()
  {
    if (this->FormerNames.empty())
    {
      return;
    }
    this->Mesh.tagOf = [this](const std::array<HexId, 4>& points) {
      const int name = this->formerName(points);
      return name < 0 ? -1 : this->FormerTags[name];
    };
  }

  /// The faces of the cells here that have such a name, with the number of their name.
  std::vector<NamedQuad> formerFaces(const Execution& run) const
  {
    std::vector<NamedQuad> faces;
    for (Index cell = 0; cell < this->Mesh.cellCount() && !this->FormerNames.empty(); ++cell)
    {
      const HexId* corner = this->Mesh.corners.data() + 8 * cell;
      for (int f = 0; f < 6; ++f)
      {
        const std::array<HexId, 4> points{ corner[faceCorner(f, 0, 0)], corner[faceCorner(f, 1, 0)],
          corner[faceCorner(f, 0, 1)], corner[faceCorner(f, 1, 1)] };
        const int name = this->formerName(points);
        if (name >= 0)
        {
          faces.push_back({ points, name });
        }
      }
      if (cell % 4096 == 0)
      {
        run.report(0.1);
      }
    }
    return faces;
  }

  /// Names faces by what formerFaces() said on all ranks. @param names of all, per face
  void nameFormerFaces(const std::vector<NamedQuad>& faces, const std::vector<std::string>& names)
  {
    if (names.empty())
    {
      return;
    }
    this->FormerNames = names;
    std::sort(this->FormerNames.begin(), this->FormerNames.end());
    this->FormerNames.erase(std::unique(this->FormerNames.begin(), this->FormerNames.end()), this->FormerNames.end());
    std::vector<std::pair<std::array<HexId, 4>, int>> known;
    for (const NamedQuad& face : faces)
    {
      known.emplace_back(sorted(face.points), this->formerNumber(names[face.tag]));
    }
    std::sort(known.begin(), known.end());
    this->Mesh.tagOf = [this, known = std::move(known)](const std::array<HexId, 4>& points) {
      const std::array<HexId, 4> key = sorted(points);
      const auto found = std::lower_bound(known.begin(), known.end(), std::make_pair(key, -1));
      return found == known.end() || found->first != key ? -1 : this->FormerTags[found->second];
    };
  }
  const std::vector<std::string>& formerNames() const { return this->FormerNames; }
  std::map<std::string, std::string>& types() { return this->TypeOf; }

  const std::vector<HexLeaf>& leaves() const { return this->Leaves; }
  std::vector<double>& points() { return this->Points; }
  std::vector<std::string>& quadNames() { return this->QuadNames; }
  /// Per hexahedron the number of its cell among all leaves; empty if they are the same.
  std::vector<Index>& cellNumbers() { return this->CellNumbers; }
  Index pointCount() const { return this->PointCount; }
  Index cellCount() const { return this->CellCount; }

  std::string cellName(Index hexahedron) const
  {
    const Index cell = this->CellNumbers.empty() ? hexahedron : this->CellNumbers[hexahedron];
    const HexLeaf& leaf = this->leafOf(cell, &HexLeaf::firstCell);
    return "cell " + std::to_string(cell - leaf.firstCell) + (this->Leaves.size() > 1 ? " of '" + leaf.name + "'" : "");
  }

  std::string pointName(Index point) const
  {
    const HexLeaf& leaf = this->leafOf(point, &HexLeaf::firstPoint);
    return "point " + std::to_string(point - leaf.firstPoint) +
      (this->Leaves.size() > 1 ? " of '" + leaf.name + "'" : "");
  }

  const HexLeaf& leafOf(Index number, Index HexLeaf::*first) const
  {
    const auto behind = std::upper_bound(this->Leaves.begin(), this->Leaves.end(), number,
      [&](Index value, const HexLeaf& leaf) { return value < leaf.*first; });
    return *std::prev(behind);
  }

  std::vector<std::string> notes;
  std::vector<std::string> warnings;

private:
  static std::array<HexId, 4> sorted(std::array<HexId, 4> points)
  {
    std::sort(points.begin(), points.end());
    return points;
  }

  int formerNumber(const std::string& name) const
  {
    return static_cast<int>(
      std::lower_bound(this->FormerNames.begin(), this->FormerNames.end(), name) - this->FormerNames.begin());
  }

  /// Number of the name that a face had in the block that it was of; -1 for none.
  int formerName(const std::array<HexId, 4>& points) const
  {
    std::array<Index, 4> ids{};
    const HexLeaf& leaf = this->leafOf(points[0], &HexLeaf::firstPoint);
    const auto former = this->Former.find(leaf.data);
    if (former == this->Former.end())
    {
      return -1;
    }
    for (int c = 0; c < 4; ++c)
    {
      // A point that was merged may be another grid's.
      const HexLeaf& own = this->leafOf(points[c], &HexLeaf::firstPoint);
      vtkDataArray* numbers = own.data->GetPointData()->GetArray("MeshPointIds");
      if (!numbers)
      {
        return -1;
      }
      ids[c] = static_cast<Index>(numbers->GetTuple1(static_cast<vtkIdType>(points[c] - own.firstPoint)));
    }
    const FormerBoundaries::Name* name = former->second.find(ids);
    return name ? this->formerNumber(name->name) : -1;
  }

  static vtkPoints* pointsOf(vtkDataSet* data)
  {
    vtkPoints* points = vtkPointSet::SafeDownCast(data)->GetPoints();
    if (!points)
    {
      throw Error("a grid with cells has no points.");
    }
    return points;
  }

  HexId pointNumber(const HexLeaf& leaf, vtkIdType p) const
  {
    if (p < 0 || p >= leaf.data->GetNumberOfPoints())
    {
      throw Error("'" + leaf.name + "': a cell has the point " + std::to_string(p) + ", of " +
        std::to_string(leaf.data->GetNumberOfPoints()));
    }
    return static_cast<HexId>(leaf.firstPoint + p);
  }

  void addCells(const HexLeaf& leaf, bool surfaces)
  {
    constexpr Index MostPoints = std::numeric_limits<int>::max();
    if (this->PointCount + leaf.data->GetNumberOfPoints() > MostPoints ||
      this->CellCount + leaf.data->GetNumberOfCells() > MostHexCells)
    {
      throw Error("the mesh has more than " + std::to_string(MostPoints) + " points or " +
        std::to_string(MostHexCells) + " cells.");
    }
    const auto* cellGhosts =
      vtkUnsignedCharArray::SafeDownCast(leaf.data->GetCellData()->GetArray(vtkDataSetAttributes::GhostArrayName()));
    const auto* pointGhosts =
      vtkUnsignedCharArray::SafeDownCast(leaf.data->GetPointData()->GetArray(vtkDataSetAttributes::GhostArrayName()));
    constexpr unsigned char SkippedCell = vtkDataSetAttributes::HIDDENCELL | vtkDataSetAttributes::DUPLICATECELL;
    const auto skipped = [&](vtkIdType cell, vtkIdType count, const vtkIdType* points) {
      return (cellGhosts && (cellGhosts->GetValue(cell) & SkippedCell)) ||
        (pointGhosts && std::any_of(points, points + count, [&](vtkIdType p) {
          return (pointGhosts->GetValue(p) & vtkDataSetAttributes::HIDDENPOINT) != 0;
        }));
    };

    const bool structured = leaf.data->IsA("vtkStructuredGrid");
    this->BoundaryValues = leaf.data->GetCellData()->GetAbstractArray(this->Options.boundaryArray.c_str());
    const vtkIdType cells = leaf.data->GetNumberOfCells();
    const bool plain = !surfaces && leaf.firstCell == this->Mesh.cellCount() && this->CellNumbers.empty();
    if (!surfaces)
    {
      this->Mesh.corners.reserve(this->Mesh.corners.size() + 8 * cells);
    }
    vtkNew<vtkIdList> list;
    std::vector<vtkIdType> quads;
    Index hexahedra = 0;
    // A grid of hexahedra alone needs no numbers for its cells; they are made where the first other cell is met.
    const auto startNumbers = [&] {
      if (this->CellNumbers.empty())
      {
        for (Index n = 0; n < this->Mesh.cellCount(); ++n)
        {
          this->CellNumbers.push_back(n);
        }
        this->Numbered = true;
      }
    };
    if (!plain && !surfaces && !this->Numbered)
    {
      startNumbers();
    }
    for (vtkIdType c = 0; c < cells; ++c)
    {
      const int type = leaf.data->GetCellType(c);
      vtkIdType count = 0;
      const vtkIdType* points = nullptr;
      leaf.data->GetCellPoints(c, count, points, list);
      const CellKind kind = kindOf(type, count);
      const bool volume = kind <= CellKind::Voxel;
      if (volume && !surfaces && !skipped(c, count, points))
      {
        for (int v = 0; v < 8; ++v)
        {
          this->Mesh.corners.push_back(
            this->pointNumber(leaf, points[kind == CellKind::Voxel ? v : HexahedronCorners[v]]));
        }
        if (this->Numbered)
        {
          this->CellNumbers.push_back(leaf.firstCell + c);
        }
        this->HighOrder += kind == CellKind::HighOrderHexahedron;
        ++hexahedra;
        continue;
      }
      if (!surfaces && !this->Numbered)
      {
        startNumbers();
      }
      // A structured grid shows its hidden cells as empty ones.
      const bool empty = structured && type == VTK_EMPTY_CELL;
      this->Hidden += !surfaces && (volume || empty);
      this->Lines += kind == CellKind::Line && !empty;
      this->Triangles += kind == CellKind::Triangle;
      if (kind == CellKind::Other)
      {
        throw Error("cell " + std::to_string(c) + " of '" + leaf.name + "' is a " + typeName(type) +
          ": only hexahedra can be part of blocks.");
      }
      if (kind == CellKind::Quadrilateral || kind == CellKind::Pixel)
      {
        quads.push_back(c);
      }
    }
    if (quads.empty())
    {
      return;
    }
    this->Quads += static_cast<Index>(quads.size());
    for (vtkIdType c : quads)
    {
      const std::string name = this->nameOf(c, hexahedra == 0 ? leaf.name : "");
      if (name.empty())
      {
        ++this->Nameless;
        for (int n = 0; n < leaf.data->GetCellData()->GetNumberOfArrays(); ++n)
        {
          this->CellArrays.insert(leaf.data->GetCellData()->GetAbstractArray(n)->GetName());
        }
        continue;
      }
      vtkIdType count = 0;
      const vtkIdType* points = nullptr;
      leaf.data->GetCellPoints(c, count, points, list);
      const bool pixel = leaf.data->GetCellType(c) == VTK_PIXEL;
      this->Mesh.quads.push_back(
        { { this->pointNumber(leaf, points[0]), this->pointNumber(leaf, points[1]),
            this->pointNumber(leaf, points[pixel ? 3 : 2]), this->pointNumber(leaf, points[pixel ? 2 : 3]) },
          0 });
      this->QuadNames.push_back(name);
    }
  }

  static std::string typeName(int type)
  {
    const char* name = CellTypeNames::GetClassNameFromTypeId(type);
    return std::string(name ? name : "cell") + " (type " + std::to_string(type) + ")";
  }

  std::string nameOf(vtkIdType cell, const std::string& leafName) const
  {
    if (auto* strings = vtkStringArray::SafeDownCast(this->BoundaryValues))
    {
      return strings->GetValue(cell);
    }
    if (auto* numbers = vtkDataArray::SafeDownCast(this->BoundaryValues))
    {
      const double value = numbers->GetComponent(cell, 0);
      return this->Options.boundaryArray + " " + text(value);
    }
    return leafName;
  }

  std::string listedArrays() const
  {
    std::string list;
    for (const std::string& name : this->CellArrays)
    {
      list += (list.empty() ? "'" : ", '") + name + "'";
    }
    return list.empty() ? "none" : list;
  }

  /// Names of blocks that became unstructured.
  void addFormerNames(vtkDataObject* tree)
  {
    for (const HexLeaf& leaf : this->Leaves)
    {
      if (!leaf.data->IsA("vtkUnstructuredGrid"))
      {
        continue;
      }
      FormerBoundaries former(tree->GetFieldData(), leaf.data);
      for (const FormerBoundaries::Name& name : former.names())
      {
        this->FormerNames.push_back(name.name);
        if (!name.type.empty())
        {
          this->TypeOf[name.name] = name.type;
        }
      }
      if (!former.empty())
      {
        this->Former.emplace(leaf.data, std::move(former));
      }
    }
    std::sort(this->FormerNames.begin(), this->FormerNames.end());
    this->FormerNames.erase(std::unique(this->FormerNames.begin(), this->FormerNames.end()), this->FormerNames.end());
  }

  /// Makes quadrilaterals of the named boundaries of structured grids. Hexahedra and structured grids may be mixed.
  void addStructuredNames(vtkDataObject* tree)
  {
    vtkNew<vtkPartitionedDataSetCollection> structured;
    unsigned int count = 0;
    for (const HexLeaf& leaf : this->Leaves)
    {
      if (leaf.data->IsA("vtkStructuredGrid") && !isSurface(leaf.data))
      {
        structured->SetPartition(count++, 0, leaf.data);
      }
    }
    if (count == 0)
    {
      return;
    }
    // The arrays of the tree count its leaves; of a part of them the blocks' own are asked.
    const bool all = count == namedLeaves(tree).size();
    if (all)
    {
      structured->GetFieldData()->ShallowCopy(tree->GetFieldData());
    }
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
    const BlockMesh mesh = structuredBlocks(structured, grids);
    this->notes.insert(this->notes.end(), mesh.notes.begin(), mesh.notes.end());
    this->warnings.insert(this->warnings.end(), mesh.warnings.begin(), mesh.warnings.end());
    for (std::size_t n = 0; n < mesh.boundaryTypes.size(); ++n)
    {
      this->TypeOf[mesh.boundaryNames[n]] = mesh.boundaryTypes[n];
    }
    std::map<vtkDataSet*, const HexLeaf*> leafOf;
    for (const HexLeaf& leaf : this->Leaves)
    {
      leafOf[leaf.data] = &leaf;
    }
    for (const BoundaryPatch& patch : mesh.boundaries)
    {
      const auto leaf = leafOf.find(grids[patch.block]);
      if (leaf == leafOf.end())
      {
        continue;
      }
      const Ijk& counts = mesh.blocks[patch.block].points.counts();
      const auto point = [&](int s, int t) {
        Ijk p{};
        p[faceDirection(patch.face)] = faceSide(patch.face) ? counts[faceDirection(patch.face)] - 1 : 0;
        p[faceAxis(patch.face, 0)] = s;
        p[faceAxis(patch.face, 1)] = t;
        return this->pointNumber(*leaf->second, p[0] + counts[0] * (p[1] + vtkIdType(counts[1]) * p[2]));
      };
      for (int t = patch.range.lo[1]; t < patch.range.hi[1]; ++t)
      {
        for (int s = patch.range.lo[0]; s < patch.range.hi[0]; ++s)
        {
          this->Mesh.quads.push_back({ { point(s, t), point(s + 1, t), point(s + 1, t + 1), point(s, t + 1) }, 0 });
          this->QuadNames.push_back(mesh.boundaryNames[patch.tag]);
        }
      }
    }
  }

  const HexMeshOptions& Options;
  HexMesh& Mesh;
  std::vector<HexLeaf> Leaves;
  std::vector<double> Points;
  std::vector<std::string> QuadNames;
  std::map<std::string, std::string> TypeOf;
  std::map<vtkDataSet*, FormerBoundaries> Former;
  /// Ascending, and their tags.
  std::vector<std::string> FormerNames;
  /// Of a mesh that once had boundaries, none of which can be found.
  std::vector<std::string> LostNames;
  std::vector<int> FormerTags;
  std::vector<Index> CellNumbers;
  bool Numbered = false;
  vtkAbstractArray* BoundaryValues = nullptr;
  std::set<std::string> CellArrays;
  Index PointCount = 0;
  Index CellCount = 0;
  Index Quads = 0;
  Index Nameless = 0;
  Index HighOrder = 0;
  Index Hidden = 0;
  Index Lines = 0;
  Index Triangles = 0;
};

/// Sends everything to the first rank.
void gatherMesh(HexMesh& mesh, Collector& collector, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  const auto toFirst = [&](auto& values) {
    std::vector<std::remove_reference_t<decltype(values)>> to(ranks.size());
    to[0].swap(values);
    return ranks.exchange(std::move(to));
  };
  if (collector.points().empty())
  {
    for (Index p = 0; p < mesh.pointCount(); ++p)
    {
      const Vec3 x = mesh.points.atPlace(p);
      collector.points().insert(collector.points().end(), x.data(), x.data() + 3);
    }
  }
  if (collector.cellNumbers().empty())
  {
    for (Index c = 0; c < mesh.cellCount(); ++c)
    {
      collector.cellNumbers().push_back(c);
    }
  }
  std::vector<char> names = lettersOf(collector.quadNames());
  std::vector<char> formerNames = lettersOf(collector.formerNames());
  std::vector<NamedQuad> formerFaces = collector.formerFaces(run);
  std::vector<std::string> typeTexts;
  for (const auto& [name, type] : collector.types())
  {
    typeTexts.insert(typeTexts.end(), { name, type });
  }
  std::vector<char> types = lettersOf(typeTexts);
  std::vector<Index> sizes{ collector.cellCount() };
  const auto allPoints = toFirst(collector.points());
  const auto allCorners = toFirst(mesh.corners);
  const auto allNumbers = toFirst(collector.cellNumbers());
  const auto allQuads = toFirst(mesh.quads);
  const auto allNames = toFirst(names);
  const auto allFormerNames = toFirst(formerNames);
  const auto allFormerFaces = toFirst(formerFaces);
  const auto allTypes = toFirst(types);
  const auto allSizes = toFirst(sizes);
  collector.quadNames().clear();
  if (ranks.rank() > 0)
  {
    return;
  }
  Index firstCell = 0;
  std::vector<NamedQuad> faces;
  std::vector<std::string> namesOfFaces;
  for (int r = 0; r < ranks.size(); ++r)
  {
    const Index firstPoint = static_cast<Index>(collector.points().size()) / 3;
    if (firstPoint + static_cast<Index>(allPoints[r].size()) / 3 > std::numeric_limits<int>::max())
    {
      throw Error("the mesh has more than " + std::to_string(std::numeric_limits<int>::max()) + " points.");
    }
    collector.points().insert(collector.points().end(), allPoints[r].begin(), allPoints[r].end());
    for (const HexId p : allCorners[r])
    {
      mesh.corners.push_back(static_cast<HexId>(firstPoint + p));
    }
    for (const Index c : allNumbers[r])
    {
      collector.cellNumbers().push_back(firstCell + c);
    }
    for (NamedQuad quad : allQuads[r])
    {
      for (HexId& p : quad.points)
      {
        p += static_cast<HexId>(firstPoint);
      }
      mesh.quads.push_back(quad);
    }
    for (const std::string& name : textsOf(allNames[r]))
    {
      collector.quadNames().push_back(name);
    }
    for (NamedQuad face : allFormerFaces[r])
    {
      for (HexId& p : face.points)
      {
        p += static_cast<HexId>(firstPoint);
      }
      face.tag += static_cast<int>(namesOfFaces.size());
      faces.push_back(face);
    }
    for (const std::string& name : textsOf(allFormerNames[r]))
    {
      namesOfFaces.push_back(name);
    }
    const std::vector<std::string> typesOfNames = textsOf(allTypes[r]);
    for (std::size_t n = 0; n + 1 < typesOfNames.size(); n += 2)
    {
      collector.types().emplace(typesOfNames[n], typesOfNames[n + 1]);
    }
    firstCell += allSizes[r][0];
  }
  collector.nameFormerFaces(faces, namesOfFaces);
  mesh.points = GridView(collector.points().data(), { static_cast<int>(collector.points().size() / 3), 1, 1 });
}

/// Names of the arrays that all leaves with points or cells of the mesh have alike.
std::vector<std::string> commonArrays(
  const std::vector<HexLeaf>& leaves, vtkDataSetAttributes* (*attributes)(vtkDataSet*))
{
  std::vector<std::string> names;
  vtkDataSetAttributes* first = attributes(leaves.front().data);
  for (int n = 0; n < first->GetNumberOfArrays(); ++n)
  {
    vtkAbstractArray* array = first->GetAbstractArray(n);
    const std::string name = array->GetName() ? array->GetName() : "";
    const bool everywhere = std::all_of(leaves.begin(), leaves.end(), [&](const HexLeaf& leaf) {
      vtkAbstractArray* other = attributes(leaf.data)->GetAbstractArray(name.c_str());
      return other && other->GetDataType() == array->GetDataType() &&
        other->GetNumberOfComponents() == array->GetNumberOfComponents();
    });
    if (everywhere && !name.empty() && name != "OriginalPointIds" && name != "OriginalCellIds" &&
      name != "MeshPointIds" && name != vtkDataSetAttributes::GhostArrayName())
    {
      names.push_back(name);
    }
  }
  return names;
}

vtkDataSetAttributes* pointData(vtkDataSet* data)
{
  return data->GetPointData();
}
vtkDataSetAttributes* cellData(vtkDataSet* data)
{
  return data->GetCellData();
}

void copyArrays(vtkDataSetAttributes* to, vtkIdTypeArray* ids, const std::vector<std::string>& names,
  const Collector& collector, Index HexLeaf::*first, vtkDataSetAttributes* (*attributes)(vtkDataSet*))
{
  to->AddArray(ids);
  for (const std::string& name : names)
  {
    vtkAbstractArray* like = attributes(collector.leaves().front().data)->GetAbstractArray(name.c_str());
    const auto array = vtkSmartPointer<vtkAbstractArray>::Take(like->NewInstance());
    array->SetName(name.c_str());
    array->SetNumberOfComponents(like->GetNumberOfComponents());
    array->SetNumberOfTuples(ids->GetNumberOfTuples());
    for (vtkIdType n = 0; n < ids->GetNumberOfTuples(); ++n)
    {
      const HexLeaf& leaf = collector.leafOf(ids->GetValue(n), first);
      array->SetTuple(n, ids->GetValue(n) - leaf.*first, attributes(leaf.data)->GetAbstractArray(name.c_str()));
    }
    to->AddArray(array);
  }
}

/// The blocks made, without their points.
BlockMesh outputMesh(const BaseComplex& complex, const std::vector<Ijk>& counts, const std::vector<std::string>& types,
  const std::vector<std::string>& names)
{
  BlockMesh mesh;
  for (std::size_t b = 0; b < counts.size(); ++b)
  {
    MeshBlock block;
    block.points = GridView::elsewhere(counts[b]);
    block.name = names[b];
    mesh.blocks.push_back(block);
  }
  mesh.interfaces = complex.interfaces;
  mesh.boundaries = complex.boundaries;
  mesh.boundaryNames = complex.boundaryNames;
  mesh.boundaryTypes = types;
  return mesh;
}

vtkSmartPointer<vtkIdTypeArray> idArray(const char* name, Index size)
{
  auto array = vtkSmartPointer<vtkIdTypeArray>::New();
  array->SetName(name);
  array->SetNumberOfValues(size);
  return array;
}

} // namespace

bool needsBlocks(vtkDataObject* input)
{
  if (!input)
  {
    return false;
  }
  for (const NamedLeaf& leaf : namedLeaves(input))
  {
    auto* grid = vtkStructuredGrid::SafeDownCast(leaf.data);
    if (grid ? grid->HasAnyBlankCells() : vtkUnstructuredGrid::SafeDownCast(leaf.data) != nullptr)
    {
      return true;
    }
  }
  return false;
}

HexMeshReport hexMeshToBlocks(vtkDataObject* given, vtkDataObject* surfaces, const HexMeshOptions& options,
  vtkPartitionedDataSetCollection* output, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  const vtkSmartPointer<vtkDataObject> input = withExplicitPoints(given);
  HexMesh mesh;
  Collector collector(options, mesh);
  HexMeshReport report;
  const auto part = [&](double from, double to) {
    Execution result = progressPart(run, from, to);
    result.ranks = aloneRank();
    return result;
  };
  if (input)
  {
    collector.add(input, false);
  }
  if (surfaces)
  {
    collector.add(surfaces, true);
  }
  // Neighbours, numbers, and in the blocks points and the numbers that they and the cells had.
  constexpr double BytesPerCell = 100.0;
  requireMemory(BytesPerCell * static_cast<double>(mesh.cellCount()), std::to_string(mesh.cellCount()) + " hexahedra",
    "their blocks");
  collector.makePoints();
  run.report(0.1);
  const bool several = ranks.size() > 1;
  if (several)
  {
    gatherMesh(mesh, collector, run);
  }
  collector.finish();
  if (!several)
  {
    collector.nameFormerFaces();
  }
  output->Initialize();
  if (mesh.cellCount() > 0)
  {
    mesh.cellName = [&](Index cell) {
      return several ? "cell " + std::to_string(collector.cellNumbers()[cell]) : collector.cellName(cell);
    };
    mesh.pointName = [&](
                       Index point) { return several ? "point " + std::to_string(point) : collector.pointName(point); };
    BaseComplex complex = baseComplex(mesh, options.complex, part(0.1, 0.8));
    if (complex.boundaryNames != mesh.boundaryNames)
    {
      mesh.boundaryTypes.clear(); // new names were made of angles
    }
    std::vector<HexId>().swap(mesh.corners);

    const auto pointArrays = several ? std::vector<std::string>() : commonArrays(collector.leaves(), pointData);
    const auto cellArrays = several ? std::vector<std::string>() : commonArrays(collector.leaves(), cellData);
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
    std::vector<std::string> names;
    std::vector<Ijk> counts;
    const Index blocks = static_cast<Index>(complex.blocks.size());
    for (Index b = 0; b < blocks; ++b)
    {
      HexBlock& block = complex.blocks[b];
      double* x = nullptr;
      counts.push_back({ block.cells[0] + 1, block.cells[1] + 1, block.cells[2] + 1 });
      vtkSmartPointer<vtkStructuredGrid> grid = blockGrid(counts.back(), x);
      const auto points = idArray("OriginalPointIds", static_cast<Index>(block.pointIds.size()));
      const auto cells = idArray("OriginalCellIds", static_cast<Index>(block.cellIds.size()));
      run.parallelFor(points->GetNumberOfValues(), 1 << 16, [&](Index begin, Index end) {
        for (Index n = begin; n < end; ++n)
        {
          const Vec3 place = mesh.points.atPlace(block.pointIds[n]);
          std::copy(place.data(), place.data() + 3, x + 3 * n);
          points->SetValue(n, block.pointIds[n]);
        }
      });
      for (std::size_t n = 0; n < block.cellIds.size(); ++n)
      {
        const Index cell = block.cellIds[n];
        cells->SetValue(
          static_cast<vtkIdType>(n), collector.cellNumbers().empty() ? cell : collector.cellNumbers()[cell]);
      }
      std::vector<HexId>().swap(block.cellIds);
      std::vector<HexId>().swap(block.pointIds);
      copyArrays(grid->GetPointData(), points, pointArrays, collector, &HexLeaf::firstPoint, pointData);
      copyArrays(grid->GetCellData(), cells, cellArrays, collector, &HexLeaf::firstCell, cellData);
      grids.push_back(grid);
      names.push_back("block " + std::to_string(b));
      if (b % 1024 == 0)
      {
        run.report(0.8 + 0.2 * b / blocks);
      }
    }
    setBlocks(output, grids, names, "Blocks");
    setInterfaces(output->GetFieldData(), complex.interfaces, counts);
    setBoundaries(output->GetFieldData(), complex.boundaries, complex.boundaryNames, counts, mesh.boundaryTypes);
    tagBlocks(output, outputMesh(complex, counts, mesh.boundaryTypes, names), "hexahedra");
    for (const Ijk& n : counts)
    {
      report.cells += Index(n[0] - 1) * (n[1] - 1) * (n[2] - 1);
    }
    report.points = mesh.pointCount();
    report.blocks = blocks;
    report.singularEdges = complex.singularEdges;
    report.notes = std::move(complex.notes);
    report.warnings = std::move(complex.warnings);
  }
  report.notes.insert(report.notes.begin(), collector.notes.begin(), collector.notes.end());
  report.warnings.insert(report.warnings.begin(), collector.warnings.begin(), collector.warnings.end());
  return report;
}

} // namespace bsv

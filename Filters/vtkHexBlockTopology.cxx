// SPDX-License-Identifier: BSD-3-Clause
#include "vtkHexBlockTopology.h"

#include "Complex/BlockComplex.h"
#include "Complex/EntityClass.h"
#include "Data/HexBlockData.h"
#include "Execution/FilterExecution.h"
#include "Ranks/Ranks.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataAssembly.h"
#include "vtkDataObject.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkStringArray.h"
#include "vtkStructuredGrid.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <array>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

vtkStandardNewMacro(vtkHexBlockTopology);

namespace
{

/// What the cells of one entity say.
struct EntityData
{
  bsv::EntityClass what = bsv::EntityClass::Regular;
  int valence = 0;
  std::vector<int> blocks;
  int tag = -1;
};

/// Cells per entity, the points of which are not shared with other entities. All entities of the complex have a number,
/// but only those of one rank have cells: those whose first use is by one of its blocks.
class PartBuilder
{
public:
  explicit PartBuilder(int entities)
  {
    this->Entities.reserve(entities);
    this->Points->SetDataTypeToDouble();
  }

  void add(EntityData data)
  {
    std::sort(data.blocks.begin(), data.blocks.end());
    data.blocks.erase(std::unique(data.blocks.begin(), data.blocks.end()), data.blocks.end());
    this->Entities.push_back(std::move(data));
  }

  vtkIdType addPoint(const bsv::Vec3& x) { return this->Points->InsertNextPoint(x.data()); }

  /// A cell of the entity added last.
  void addCell(const std::vector<vtkIdType>& points)
  {
    this->Cells->InsertNextCell(static_cast<vtkIdType>(points.size()), points.data());
    this->EntityOfCell.push_back(static_cast<int>(this->Entities.size()) - 1);
  }

  /// @param place vtkPolyData::SetVerts, SetLines or SetPolys
  /// @param width mostBlocks()
  vtkSmartPointer<vtkPolyData> build(void (vtkPolyData::*place)(vtkCellArray*), std::size_t width) const
  {
    const auto ids = this->cellArray<vtkIntArray>("GlobalId");
    const auto classes = this->cellArray<vtkUnsignedCharArray>("Class");
    const auto valences = this->cellArray<vtkIntArray>("Valence");
    const auto blocks = this->cellArray<vtkIntArray>("BlockIds", static_cast<int>(width));
    const auto tags = this->cellArray<vtkIntArray>("BoundaryTag");
    for (std::size_t c = 0; c < this->EntityOfCell.size(); ++c)
    {
      const vtkIdType cell = static_cast<vtkIdType>(c);
      const EntityData& data = this->Entities[this->EntityOfCell[c]];
      ids->SetValue(cell, this->EntityOfCell[c]);
      classes->SetValue(cell, static_cast<unsigned char>(data.what));
      valences->SetValue(cell, data.valence);
      tags->SetValue(cell, data.tag);
      for (std::size_t b = 0; b < width; ++b)
      {
        blocks->SetTypedComponent(cell, static_cast<int>(b), b < data.blocks.size() ? data.blocks[b] : -1);
      }
    }

    auto part = vtkSmartPointer<vtkPolyData>::New();
    part->SetPoints(this->Points);
    (part->*place)(this->Cells);
    for (vtkDataArray* array : std::initializer_list<vtkDataArray*>{ ids, classes, valences, blocks, tags })
    {
      part->GetCellData()->AddArray(array);
    }
    part->GetCellData()->SetActiveScalars("Valence");
    return part;
  }

private:
  template <typename Array>
  vtkSmartPointer<Array> cellArray(const char* name, int components = 1) const
  {
    auto array = vtkSmartPointer<Array>::New();
    array->SetName(name);
    array->SetNumberOfComponents(components);
    array->SetNumberOfTuples(static_cast<vtkIdType>(this->EntityOfCell.size()));
    return array;
  }

  std::vector<EntityData> Entities;
  std::vector<int> EntityOfCell;
  vtkNew<vtkPoints> Points;
  vtkNew<vtkCellArray> Cells;
};

/// The most blocks that any entity has: edges and faces have no others than their vertices.
std::size_t mostBlocks(const bsv::BlockComplex& complex)
{
  std::size_t most = 1;
  for (const bsv::ComplexVertex& vertex : complex.vertices)
  {
    std::set<int> blocks;
    for (const bsv::CornerUse& use : vertex.corners)
    {
      blocks.insert(use.block);
    }
    most = std::max(most, blocks.size());
  }
  return most;
}

/// Lowest boundary tag per vertex and edge.
struct BoundaryTags
{
  std::vector<int> vertices;
  std::vector<int> edges;

  explicit BoundaryTags(const bsv::BlockComplex& complex)
    : vertices(complex.vertices.size(), -1)
    , edges(complex.edges.size(), -1)
  {
    const auto lower = [](int& tag, int other) { tag = tag < 0 ? other : std::min(tag, other); };
    for (const bsv::ComplexFace& face : complex.faces)
    {
      if (face.tag < 0)
      {
        continue;
      }
      const bsv::FaceUse& use = face.uses.front();
      const bsv::ComplexBlock& block = complex.blocks[use.block];
      for (int a = 0; a < 2; ++a)
      {
        for (int b = 0; b < 2; ++b)
        {
          lower(this->vertices[block.vertices[bsv::faceCorner(use.face, a, b)]], face.tag);
          lower(this->edges[block.edges[bsv::faceEdge(use.face, a, b)]], face.tag);
        }
      }
    }
  }
};

bsv::Ijk cornerPoint(const bsv::ComplexBlock& block, int corner)
{
  bsv::Ijk ijk{};
  for (int d = 0; d < 3; ++d)
  {
    ijk[d] = bsv::cornerSide(corner, d) * block.cells(d);
  }
  return ijk;
}

vtkSmartPointer<vtkPolyData> vertexPart(
  const bsv::BlockComplex& complex, const bsv::EntityClasses& classes, const BoundaryTags& tags, int rank)
{
  PartBuilder part(static_cast<int>(complex.vertices.size()));
  for (std::size_t v = 0; v < complex.vertices.size(); ++v)
  {
    const auto& corners = complex.vertices[v].corners;
    EntityData data{ classes.vertices[v], static_cast<int>(corners.size()), {}, tags.vertices[v] };
    for (const bsv::CornerUse& use : corners)
    {
      data.blocks.push_back(use.block);
    }
    part.add(std::move(data));
    const bsv::ComplexBlock& block = complex.blocks[corners.front().block];
    if (block.rank != rank)
    {
      continue;
    }
    part.addCell({ part.addPoint(block.points(cornerPoint(block, corners.front().corner))) });
  }
  return part.build(&vtkPolyData::SetVerts, mostBlocks(complex));
}

vtkSmartPointer<vtkPolyData> edgePart(
  const bsv::BlockComplex& complex, const bsv::EntityClasses& classes, const BoundaryTags& tags, int rank)
{
  PartBuilder part(static_cast<int>(complex.edges.size()));
  for (std::size_t e = 0; e < complex.edges.size(); ++e)
  {
    const bsv::ComplexEdge& edge = complex.edges[e];
    EntityData data{ classes.edges[e], edge.valence(), {}, tags.edges[e] };
    for (const bsv::EdgeUse& use : edge.uses)
    {
      data.blocks.push_back(use.block);
    }
    part.add(std::move(data));

    const bsv::EdgeUse& use = edge.uses.front();
    const bsv::ComplexBlock& block = complex.blocks[use.block];
    if (block.rank != rank)
    {
      continue;
    }
    bsv::Ijk ijk = cornerPoint(block, bsv::edgeCorner(use.edge, 0));
    std::vector<vtkIdType> line;
    for (int n = 0; n <= edge.cells; ++n)
    {
      ijk[bsv::edgeDirection(use.edge)] = use.reversed ? edge.cells - n : n;
      line.push_back(part.addPoint(block.points(ijk)));
    }
    part.addCell(line);
  }
  return part.build(&vtkPolyData::SetLines, mostBlocks(complex));
}

vtkSmartPointer<vtkPolyData> facePart(const bsv::BlockComplex& complex, const bsv::EntityClasses& classes, int rank)
{
  PartBuilder part(static_cast<int>(complex.faces.size()));
  for (std::size_t f = 0; f < complex.faces.size(); ++f)
  {
    const bsv::ComplexFace& face = complex.faces[f];
    EntityData data{ classes.faces[f], static_cast<int>(face.uses.size()), {}, face.tag };
    for (const bsv::FaceUse& use : face.uses)
    {
      data.blocks.push_back(use.block);
    }
    part.add(std::move(data));

    const int side = face.uses.front().face;
    const bsv::ComplexBlock& block = complex.blocks[face.uses.front().block];
    if (block.rank != rank)
    {
      continue;
    }
    const bsv::Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
    const int ns = cells[bsv::faceAxis(side, 0)];
    const int nt = cells[bsv::faceAxis(side, 1)];
    vtkIdType first = 0;
    for (int t = 0; t <= nt; ++t)
    {
      for (int s = 0; s <= ns; ++s)
      {
        const vtkIdType id = part.addPoint(block.points(bsv::facePoint(cells, side, s, t)));
        first = s == 0 && t == 0 ? id : first;
      }
    }
    // Ascending axes make s x t the outward normal at the maximum sides of i and k and at the minimum side of j.
    const bool outward = (bsv::faceDirection(side) == 1) != (bsv::faceSide(side) == 1);
    for (int t = 0; t < nt; ++t)
    {
      for (int s = 0; s < ns; ++s)
      {
        const vtkIdType p = first + s + vtkIdType(ns + 1) * t;
        const vtkIdType q = p + ns + 1;
        part.addCell(
          outward ? std::vector<vtkIdType>{ p, p + 1, q + 1, q } : std::vector<vtkIdType>{ p, q, q + 1, p + 1 });
      }
    }
  }
  return part.build(&vtkPolyData::SetPolys, mostBlocks(complex));
}

vtkSmartPointer<vtkStringArray> stringArray(const char* name, const std::vector<std::string>& values)
{
  auto array = vtkSmartPointer<vtkStringArray>::New();
  array->SetName(name);
  for (const std::string& value : values)
  {
    array->InsertNextValue(value);
  }
  return array;
}

} // namespace

//------------------------------------------------------------------------------
int vtkHexBlockTopology::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkHexBlockTopology::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataObject* input = vtkDataObject::GetData(inputVector[0], 0);
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector, 0);
  if (!input || !output)
  {
    vtkErrorMacro("Input or output is missing.");
    return 0;
  }

  this->NumberOfInputBlocks = this->NumberOfBlocks = 0;
  this->NumberOfVertices = this->NumberOfEdges = this->NumberOfFaces = 0;
  this->NumberOfExtraordinaryEdges = this->NumberOfSingularNodes = 0;
  this->Report.clear();

  return bsv::execute(this, output, [&] {
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
    const bsv::Execution run = bsv::filterExecution(this, 0.0, 0.8);
    const int rank = run.ranks->rank();
    const bsv::BlockMesh mesh = bsv::blockMesh(input, grids, *run.ranks);
    bsv::BlockComplexOptions options;
    options.matchTolerance = this->MatchTolerance;
    options.allowDegenerate = this->AllowDegenerate;
    options.creaseAngle = this->UseCreaseAngle ? this->CreaseAngle : 180.0;
    const bsv::BlockComplex complex =
      mesh.blocks.empty() ? bsv::BlockComplex{} : bsv::buildBlockComplex(mesh, options, run);
    const bsv::EntityClasses classes = bsv::classifyEntities(complex);

    const BoundaryTags tags(complex);
    const std::array<std::pair<const char*, vtkSmartPointer<vtkPolyData>>, 3> parts{ {
      { "Vertices", vertexPart(complex, classes, tags, rank) },
      { "Edges", edgePart(complex, classes, tags, rank) },
      { "Faces", facePart(complex, classes, rank) },
    } };
    vtkNew<vtkDataAssembly> assembly;
    assembly->SetRootNodeName("HexBlockTopology");
    output->SetNumberOfPartitionedDataSets(3);
    for (unsigned int p = 0; p < 3; ++p)
    {
      output->SetPartition(p, 0, parts[p].second);
      output->GetMetaData(p)->Set(vtkCompositeDataSet::NAME(), parts[p].first);
      assembly->AddDataSetIndex(assembly->AddNode(parts[p].first), p);
    }
    output->SetDataAssembly(assembly);

    vtkNew<vtkIntArray> curves;
    curves->SetName("ExtraordinaryCurves");
    curves->SetNumberOfComponents(2);
    std::ostringstream report;
    report << mesh.blocks.size() << " blocks, " << complex.blocks.size() << " after cutting\n"
           << complex.vertices.size() << " vertices, " << complex.edges.size() << " edges, " << complex.faces.size()
           << " faces\n"
           << classes.extraordinaryEdges << " extraordinary edges, " << classes.singularNodes << " singular nodes\n";
    for (const std::string& note : complex.notes)
    {
      report << note << '\n';
    }
    for (const auto& [valence, count] : classes.extraordinaryCurves)
    {
      const int tuple[2] = { valence, static_cast<int>(count) };
      curves->InsertNextTypedTuple(tuple);
      report << count << " extraordinary curves of valence " << valence << '\n';
    }
    vtkNew<vtkIntArray> parents;
    parents->SetName("ParentBlock");
    for (const bsv::ComplexBlock& block : complex.blocks)
    {
      parents->InsertNextValue(block.parent);
    }
    // What the pipeline passes on from the input, on ranks that have none of it, too.
    bsv::setConnectivity(output->GetFieldData(), mesh);
    output->GetFieldData()->AddArray(curves);
    output->GetFieldData()->AddArray(parents);
    output->GetFieldData()->AddArray(stringArray("ClassNames", bsv::entityClassNames()));
    output->GetFieldData()->AddArray(stringArray("BoundaryNames", complex.boundaryNames));

    this->NumberOfInputBlocks = static_cast<int>(mesh.blocks.size());
    this->NumberOfBlocks = static_cast<int>(complex.blocks.size());
    this->NumberOfVertices = static_cast<int>(complex.vertices.size());
    this->NumberOfEdges = static_cast<int>(complex.edges.size());
    this->NumberOfFaces = static_cast<int>(complex.faces.size());
    this->NumberOfExtraordinaryEdges = static_cast<int>(classes.extraordinaryEdges);
    this->NumberOfSingularNodes = static_cast<int>(classes.singularNodes);
    this->Report = report.str();
    bsv::warn(this, complex.warnings);
    this->UpdateProgress(1.0);
  });
}

//------------------------------------------------------------------------------
void vtkHexBlockTopology::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "MatchTolerance: " << this->MatchTolerance << '\n';
  os << indent << "AllowDegenerate: " << (this->AllowDegenerate ? "On" : "Off") << '\n';
  os << indent << "UseCreaseAngle: " << (this->UseCreaseAngle ? "On" : "Off") << '\n';
  os << indent << "CreaseAngle: " << this->CreaseAngle << '\n';
  os << indent << "Report: " << this->Report << '\n';
}

// SPDX-License-Identifier: BSD-3-Clause
#include "vtkHexBlockTopology.h"

#include "Body/BodyEdges.h"
#include "Complex/BlockComplex.h"
#include "Complex/CreaseEdges.h"
#include "Complex/EntityClass.h"
#include "Complex/MeshDoctor.h"
#include "Data/BoundarySelection.h"
#include "Data/HexBlockData.h"
#include "Data/MeshInput.h"
#include "Data/NURBSSurfaceData.h"
#include "Execution/FilterExecution.h"
#include "Ranks/Ranks.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataAssembly.h"
#include "vtkDataObject.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkIdTypeArray.h"
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
#include "vtkTable.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <array>
#include <memory>
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

  vtkPoints* points() { return this->Points; }
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

/// The mesh points and quadrilaterals of a block face.
class FaceGrid
{
public:
  FaceGrid(const bsv::ComplexBlock& block, int side)
    : Block(block)
    , Side(side)
    , Cells{ block.cells(0), block.cells(1), block.cells(2) }
    , Counts{ this->Cells[bsv::faceAxis(side, 0)], this->Cells[bsv::faceAxis(side, 1)] }
  {
  }

  /// @return number of the first point
  vtkIdType addPoints(vtkPoints* points) const
  {
    const vtkIdType first = points->GetNumberOfPoints();
    for (int t = 0; t <= this->Counts[1]; ++t)
    {
      for (int s = 0; s <= this->Counts[0]; ++s)
      {
        points->InsertNextPoint(this->Block.points(bsv::facePoint(this->Cells, this->Side, s, t)).data());
      }
    }
    return first;
  }

  /// Calls visit(number, corners), s fastest; counter-clockwise seen from outside of a right-handed block, or, if
  /// `turned`, of a left-handed one.
  template <typename Visit>
  void forQuads(vtkIdType first, bool turned, const Visit& visit) const
  {
    // Ascending axes make s x t the outward normal at the maximum sides of i and k and at the minimum side of j.
    const bool outward = ((bsv::faceDirection(this->Side) == 1) != (bsv::faceSide(this->Side) == 1)) != turned;
    vtkIdType quad = 0;
    for (int t = 0; t < this->Counts[1]; ++t)
    {
      for (int s = 0; s < this->Counts[0]; ++s)
      {
        const vtkIdType p = first + s + vtkIdType(this->Counts[0] + 1) * t;
        const vtkIdType q = p + this->Counts[0] + 1;
        visit(quad++,
          outward ? std::array<vtkIdType, 4>{ p, p + 1, q + 1, q } : std::array<vtkIdType, 4>{ p, q, q + 1, p + 1 });
      }
    }
  }

private:
  const bsv::ComplexBlock& Block;
  int Side;
  bsv::Ijk Cells;
  std::array<int, 2> Counts;
};

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

    const bsv::FaceUse& use = face.uses.front();
    const bsv::ComplexBlock& block = complex.blocks[use.block];
    if (block.rank != rank)
    {
      continue;
    }
    const FaceGrid grid(block, use.face);
    grid.forQuads(grid.addPoints(part.points()), false, [&](vtkIdType, const std::array<vtkIdType, 4>& corners) {
      part.addCell({ corners.begin(), corners.end() });
    });
  }
  return part.build(&vtkPolyData::SetPolys, mostBlocks(complex));
}

template <typename Array>
vtkSmartPointer<Array> namedArray(const char* name)
{
  auto array = vtkSmartPointer<Array>::New();
  array->SetName(name);
  return array;
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

/// The outer quadrilaterals of the blocks of one rank, and what was found of each.
void fillOuterSurface(
  vtkPolyData* output, const bsv::BlockComplex& complex, const bsv::MeshDiagnosis& diagnosis, int rank)
{
  const auto kinds = namedArray<vtkUnsignedCharArray>("Finding");
  const auto ids = namedArray<vtkIntArray>("FindingId");
  const auto blocks = namedArray<vtkIntArray>("BlockId");
  const auto faces = namedArray<vtkIntArray>("FaceId");
  const auto tags = namedArray<vtkIntArray>("BoundaryTag");
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> cells;
  for (std::size_t f = 0; f < complex.faces.size(); ++f)
  {
    const bsv::ComplexFace& face = complex.faces[f];
    const bsv::FaceUse& use = face.uses.front();
    const bsv::ComplexBlock& block = complex.blocks[use.block];
    if (!face.boundary() || block.rank != rank)
    {
      continue;
    }
    const std::vector<int>& findings = diagnosis.findingOfQuad[f];
    const FaceGrid grid(block, use.face);
    const vtkIdType first = grid.addPoints(points);
    grid.forQuads(first, block.leftHanded, [&](vtkIdType quad, const std::array<vtkIdType, 4>& corners) {
      const int finding = findings.empty() ? -1 : findings[quad];
      cells->InsertNextCell(4, corners.data());
      kinds->InsertNextValue(
        static_cast<unsigned char>(finding < 0 ? bsv::MeshFindingKind::None : diagnosis.findings[finding].kind));
      ids->InsertNextValue(finding);
      blocks->InsertNextValue(block.parent);
      faces->InsertNextValue(use.face);
      tags->InsertNextValue(face.tag);
    });
  }
  output->SetPoints(points);
  output->SetPolys(cells);
  for (vtkDataArray* array : std::initializer_list<vtkDataArray*>{ kinds, ids, blocks, faces, tags })
  {
    output->GetCellData()->AddArray(array);
  }
  output->GetCellData()->SetActiveScalars("Finding");
  output->GetFieldData()->AddArray(stringArray("FindingNames", bsv::meshFindingNames()));
}

/// The edges of one rank that creases were chosen from.
void fillCreases(vtkPolyData* output, const std::vector<bsv::TurningEdge>& turning)
{
  const auto kinds = namedArray<vtkUnsignedCharArray>("Crease");
  const std::array<vtkSmartPointer<vtkDoubleArray>, 3> angles{ namedArray<vtkDoubleArray>("Angle"),
    namedArray<vtkDoubleArray>("Nearby"), namedArray<vtkDoubleArray>("BodyAngle") };
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> cells;
  for (const bsv::TurningEdge& edge : turning)
  {
    const vtkIdType first = points->InsertNextPoint(edge.ends[0].data());
    points->InsertNextPoint(edge.ends[1].data());
    cells->InsertNextCell({ first, first + 1 });
    kinds->InsertNextValue(edge.tagged ? 2 : edge.crease ? 1 : edge.borderline ? 3 : 0);
    angles[0]->InsertNextValue(edge.angle);
    angles[1]->InsertNextValue(edge.nearby);
    angles[2]->InsertNextValue(edge.bodyAngle);
  }
  output->SetPoints(points);
  output->SetLines(cells);
  output->GetCellData()->AddArray(kinds);
  for (const auto& angle : angles)
  {
    output->GetCellData()->AddArray(angle);
  }
  output->GetCellData()->SetActiveScalars("Crease");
}

/// @param rows false for the columns alone.
void fillFindings(vtkTable* table, const bsv::BlockMesh& mesh, const bsv::MeshDiagnosis& diagnosis, bool rows)
{
  const auto names = namedArray<vtkStringArray>("Finding");
  const auto suspicious = namedArray<vtkIntArray>("Suspicious");
  const std::array<vtkSmartPointer<vtkIntArray>, 4> places{ namedArray<vtkIntArray>("BlockA"),
    namedArray<vtkIntArray>("FaceA"), namedArray<vtkIntArray>("BlockB"), namedArray<vtkIntArray>("FaceB") };
  const auto quads = namedArray<vtkIdTypeArray>("Quads");
  const std::array<vtkSmartPointer<vtkDoubleArray>, 6> figures{ namedArray<vtkDoubleArray>("Distance"),
    namedArray<vtkDoubleArray>("Fraction"), namedArray<vtkDoubleArray>("GlueTolerance"),
    namedArray<vtkDoubleArray>("X"), namedArray<vtkDoubleArray>("Y"), namedArray<vtkDoubleArray>("Z") };
  const auto texts = namedArray<vtkStringArray>("Description");
  for (std::size_t n = 0; n < diagnosis.findings.size() && rows; ++n)
  {
    const bsv::MeshFinding& finding = diagnosis.findings[n];
    names->InsertNextValue(bsv::meshFindingNames()[static_cast<std::size_t>(finding.kind)]);
    suspicious->InsertNextValue(finding.suspicious());
    for (int p = 0; p < 4; ++p)
    {
      places[p]->InsertNextValue(p % 2 == 0 ? finding.blocks[p / 2] : finding.faces[p / 2]);
    }
    quads->InsertNextValue(finding.quads);
    const std::array<double, 6> values{ finding.distance, finding.fraction, finding.glueTolerance, finding.place[0],
      finding.place[1], finding.place[2] };
    for (int v = 0; v < 6; ++v)
    {
      figures[v]->InsertNextValue(values[v]);
    }
    texts->InsertNextValue(bsv::describe(mesh, finding));
  }
  table->AddColumn(names);
  table->AddColumn(suspicious);
  for (const auto& place : places)
  {
    table->AddColumn(place);
  }
  table->AddColumn(quads);
  for (const auto& figure : figures)
  {
    table->AddColumn(figure);
  }
  table->AddColumn(texts);
}

} // namespace

//------------------------------------------------------------------------------
vtkHexBlockTopology::vtkHexBlockTopology()
{
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(4);
}

//------------------------------------------------------------------------------
void vtkHexBlockTopology::AddBodyBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->BodyBoundaries.emplace_back(pattern);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkHexBlockTopology::ClearBodyBoundaries()
{
  this->BodyBoundaries.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
void vtkHexBlockTopology::SetBodyConnection(vtkAlgorithmOutput* output)
{
  this->SetInputConnection(1, output);
}

//------------------------------------------------------------------------------
int vtkHexBlockTopology::FillOutputPortInformation(int port, vtkInformation* info)
{
  static const char* const types[] = { "vtkPartitionedDataSetCollection", "vtkPolyData", "vtkTable", "vtkPolyData" };
  info->Set(vtkDataObject::DATA_TYPE_NAME(), types[port]);
  return 1;
}

//------------------------------------------------------------------------------
int vtkHexBlockTopology::FillInputPortInformation(int port, vtkInformation* info)
{
  bsv::acceptMissing(info);
  if (port == 1)
  {
    info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
    return 1;
  }
  bsv::acceptMeshes(info);
  return 1;
}

//------------------------------------------------------------------------------
int vtkHexBlockTopology::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataObject* input = vtkDataObject::GetData(inputVector[0], 0);
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector, 0);
  auto* surface = vtkPolyData::GetData(outputVector, 1);
  auto* findings = vtkTable::GetData(outputVector, 2);
  auto* creases = vtkPolyData::GetData(outputVector, 3);
  if (!output || !surface || !findings || !creases)
  {
    vtkErrorMacro("An output is missing.");
    return 0;
  }

  this->NumberOfInputBlocks = this->NumberOfBlocks = 0;
  this->NumberOfVertices = this->NumberOfEdges = this->NumberOfFaces = 0;
  this->NumberOfExtraordinaryEdges = this->NumberOfSingularNodes = 0;
  this->NumberOfComponents = this->NumberOfFindings = this->NumberOfSuspiciousFindings = 0;
  this->Report.clear();

  return bsv::execute(this, [&] {
    bsv::requiredInput(inputVector, 0);
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
    const bsv::Execution run = bsv::filterExecution(this, 0.0, 0.6);
    const int rank = run.ranks->rank();
    const bsv::BlockMesh mesh = bsv::blockMesh(input, grids, run);
    bsv::requireBlocks(mesh);
    bsv::BlockComplexOptions options;
    options.matchTolerance = this->MatchTolerance;
    options.allowDegenerate = this->AllowDegenerate;
    options.creaseAngle = this->UseCreaseAngle ? this->CreaseAngle : 180.0;
    bsv::CreaseRules rules;
    rules.contrast = this->CreaseContrast;
    for (const std::string& name : mesh.boundaryNames)
    {
      rules.bodyTags.push_back(bsv::matchesAny(this->BodyBoundaries, name));
    }
    std::unique_ptr<const bsv::BodySurface> body;
    vtkDataObject* given = vtkDataObject::GetData(inputVector[1], 0);
    if (run.ranks->any(given != nullptr))
    {
      const std::vector<bsv::BodyPatch> patches = bsv::bodyPatches(given, *run.ranks);
      body = std::make_unique<bsv::BodySurface>(patches);
      rules.bodyTurn = [&](const bsv::Vec3& x, double length) { return bsv::bodyTurn(*body, x, length); };
    }
    std::vector<bsv::TurningEdge> turning;
    const bsv::BlockComplex complex = bsv::buildBlockComplex(mesh, options, rules, &turning, run);
    const bsv::EntityClasses classes = bsv::classifyEntities(complex);

    const bsv::MeshDiagnosis diagnosis = bsv::diagnose(complex, bsv::filterExecution(this, 0.6, 0.8));

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
    report << complex.creaseNote << (complex.creaseNote.empty() ? "" : "\n");
    for (const auto& [valence, count] : classes.extraordinaryCurves)
    {
      const int tuple[2] = { valence, static_cast<int>(count) };
      curves->InsertNextTypedTuple(tuple);
      report << count << " extraordinary curves of valence " << valence << '\n';
    }
    std::vector<std::string> warnings = complex.warnings;
    for (const bsv::MeshFinding& finding : diagnosis.findings)
    {
      this->NumberOfSuspiciousFindings += finding.suspicious() ? 1 : 0;
      report << bsv::describe(mesh, finding) << '\n';
    }
    if (diagnosis.suspicious())
    {
      warnings.push_back("blocks do not meet where they seem to be meant to, at " +
        std::to_string(this->NumberOfSuspiciousFindings) +
        (this->NumberOfSuspiciousFindings == 1 ? " place: " : " places, the first: ") +
        bsv::describe(mesh, diagnosis.findings.front()) + ". The table of findings lists all.");
    }
    fillOuterSurface(surface, complex, diagnosis, rank);
    fillFindings(findings, mesh, diagnosis, rank == 0);
    fillCreases(creases, turning);
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
    this->NumberOfComponents = diagnosis.components;
    this->NumberOfFindings = static_cast<int>(diagnosis.findings.size());
    bsv::warn(this, warnings);
    bsv::warn(this,
      bsv::uselessPatterns("Body Boundaries", this->BodyBoundaries, bsv::defaultBodyBoundaries(), complex.boundaryNames,
        complex.boundaryTypes));
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
  os << indent << "CreaseContrast: " << this->CreaseContrast << '\n';
  os << indent << "BodyBoundaries: " << bsv::quotedList(this->BodyBoundaries) << '\n';
  os << indent << "Report: " << this->Report << '\n';
}

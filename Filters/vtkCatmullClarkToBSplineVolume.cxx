// SPDX-License-Identifier: BSD-3-Clause
#include "vtkCatmullClarkToBSplineVolume.h"

#include "Base/MemoryCheck.h"
#include "Body/BodyEdges.h"
#include "Complex/BlockComplex.h"
#include "Complex/CreaseEdges.h"
#include "Complex/EntityClass.h"
#include "Complex/MeshDoctor.h"
#include "Conversion/Conversion.h"
#include "Conversion/JoinedBlocks.h"
#include "Data/BSplineVolumeData.h"
#include "Data/HexBlockData.h"
#include "Data/MeshInput.h"
#include "Data/NURBSSurfaceData.h"
#include "Data/Verdict.h"
#include "Execution/FilterExecution.h"
#include "Ranks/Ranks.h"
#include "Wall/BodyDistance.h"
#include "Wall/BodyFit.h"
#include "Wall/FacesOnBody.h"

#include "vtkDataObject.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkIdTypeArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkStringArray.h"
#include "vtkStructuredGrid.h"
#include "vtkTable.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <tuple>

vtkStandardNewMacro(vtkCatmullClarkToBSplineVolume);

namespace
{

/// Puts whole faces into a boundary of their own.
/// @return its tag
int addBodyFaces(bsv::BlockMesh& mesh, const std::vector<std::array<int, 2>>& faces)
{
  const int tag = static_cast<int>(mesh.boundaryNames.size());
  mesh.boundaryNames.emplace_back("body");
  if (!mesh.boundaryTypes.empty())
  {
    mesh.boundaryTypes.emplace_back("BCWall");
  }
  for (const auto& [block, face] : faces)
  {
    if (block < 0 || block >= static_cast<int>(mesh.blocks.size()) || face < 0 || face > 5)
    {
      throw bsv::Error("Body Faces: there is no face " + std::to_string(face) + " of block " + std::to_string(block) +
        "; the mesh has " + std::to_string(mesh.blocks.size()) + " blocks with the faces 0 to 5");
    }
    mesh.boundaries.erase(std::remove_if(mesh.boundaries.begin(), mesh.boundaries.end(),
                            [block = block, face = face](
                              const bsv::BoundaryPatch& patch) { return patch.block == block && patch.face == face; }),
      mesh.boundaries.end());
    const std::array<int, 3>& counts = mesh.blocks[block].points.counts();
    mesh.boundaries.push_back(
      { block, face, { { 0, 0 }, { counts[bsv::faceAxis(face, 0)] - 1, counts[bsv::faceAxis(face, 1)] - 1 } }, tag });
  }
  return tag;
}

/// "2 faces, 'a' k min; 'b' i max": the first few.
std::string faceList(const bsv::BlockMesh& mesh, const std::vector<std::array<int, 2>>& faces)
{
  static constexpr const char* Sides[6] = { "i min", "i max", "j min", "j max", "k min", "k max" };
  constexpr std::size_t Most = 12;
  std::string text = std::to_string(faces.size()) + (faces.size() == 1 ? " face" : " faces");
  for (std::size_t n = 0; n < std::min(faces.size(), Most); ++n)
  {
    text += (n == 0 ? ", " : "; ") + ("'" + mesh.blocks[faces[n][0]].name + "' ") + Sides[faces[n][1]];
  }
  return text + (faces.size() > Most ? "; ..." : "");
}

/// The control point nearest to mesh point i of a direction, at knot i: point i + 1 with single knots.
int controlPointAt(const std::vector<double>& knots, int cells, int i)
{
  const auto [first, last] = std::equal_range(knots.begin(), knots.end(), static_cast<double>(i));
  const int multiplicity = static_cast<int>(last - first);
  return i == 0  ? 0
    : i == cells ? static_cast<int>(knots.size()) - 5
                 : static_cast<int>(first - knots.begin()) - 3 + (multiplicity + 2) / 2;
}

/// The crease lines of a mesh in the control nets of its converted blocks, which may be pieces of those of the mesh:
/// each piece gets the part that lies in it.
std::vector<bsv::CreaseLine> creasesOfNets(const std::vector<bsv::CreaseLine>& creases,
  const bsv::BlockComplex& complex, const std::vector<std::array<std::vector<double>, 3>>& knots)
{
  std::vector<bsv::CreaseLine> result;
  for (std::size_t b = 0; b < complex.blocks.size(); ++b)
  {
    const bsv::ComplexBlock& block = complex.blocks[b];
    for (const bsv::CreaseLine& crease : creases)
    {
      if (crease.block != block.parent)
      {
        continue;
      }
      bsv::CreaseLine line;
      line.block = static_cast<int>(b);
      bool inside = true;
      bool isLine = false;
      for (int d = 0; d < 3; ++d)
      {
        const int cells = block.cells(d);
        const auto [lower, upper] = std::minmax(crease.from[d], crease.to[d]);
        const int first = std::max(lower - block.offset[d], 0);
        const int last = std::min(upper - block.offset[d], cells);
        inside = inside && first <= last;
        isLine = isLine || first < last;
        line.from[d] = controlPointAt(knots[b][d], cells, first);
        line.to[d] = controlPointAt(knots[b][d], cells, last);
      }
      if (inside && isLine)
      {
        result.push_back(line);
      }
    }
  }
  return result;
}

void addInts(vtkFieldData* fields, const char* name, const std::vector<int>& values)
{
  vtkNew<vtkIntArray> array;
  array->SetName(name);
  for (const int value : values)
  {
    array->InsertNextValue(value);
  }
  fields->AddArray(array);
}

/// Grid for the control points of a block, with everything but their values.
vtkSmartPointer<vtkStructuredGrid> controlNet(
  const bsv::ComplexBlock& block, const std::array<std::vector<double>, 3>& knots, bsv::ControlNetStorage& storage)
{
  auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
  std::array<int, 3> counts{};
  bsv::BSplineVolume volume;
  for (int d = 0; d < 3; ++d)
  {
    volume.knots[d] = knots[d];
    counts[d] = volume.count(d);
  }
  bsv::setDegreeAndKnots(grid, volume);
  addInts(grid->GetFieldData(), "ParentBlock", { block.parent });
  addInts(grid->GetFieldData(), "ParentOffset", { block.offset.begin(), block.offset.end() });

  const vtkIdType size = vtkIdType(counts[0]) * counts[1] * counts[2];
  vtkNew<vtkDoubleArray> coordinates;
  coordinates->SetNumberOfComponents(3);
  coordinates->SetNumberOfTuples(size);
  vtkNew<vtkPoints> points;
  points->SetData(coordinates);
  vtkNew<vtkUnsignedCharArray> rules;
  rules->SetName("ControlPointRule");
  rules->SetNumberOfValues(size);
  grid->SetDimensions(counts.data());
  grid->SetPoints(points);
  grid->GetPointData()->AddArray(rules);
  storage = { coordinates->GetPointer(0), rules->GetPointer(0) };
  return grid;
}

void setContacts(vtkPartitionedDataSetCollection* volume, const bsv::BlockComplex& complex)
{
  std::vector<bsv::Interface> interfaces;
  std::vector<bsv::BoundaryPatch> boundaries;
  for (const bsv::ComplexFace& face : complex.faces)
  {
    const bsv::FaceUse& a = face.uses.front();
    if (!face.boundary())
    {
      const bsv::FaceUse& b = face.uses.back();
      interfaces.push_back({ a.block, a.face, b.block, b.face, face.orientation, {}, {} });
    }
    else if (face.tag >= 0)
    {
      boundaries.push_back({ a.block, a.face, {}, face.tag });
    }
  }
  bsv::setWholeFaceContacts(volume, interfaces, boundaries, complex.boundaryNames, complex.boundaryTypes);
}

std::string triple(const char* separator, int a, int b, int c)
{
  return std::to_string(a) + separator + std::to_string(b) + separator + std::to_string(c);
}

/// What InputPoints means for one mesh and body.
struct WallPoints
{
  bool onBody = false;
  /// Displacements of the wall's points, if they are moved.
  std::optional<bsv::WallFit> fit;
  /// Largest distance of a limit point of the wall from the body, or from its target; and how far points were moved.
  double distance = 0.0;
  double displacement = 0.0;
  /// How it was decided, and what the fit did, one sentence each.
  std::string report;
};

/// Three coordinates and a rule.
constexpr double BytesPerControlPoint = 3 * sizeof(double) + 1;

/// One attempt at the conversion.
struct Conversion
{
  /// With the wall as it was fitted.
  bsv::BlockComplex complex;
  WallPoints wallPoints;
  /// Shares of the displacements of wall points; empty: all 1.
  std::vector<double> shares;
  std::vector<vtkSmartPointer<vtkStructuredGrid>> nets;
  std::vector<std::array<std::vector<double>, 3>> knots;
  bsv::ConversionReport counts;
  bsv::WallMotion motion;
};

/// Joins the pieces that creases alone made. Collective.
void joinBlocks(Conversion& conversion, const std::vector<bsv::ControlNetStorage>& storage, const bsv::Execution& run)
{
  bsv::JoinedBlocks joined = bsv::joinPieces(conversion.complex);
  std::vector<std::array<std::vector<double>, 3>> knots(joined.blocks.size());
  std::vector<vtkSmartPointer<vtkStructuredGrid>> nets(joined.blocks.size());
  bsv::RuleCounts counts{};
  for (std::size_t b = 0; b < nets.size(); ++b)
  {
    run.report(static_cast<double>(b) / static_cast<double>(nets.size()));
    const bsv::JoinedBlock& block = joined.blocks[b];
    for (int d = 0; d < 3; ++d)
    {
      knots[b][d] = bsv::joinedKnots(block, d, conversion.knots);
    }
    if (!conversion.nets[block.pieces[0]])
    {
      continue;
    }
    bsv::ControlNetStorage net = storage[block.pieces[0]];
    if (block.pieces.size() == 1)
    {
      nets[b] = conversion.nets[block.pieces[0]];
    }
    else
    {
      bsv::BSplineVolume volume;
      volume.knots = knots[b];
      const double points = double(volume.count(0)) * volume.count(1) * volume.count(2);
      // Its pieces are there until it is complete.
      bsv::requireMemory(points * BytesPerControlPoint, "the volume", "block " + std::to_string(b) + " as a whole");
      nets[b] = controlNet(joined.complex.blocks[b], knots[b], net);
      bsv::joinNets(block, conversion.knots, storage, net, run);
      for (const int piece : block.pieces)
      {
        conversion.nets[piece] = nullptr;
      }
    }
    for (vtkIdType n = 0; n < nets[b]->GetNumberOfPoints(); ++n)
    {
      ++counts[net.rules[n]];
    }
  }
  conversion.counts.controlPoints = {};
  for (const bsv::RuleCounts& ofRank : run.ranks->gatherAll(std::vector<bsv::RuleCounts>{ counts }))
  {
    for (std::size_t rule = 0; rule < ofRank.size(); ++rule)
    {
      conversion.counts.controlPoints[rule] += ofRank[rule];
    }
  }
  auto& left = conversion.counts.spans.left;
  for (bsv::SpanReport::Place& place : left)
  {
    const bsv::Ijk& offset = conversion.complex.blocks[place.block].offset;
    place.block = joined.blockOf[place.block];
    for (int d = 0; d < 3; ++d)
    {
      place.cell[d] += offset[d] - joined.complex.blocks[place.block].offset[d];
    }
  }
  std::sort(left.begin(), left.end(), [](const bsv::SpanReport::Place& a, const bsv::SpanReport::Place& b) {
    return std::tie(a.block, a.cell[2], a.cell[1], a.cell[0]) < std::tie(b.block, b.cell[2], b.cell[1], b.cell[0]);
  });
  conversion.complex = std::move(joined.complex);
  conversion.nets = std::move(nets);
  conversion.knots = std::move(knots);
}

std::string pointText(const bsv::Vec3& x)
{
  std::ostringstream text;
  text << '(' << x[0] << ", " << x[1] << ", " << x[2] << ')';
  return text.str();
}

/// Decides how the wall's points are taken, and fits its control mesh: all of it if they lie on the body, else along
/// the edges of the body.
WallPoints takeWallPoints(const bsv::BlockComplex& complex, const bsv::ConversionOptions& options,
  const bsv::EntityRules& rules, int inputPoints, const bsv::BoundaryPatterns& patterns, bsv::BodyFitOptions fit,
  const bsv::Execution& run)
{
  using Filter = vtkCatmullClarkToBSplineVolume;
  const bool wall = std::any_of(complex.faces.begin(), complex.faces.end(), [&](const bsv::ComplexFace& face) {
    return face.boundary() && face.tag >= 0 && options.roles[face.tag] == bsv::BoundaryRole::Body;
  });
  if (!wall && (options.body || inputPoints >= Filter::ON_BODY))
  {
    throw bsv::Error(std::string(options.body ? "there is a Body" : "Input Points is OnBody or LeastSquares") +
      ", but no boundary of the mesh is part of it: Body Boundaries are " + bsv::quotedList(patterns) +
      ", the mesh has the boundaries " + bsv::quotedList(complex.boundaryNames) +
      (complex.boundaryNames.empty() && options.body
          ? ", and no block face lies on the Body (is the length unit the same?)"
          : "") +
      "; Body Faces chooses block faces");
  }

  WallPoints result;
  result.onBody = inputPoints >= Filter::ON_BODY;
  fit.leastSquares = inputPoints == Filter::LEAST_SQUARES;
  std::ostringstream text;
  if (options.body)
  {
    const bsv::WallDistances distances = bsv::wallDistances(complex, rules, *options.body, run);
    text << "body of " << options.body->patches().size() << " patches: " << distances.wallPoints
         << " wall points, largest distance of the points " << distances.inputPoints
         << ", of their Catmull-Clark limit points " << distances.limitPoints << '\n';
    result.distance = distances.limitPoints;
    if (inputPoints == Filter::AUTOMATIC)
    {
      result.onBody = distances.inputPoints <= distances.limitPoints;
    }
  }
  text << "input points taken as " << (fit.leastSquares ? "LeastSquares" : result.onBody ? "OnBody" : "ControlNet");
  if (inputPoints == Filter::AUTOMATIC)
  {
    text << ", chosen automatically" << (options.body ? "" : ", as always without a body");
  }
  text << '\n';
  if (result.onBody || options.body)
  {
    fit.edgesOnly = !result.onBody;
    result.fit = bsv::solveFit(complex, options, rules, fit, run);
    const bsv::BodyFitReport& report = result.fit->report;
    result.distance = result.onBody ? report.residual : result.distance;
    result.displacement = report.displacement;
    text << (result.onBody ? "wall" : "creases and borders of the wall") << " fitted in " << report.iterations
         << " iterations: limit points within " << report.residual << " of their targets, before "
         << report.initialResidual << "; wall points moved by up to " << report.displacement << '\n';
    if (fit.leastSquares)
    {
      text << "between its mesh points the wall is off the body by at most " << report.sampleDistance[1] << ", RMS "
           << report.sampleRms[1] << "; before " << report.sampleDistance[0] << ", RMS " << report.sampleRms[0] << '\n';
    }
    const bsv::Index blunt = result.onBody ? bsv::bluntPoints(complex, rules, *run.ranks) : 0;
    if (blunt > 0)
    {
      text << "wall cells differ by more than 4 : 1 across a bend of more than 45 degrees at " << blunt
           << " wall points: interpolation overshoots there, a crease (Crease Angle 30 to 50) does not\n";
    }
  }
  result.report = text.str();
  return result;
}

/// How far the converted wall is from the mesh.
std::string motionText(const bsv::WallMotion& motion, bool onBody)
{
  std::ostringstream text;
  if (motion.wallPoints > 0)
  {
    text << "converted wall off its " << motion.wallPoints << " mesh points by at most " << motion.largest << ", at "
         << pointText(motion.where) << ", median " << motion.median << "; in first cells at most "
         << motion.largestInCells << ", median " << motion.medianInCells;
    text << (!onBody && motion.largestInCells > 1.0 ? "; if these are points of the wall, take Input Points OnBody\n"
                                                    : "\n");
  }
  return text.str();
}

/// What the fit gave up for valid spans.
std::string shareText(const std::vector<double>& shares)
{
  std::ostringstream text;
  const auto held = std::count_if(shares.begin(), shares.end(), [](double share) { return share < 1.0; });
  if (held > 0)
  {
    text << "wall fitted in part only for valid spans at " << held << " of " << shares.size()
         << " points, the least share of a displacement " << *std::min_element(shares.begin(), shares.end()) << '\n';
  }
  return text.str();
}

std::string reportText(const bsv::BlockComplex& complex, const bsv::EntityClasses& classes,
  const bsv::ConversionOptions& options, const WallPoints& wallPoints, const bsv::ConversionReport& counts,
  const std::vector<std::array<std::vector<double>, 3>>& knots)
{
  std::ostringstream text;
  bsv::Index total = 0;
  for (const bsv::Index count : counts.controlPoints)
  {
    total += count;
  }
  text << complex.blocks.size() << " blocks, " << total << " control points, " << classes.extraordinaryEdges
       << " extraordinary edges, " << counts.singularNodes << " singular nodes, " << counts.planarFaces
       << " planar sides\n";
  for (const std::vector<std::string>* notes : { &complex.notes, &counts.notes })
  {
    for (const std::string& note : *notes)
    {
      text << note << '\n';
    }
  }
  text << complex.creaseNote << (complex.creaseNote.empty() ? "" : "\n");
  text << wallPoints.report;
  for (const auto& [valence, count] : classes.extraordinaryCurves)
  {
    text << count << " extraordinary curves of valence " << valence << '\n';
  }

  std::vector<int> faces(complex.boundaryNames.size(), 0);
  int unnamed = 0;
  for (const bsv::ComplexFace& face : complex.faces)
  {
    if (face.boundary())
    {
      ++(face.tag < 0 ? unnamed : faces[face.tag]);
    }
  }
  bool body = false;
  for (std::size_t tag = 0; tag < faces.size(); ++tag)
  {
    static const char* const roles[] = { "far field or other boundary", "body", "symmetry plane" };
    const bsv::BoundaryRole role = options.roles[tag];
    body = body || (role == bsv::BoundaryRole::Body && faces[tag] > 0);
    text << complex.boundaryNames[tag] << ": " << roles[static_cast<int>(role)] << ", " << faces[tag] << " faces\n";
  }
  if (unnamed > 0)
  {
    text << unnamed << " boundary faces without a name\n";
  }
  if (!body)
  {
    text << "no body\n";
  }

  if (body && counts.wallSpacing[0] != counts.wallSpacing[1])
  {
    text << "wall spacing c from " << counts.wallSpacing[0] << " to " << counts.wallSpacing[1] << '\n';
  }
  if (!counts.extensionDistances.empty())
  {
    text << "planar sides with a far-field extension: " << counts.extensionDistances.size()
         << ", its first layer at the distance";
    for (const double distance : counts.extensionDistances)
    {
      text << ' ' << distance;
    }
    if (counts.limitedDistances > 0)
    {
      text << "; cut to 2/3 of a thinner first cell at " << counts.limitedDistances << " points";
    }
    text << '\n';
  }

  for (std::size_t rule = 0; rule < counts.controlPoints.size(); ++rule)
  {
    if (counts.controlPoints[rule] > 0)
    {
      text << bsv::controlPointRuleNames()[rule] << ": " << counts.controlPoints[rule] << " control points\n";
    }
  }
  if (options.continuity == bsv::Continuity::ExactG1)
  {
    const bsv::G1Report& g1 = counts.g1;
    text << (g1.givenUpLayers > 0
                ? std::to_string(g1.givenUpLayers) + " layers keep their kinks: spans next to them would not be valid\n"
                : std::string())
         << "exact G1 at " << g1.edges << " extraordinary edges in " << g1.layers << " layers of control points, "
         << g1.skippedLayers << " layers near singular nodes and creases stay as they are; "
         << g1.fittedVertices + g1.linearVertices << " extraordinary vertices of the wall, " << g1.fittedVertices
         << " of them fitted to the body\n";
  }
  for (std::size_t b = 0; b < complex.blocks.size(); ++b)
  {
    const bsv::ComplexBlock& block = complex.blocks[b];
    const auto points = [&](int d) { return static_cast<int>(knots[b][d].size()) - 4; };
    text << block.name << ": " << triple(" x ", block.cells(0), block.cells(1), block.cells(2)) << " cells, "
         << triple(" x ", points(0), points(1), points(2)) << " control points, from block " << block.parent
         << " at point " << triple(", ", block.offset[0], block.offset[1], block.offset[2]) << '\n';
  }
  return text.str();
}

/// What became of the checked spans.
std::string spanText(
  const bsv::BlockComplex& complex, const bsv::ConversionOptions& options, const bsv::SpanReport& spans)
{
  const bool all = options.checkSpans == bsv::CheckSpans::All || options.untangle;
  if (options.checkSpans == bsv::CheckSpans::None && !all)
  {
    return "no spans were checked\n";
  }
  std::ostringstream text;
  text << spans.checked << (all ? " spans" : " spans near special rules") << " checked, " << spans.failed
       << " not proven valid, " << spans.repaired << " of them repaired, " << spans.invalid << " spans left invalid, "
       << spans.undecided << " undecided\n";
  if (spans.movedPoints > 0)
  {
    text << "span repair: " << spans.movedPoints << " mesh points moved by up to " << spans.largestMove << " ("
         << spans.largestMoveInCells << " cells), " << spans.sweeps << " sweeps\n";
  }
  if (spans.invalidCells > 0)
  {
    text << spans.invalidCells << " more spans are not valid, nor are their mesh cells\n";
  }
  constexpr std::size_t Listed = 20;
  for (std::size_t i = 0; i < std::min(Listed, spans.left.size()); ++i)
  {
    const bsv::SpanReport::Place& place = spans.left[i];
    text << "span not valid: " << complex.blocks[place.block].name << ", cell "
         << triple(", ", place.cell[0], place.cell[1], place.cell[2]) << '\n';
  }
  if (spans.left.size() > Listed)
  {
    text << "and " << spans.left.size() - Listed << " more\n";
  }
  return text.str();
}

/// Of the converted wall. Collective.
bsv::BodyDistance wallDistance(const Conversion& conversion, const bsv::ConversionOptions& options,
  const bsv::BodySurface& body, const bsv::Execution& run)
{
  std::vector<bsv::BSplineVolume> volumes(conversion.nets.size());
  std::vector<bsv::VolumeFace> faces;
  for (const bsv::ComplexFace& face : conversion.complex.faces)
  {
    const bsv::FaceUse& use = face.uses.front();
    vtkStructuredGrid* net = conversion.nets[use.block];
    if (net && bsv::roleOf(options, face) == bsv::BoundaryRole::Body)
    {
      bsv::BSplineVolume& volume = volumes[use.block];
      volume.knots = conversion.knots[use.block];
      volume.points = vtkDoubleArray::SafeDownCast(net->GetPoints()->GetData())->GetPointer(0);
      faces.push_back({ &volume, use.face });
    }
  }
  return bsv::bodyDistance(faces, body, run);
}

/// How close the wall is to the body.
std::vector<std::string> wallSentences(const WallPoints& wall, bool hasBody, const bsv::BodyDistance& distance)
{
  if (!hasBody)
  {
    return { wall.onBody ? "Wall: within " + bsv::shortNumber(wall.distance) + " of the mesh points"
                         : "Wall: no body given" };
  }
  std::string text = "Wall: within " + bsv::shortNumber(distance.largest) + " of the body";
  if (distance.inEdges > 0.0)
  {
    text += ", " + bsv::shortNumber(100.0 * distance.inEdges) + " % of an edge";
  }
  if (distance.largest > 0.0)
  {
    text += " at";
    for (const double x : distance.where)
    {
      text += ' ' + bsv::shortNumber(x);
    }
  }
  std::vector<std::string> sentences{ text };
  if (wall.displacement > 0.0)
  {
    sentences.push_back("Wall points: moved by at most " + bsv::shortNumber(wall.displacement));
  }
  return sentences;
}

/// What each of several ranks had to do.
std::string rankText(const bsv::BlockComplex& complex, const std::vector<bsv::Index>& received)
{
  std::ostringstream text;
  for (std::size_t r = 0; received.size() > 1 && r < received.size(); ++r)
  {
    bsv::Index blocks = 0, points = 0;
    for (const bsv::ComplexBlock& block : complex.blocks)
    {
      if (block.rank == static_cast<int>(r))
      {
        ++blocks;
        points += block.points.size();
      }
    }
    text << "rank " << r << ": " << blocks << " blocks, " << points << " mesh points, received " << received[r]
         << " bytes from other ranks\n";
  }
  return text.str();
}

/// The boundaries that are switched on and off by name are no part of what is compared before: ranks without a block
/// may not know the names.
void requireSameRoles(
  const std::vector<bsv::BoundaryRole>& roles, const std::vector<std::string>& names, const bsv::Ranks& ranks)
{
  const std::vector<std::vector<bsv::BoundaryRole>> all = ranks.gather(roles);
  for (std::size_t r = 1; r < all.size(); ++r)
  {
    const auto at = std::mismatch(all[0].begin(), all[0].end(), all[r].begin(), all[r].end()).first;
    if (at != all[0].end())
    {
      throw bsv::Error("Body Boundaries or Symmetry Boundaries: '" + names[at - all[0].begin()] +
        "' is chosen on rank 0 or on rank " + std::to_string(r) + ", but not on both");
    }
  }
}

} // namespace

//------------------------------------------------------------------------------
vtkCatmullClarkToBSplineVolume::vtkCatmullClarkToBSplineVolume()
  : ControlPointsPerRule(vtkSmartPointer<vtkIdTypeArray>::New())
{
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(2);
  this->ResetReport();
}

//------------------------------------------------------------------------------
vtkCatmullClarkToBSplineVolume::~vtkCatmullClarkToBSplineVolume() = default;

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::ResetReport()
{
  this->NumberOfInputBlocks = this->NumberOfBlocks = 0;
  this->NumberOfExtraordinaryEdges = this->NumberOfSingularNodes = 0;
  this->NumberOfControlPoints = 0;
  this->NumberOfCheckedSpans = this->NumberOfRepairedSpans = 0;
  this->NumberOfInvalidSpans = this->NumberOfUndecidedSpans = 0;
  this->ReceivedBytes = 0;
  this->ControlPointsPerRule->SetNumberOfValues(static_cast<vtkIdType>(bsv::ControlPointRule::Count));
  this->ControlPointsPerRule->Fill(0);
  this->Report.clear();
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::AddBodyBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->BodyBoundaries.emplace_back(pattern);
    this->BodySelection.forget();
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::ClearBodyBoundaries()
{
  this->BodyBoundaries.clear();
  this->BodySelection.forget();
  this->Modified();
}

//------------------------------------------------------------------------------
const char* vtkCatmullClarkToBSplineVolume::GetBodyBoundary(int index) const
{
  return index >= 0 && index < this->GetNumberOfBodyBoundaries() ? this->BodyBoundaries[index].c_str() : nullptr;
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::AddSymmetryBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->SymmetryBoundaries.emplace_back(pattern);
    this->SymmetrySelection.forget();
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::ClearSymmetryBoundaries()
{
  this->SymmetryBoundaries.clear();
  this->SymmetrySelection.forget();
  this->Modified();
}

//------------------------------------------------------------------------------
const char* vtkCatmullClarkToBSplineVolume::GetSymmetryBoundary(int index) const
{
  return index >= 0 && index < this->GetNumberOfSymmetryBoundaries() ? this->SymmetryBoundaries[index].c_str()
                                                                     : nullptr;
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::AddBoundaryWallSpacing(const char* pattern, double spacing)
{
  if (pattern && *pattern)
  {
    this->BoundaryWallSpacings.emplace_back(pattern, spacing);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::ClearBoundaryWallSpacings()
{
  this->BoundaryWallSpacings.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::AddExtensionBlock(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->ExtensionBlocks.emplace_back(pattern);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::ClearExtensionBlocks()
{
  this->ExtensionBlocks.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::AddBodyFace(int block, int face)
{
  this->BodyFaces.push_back({ block, face });
  this->Modified();
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::ClearBodyFaces()
{
  this->BodyFaces.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
vtkDataArray* vtkCatmullClarkToBSplineVolume::GetControlPointsPerRule()
{
  return this->ControlPointsPerRule;
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::SetBodyConnection(vtkAlgorithmOutput* output)
{
  this->SetInputConnection(1, output);
}

//------------------------------------------------------------------------------
int vtkCatmullClarkToBSplineVolume::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMissing(info);
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkUnstructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkCatmullClarkToBSplineVolume::FillOutputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), port == 0 ? "vtkPartitionedDataSetCollection" : "vtkTable");
  return 1;
}

//------------------------------------------------------------------------------
int vtkCatmullClarkToBSplineVolume::RequestInformation(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector*)
{
  vtkDataObject* mesh = vtkDataObject::GetData(inputVector[0], 0);
  this->BodySelection.offer(mesh, this->BodyBoundaries, bsv::defaultBodyBoundaries());
  this->SymmetrySelection.offer(mesh, this->SymmetryBoundaries, bsv::defaultSymmetryBoundaries());
  return 1;
}

//------------------------------------------------------------------------------
/// One execution: what the inputs and the properties say, and the steps of the work.
class vtkCatmullClarkToBSplineVolume::Request
{
public:
  explicit Request(vtkCatmullClarkToBSplineVolume& self)
    : Self(self)
    , Whole(bsv::filterExecution(&self))
    , Ranks(*Whole.ranks)
  {
  }

  void operator()(vtkDataObject* input, vtkDataObject* body, vtkPartitionedDataSetCollection* output, vtkTable* verdict)
  {
    this->readMesh(input);
    if (this->Mesh.blocks.empty())
    {
      return;
    }
    this->readBody(body);
    this->setOptions();
    Conversion result;
    const double end = this->Self.CheckJoins ? 0.8 : 1.0;
    this->convert(result, 0.1, end);
    const std::string creaseText = this->tryCreases(result, end);
    const std::vector<bsv::Index> received =
      this->Ranks.gatherAll(std::vector<bsv::Index>{ this->Ranks.receivedBytes() });
    this->fillOutput(output, result);
    const bsv::EntityClasses classes = bsv::classifyEntities(result.complex);
    this->setCounts(result, classes);
    this->Self.ReceivedBytes = received[this->Ranks.rank()];
    std::string text;
    for (const std::string& line : this->verdictLines(output, result))
    {
      text += line + '\n';
    }
    bsv::setText(verdict, text.substr(0, text.size() - 1));
    const bsv::BlockComplex& complex = result.complex;
    const bsv::ConversionReport& counts = result.counts;
    this->Self.Report = text + reportText(complex, classes, this->Options, result.wallPoints, counts, result.knots) +
      (creaseText.empty() ? "" : creaseText + '\n') + shareText(result.shares) +
      motionText(result.motion, result.wallPoints.onBody) + spanText(complex, this->Options, counts.spans) +
      rankText(complex, received);
    this->warn(result, creaseText);
  }

private:
  /// A part of the progress, and one count of what the ranks receive.
  bsv::Execution execution(double first, double last) const
  {
    bsv::Execution run = bsv::filterExecution(&this->Self, first, last);
    run.ranks = this->Whole.ranks;
    return run;
  }

  void readMesh(vtkDataObject* input)
  {
    this->Mesh = bsv::blockMesh(input, this->MeshGrids, bsv::filterExecution(&this->Self, 0.0, 0.3));
    if (this->Mesh.blocks.empty())
    {
      return;
    }
    bsv::requireMesh(this->MeshGrids, this->Ranks, "only meshes are converted");

    double controlPoints = 0.0;
    for (const bsv::MeshBlock& block : this->Mesh.blocks)
    {
      const bsv::Ijk& counts = block.points.counts();
      controlPoints += block.points.isHere() ? (counts[0] + 2.0) * (counts[1] + 2.0) * (counts[2] + 2.0) : 0.0;
    }
    bsv::requireMemory(controlPoints * BytesPerControlPoint, "the volume", "its control points");
  }

  void readBody(vtkDataObject* given)
  {
    if (this->Ranks.any(given != nullptr))
    {
      const std::vector<bsv::BodyPatch> patches = bsv::bodyPatches(given, this->Ranks);
      bsv::Execution alone = this->execution(0.0, 0.1);
      alone.ranks = bsv::aloneRank();
      this->Body = std::make_unique<bsv::BodySurface>(patches, alone);
    }

    // Without names the body tells which faces are its wall.
    this->Found = this->Body && this->Self.BodyFaces.empty() && this->Mesh.boundaryNames.empty()
      ? bsv::facesOnBody(this->Mesh, *this->Body, this->execution(0.1, 0.1))
      : std::vector<std::array<int, 2>>();
    const std::vector<std::array<int, 2>>& bodyFaces = this->Found.empty() ? this->Self.BodyFaces : this->Found;
    this->Selected = bodyFaces.empty() ? -1 : addBodyFaces(this->Mesh, bodyFaces);
  }

  void setOptions()
  {
    this->Options.body = this->Body.get();
    const auto surfaceArray = [&](std::size_t b, const char* name, int components) -> const double* {
      if (!this->MeshGrids[b])
      {
        return nullptr;
      }
      this->SurfaceData.push_back(
        bsv::doublePointArray(this->MeshGrids[b], name, components, this->Mesh.blocks[b].name));
      return this->SurfaceData.back() ? this->SurfaceData.back()->GetPointer(0) : nullptr;
    };
    for (std::size_t b = 0; b < this->Mesh.blocks.size(); ++b)
    {
      this->Options.projectedPoints.push_back(surfaceArray(b, "ProjectedPoint", 3));
      this->Options.surfaceNormals.push_back(surfaceArray(b, "SurfaceNormal", 3));
      this->Options.wallSpacingPoints.push_back(
        this->Self.WallSpacingArray.empty() ? nullptr : surfaceArray(b, this->Self.WallSpacingArray.c_str(), 1));
    }
    this->Ranks.nextStep();
    for (std::size_t b = 0; b < this->Mesh.blocks.size() && !this->Self.ExtensionBlocks.empty(); ++b)
    {
      this->Options.extensionBlocks.push_back(bsv::matchesAny(this->Self.ExtensionBlocks, this->Mesh.blocks[b].name));
    }
    if (!this->Self.ExtensionBlocks.empty() &&
      std::find(this->Options.extensionBlocks.begin(), this->Options.extensionBlocks.end(), true) ==
        this->Options.extensionBlocks.end())
    {
      throw bsv::Error("Extension Blocks are " + bsv::quotedList(this->Self.ExtensionBlocks) +
        ", but no block of the mesh has such a name; the first one is '" + this->Mesh.blocks[0].name + "'");
    }
    this->setComplexOptions();

    this->Options.planarSides = static_cast<bsv::PlanarSides>(this->Self.PlanarSides);
    this->Options.planarTolerance = this->Self.PlanarTolerance;
    this->Options.twist = static_cast<bsv::Twist>(this->Self.Twist);
    this->Options.wallSpacing = this->Self.WallSpacing;
    this->Options.automaticWallSpacing = this->Self.WallSpacingMode == AUTOMATIC_MODE;
    this->Options.farFieldSpacing = static_cast<bsv::FarFieldSpacing>(this->Self.FarFieldSpacing);
    this->Options.propagationRange = this->Self.PropagationRange;
    this->Options.checkSpans = static_cast<bsv::CheckSpans>(this->Self.CheckSpans);
    this->Options.untangle = this->Self.Untangle;

    this->Fit.body = this->Options.body;
    this->Fit.tolerance = this->Self.FitTolerance;
    this->Fit.iterations = this->Self.FitIterations;
    this->Fit.range = this->Self.PropagationRange;
  }

  void setComplexOptions()
  {
    this->ComplexOptions.matchTolerance = this->Self.MatchTolerance;
    this->ComplexOptions.allowDegenerate = this->Self.AllowDegenerate;
    this->ComplexOptions.creaseAngle = this->Self.UseCreaseAngle ? this->Self.CreaseAngle : 180.0;
    this->Creases.contrast = this->Self.CreaseContrast;
    for (std::size_t tag = 0; tag < this->Mesh.boundaryNames.size(); ++tag)
    {
      this->Creases.bodyTags.push_back(static_cast<int>(tag) == this->Selected ||
        bsv::matchesAny(this->Self.BodyBoundaries, this->Mesh.boundaryNames[tag]));
    }
    if (this->Body)
    {
      this->Creases.bodyTurn = [&](const bsv::Vec3& x, double length) { return bsv::bodyTurn(*this->Body, x, length); };
    }
  }

  /// One attempt.
  void convert(Conversion& result, double first, double last)
  {
    const auto part = [&](double from, double to) {
      return this->execution(first + from * (last - first), first + to * (last - first));
    };
    bsv::BlockComplex& complex = result.complex;
    complex = this->complexOfMesh(part(0.0, 0.38), part(0.38, 0.42));
    this->setRoles(complex);
    const bsv::EntityRules rules = bsv::classify(complex, this->Options, part(0.42, 0.42));
    result.wallPoints = takeWallPoints(
      complex, this->Options, rules, this->Self.InputPoints, this->Self.BodyBoundaries, this->Fit, part(0.42, 0.55));

    // Control nets of blocks on other ranks stay null.
    std::vector<bsv::ControlNetStorage> storage(complex.blocks.size());
    result.nets.resize(complex.blocks.size());
    result.knots = bsv::conversionKnots(complex, this->Options);
    for (std::size_t b = 0; b < complex.blocks.size(); ++b)
    {
      if (complex.blocks[b].rank == this->Ranks.rank())
      {
        result.nets[b] = controlNet(complex.blocks[b], result.knots[b], storage[b]);
      }
    }
    // The wall may fold over its layers if it is followed exactly: shares of the displacements are lowered above
    // failing spans until these are valid. What exact joins change comes after that.
    const auto convert = [&](bool repair, bool singleKnots) {
      bsv::ConversionOptions chosen = this->Options;
      chosen.repairSpans = repair;
      if (singleKnots)
      {
        chosen.setSingleKnots();
      }
      result.counts = bsv::convertToBSplineVolume(complex, chosen, storage, part(0.55, 1.0), &rules);
    };
    const bsv::BlockComplex unfitted = complex;
    const auto fitted = [&] {
      complex = unfitted;
      if (result.wallPoints.fit)
      {
        bsv::applyFit(complex, rules, *result.wallPoints.fit, result.shares, part(0.55, 0.55));
      }
    };
    fitted();
    const bool rounds = result.wallPoints.onBody && this->Self.RepairSpans && this->Self.CheckSpans != CHECK_NONE;
    const auto& left = result.counts.spans.left;
    if (rounds)
    {
      constexpr int MaxRounds = 30;
      convert(false, true);
      for (int round = 0; round <= MaxRounds && !left.empty(); ++round)
      {
        if (!bsv::lowerShares(
              unfitted, rules, *result.wallPoints.fit, left, round < MaxRounds ? 0.9 : 0.0, result.shares, this->Ranks))
        {
          break;
        }
        fitted();
        convert(false, true);
      }
    }
    if (!rounds || !left.empty() || this->Options.continuity != bsv::Continuity::SingleKnots)
    {
      convert(this->Self.RepairSpans, false);
    }
    result.motion = bsv::wallMotion(unfitted, complex, this->Options, rules, part(1.0, 1.0));
    if (this->Self.CreasesInsideBlocks == REPEATED_KNOTS)
    {
      joinBlocks(result, storage, part(1.0, 1.0));
    }
  }

  bsv::BlockComplex complexOfMesh(const bsv::Execution& building, const bsv::Execution& checking) const
  {
    bsv::BlockComplex complex =
      bsv::buildBlockComplex(this->Mesh, this->ComplexOptions, this->Creases, nullptr, building);
    const bsv::MeshDiagnosis diagnosis = bsv::diagnose(complex, checking);
    if (!this->Self.AllowOpenInterior)
    {
      bsv::refuseSuspicious(this->Mesh, diagnosis);
    }
    if (!this->Found.empty())
    {
      complex.notes.push_back("wall found by the body: " + faceList(this->Mesh, this->Found));
    }
    for (const bsv::MeshFinding& finding : diagnosis.findings)
    {
      (finding.suspicious() ? complex.warnings : complex.notes).push_back(bsv::describe(this->Mesh, finding));
    }
    return complex;
  }

  /// Roles and wall spacings of the boundaries.
  void setRoles(const bsv::BlockComplex& complex)
  {
    this->Options.roles = bsv::boundaryRoles(complex, this->Self.BodyBoundaries, this->Self.SymmetryBoundaries);
    for (std::size_t tag = 0; tag < this->Options.roles.size(); ++tag)
    {
      const std::string& name = complex.boundaryNames[tag];
      bsv::BoundaryRole& role = this->Options.roles[tag];
      role = this->Self.BodySelection.has(name, role == bsv::BoundaryRole::Body)      ? bsv::BoundaryRole::Body
        : this->Self.SymmetrySelection.has(name, role == bsv::BoundaryRole::Symmetry) ? bsv::BoundaryRole::Symmetry
                                                                                      : bsv::BoundaryRole::Other;
    }
    requireSameRoles(this->Options.roles, complex.boundaryNames, this->Ranks);
    if (this->Selected >= 0)
    {
      this->Options.roles[this->Selected] = bsv::BoundaryRole::Body;
    }
    this->Options.boundaryWallSpacing.clear();
    for (const std::string& name : complex.boundaryNames)
    {
      const auto spacing = std::find_if(this->Self.BoundaryWallSpacings.begin(), this->Self.BoundaryWallSpacings.end(),
        [&](const auto& entry) { return bsv::matchesAny({ entry.first }, name); });
      this->Options.boundaryWallSpacing.push_back(
        spacing == this->Self.BoundaryWallSpacings.end() ? std::numeric_limits<double>::quiet_NaN() : spacing->second);
    }
    this->Options.continuity = static_cast<bsv::Continuity>(this->Self.Continuity);
  }

  /// A sharp edge, taken as smooth, can be rounded by more than the layers above it are thick. No point inside mends
  /// that; a crease does.
  /// @return what was done, empty if nothing.
  std::string tryCreases(Conversion& result, double end)
  {
    std::string creaseText;
    if (this->Self.RepairSpans && !this->Self.UseCreaseAngle && !result.counts.spans.left.empty())
    {
      this->ComplexOptions.creaseAngle = this->Self.CreaseAngle;
      Conversion other;
      bool converted = true;
      try
      {
        this->Ranks.together([&] { this->convert(other, end, end); });
      }
      catch (const bsv::Aborted&)
      {
        throw;
      }
      catch (const bsv::Error&)
      {
        converted = false;
      }
      if (converted && other.counts.spans.left.size() < result.counts.spans.left.size())
      {
        creaseText = "without creases " + std::to_string(result.counts.spans.left.size()) +
          " spans are not valid: boundary edges that turn by more than " + bsv::shortNumber(this->Self.CreaseAngle) +
          " degrees (Crease Angle, Crease Contrast) were taken as creases, " +
          std::to_string(other.counts.spans.left.size()) + " such spans are left; " +
          std::to_string(result.complex.blocks.size()) + " blocks became " +
          std::to_string(other.complex.blocks.size());
        result = std::move(other);
      }
    }
    return creaseText;
  }

  void fillOutput(vtkPartitionedDataSetCollection* output, const Conversion& result) const
  {
    const bsv::BlockComplex& complex = result.complex;
    std::vector<std::string> names;
    for (const bsv::ComplexBlock& block : complex.blocks)
    {
      names.push_back(block.name);
    }
    bsv::setBlocks(output, result.nets, names, "BSplineVolume");
    setContacts(output, complex);
    // The pipeline passes on that of the input, in mesh points of blocks that may have been cut.
    bsv::setCreases(output->GetFieldData(), creasesOfNets(this->Mesh.creases, complex, result.knots));
    vtkNew<vtkStringArray> ruleNames;
    ruleNames->SetName("ControlPointRuleNames");
    for (const std::string& name : bsv::controlPointRuleNames())
    {
      ruleNames->InsertNextValue(name);
    }
    output->GetFieldData()->AddArray(ruleNames);
    vtkNew<vtkIntArray> roles;
    roles->SetName("BoundaryRoles");
    for (std::size_t tag = 0; tag < complex.boundaryNames.size(); ++tag)
    {
      roles->InsertNextValue(static_cast<int>(this->Options.roles[tag]));
    }
    output->GetFieldData()->AddArray(roles);
  }

  /// What the panel shows.
  void setCounts(const Conversion& result, const bsv::EntityClasses& classes)
  {
    const bsv::ConversionReport& counts = result.counts;
    this->Self.NumberOfInputBlocks = static_cast<int>(this->Mesh.blocks.size());
    this->Self.NumberOfBlocks = static_cast<int>(result.complex.blocks.size());
    this->Self.NumberOfExtraordinaryEdges = static_cast<int>(classes.extraordinaryEdges);
    this->Self.NumberOfSingularNodes = static_cast<int>(counts.singularNodes);
    for (std::size_t rule = 0; rule < counts.controlPoints.size(); ++rule)
    {
      this->Self.ControlPointsPerRule->SetValue(static_cast<vtkIdType>(rule), counts.controlPoints[rule]);
      this->Self.NumberOfControlPoints += counts.controlPoints[rule];
    }
    this->Self.NumberOfCheckedSpans = counts.spans.checked;
    this->Self.NumberOfRepairedSpans = counts.spans.repaired;
    this->Self.NumberOfInvalidSpans = counts.spans.invalid;
    this->Self.NumberOfUndecidedSpans = counts.spans.undecided;
  }

  std::vector<std::string> verdictLines(vtkPartitionedDataSetCollection* output, const Conversion& result) const
  {
    const bsv::ConversionReport& counts = result.counts;
    std::vector<bool> wall;
    for (std::size_t tag = 0; tag < result.complex.boundaryNames.size(); ++tag)
    {
      wall.push_back(this->Options.roles[tag] == bsv::BoundaryRole::Body);
    }
    std::vector<std::string> lines;
    if (this->Self.CheckJoins)
    {
      lines = bsv::joinSentences(bsv::joinVerdict(output, wall, this->execution(0.8, 1.0)));
    }
    else
    {
      lines.emplace_back("Watertight: blocks share their control points; joins not measured (Check Joins)");
    }
    // At knots and between them: interpolation can overshoot where spacing changes.
    for (std::string& sentence : wallSentences(result.wallPoints, this->Options.body != nullptr,
           this->Options.body ? wallDistance(result, this->Options, *this->Options.body, this->execution(0.8, 0.8))
                              : bsv::BodyDistance{}))
    {
      lines.push_back(std::move(sentence));
    }
    if (counts.spans.checked > 0)
    {
      const bsv::Index bad = counts.spans.invalid + counts.spans.invalidCells;
      lines.push_back("Spans: " + std::to_string(counts.spans.checked) + " checked, " +
        (bad + counts.spans.undecided == 0
            ? std::string("all valid")
            : std::to_string(bad) + " invalid, " + std::to_string(counts.spans.undecided) + " undecided"));
    }
    else
    {
      lines.emplace_back("Spans: not checked (Check Spans)");
    }
    if (result.complex.tangledCells > 0)
    {
      lines.push_back("Borderline: " + std::to_string(result.complex.tangledCells) + " tangled cells in the mesh");
    }
    return lines;
  }

  void warn(const Conversion& result, const std::string& creaseText) const
  {
    const bsv::BlockComplex& complex = result.complex;
    const bsv::ConversionReport& counts = result.counts;
    std::vector<std::string> warnings = complex.warnings;
    if (!creaseText.empty())
    {
      warnings.push_back(creaseText);
    }
    if (!counts.spans.left.empty())
    {
      const bsv::SpanReport::Place& first = counts.spans.left.front();
      warnings.push_back(std::to_string(counts.spans.left.size()) +
        " spans are not valid although their mesh cells are, the first in block '" + complex.blocks[first.block].name +
        "', cell (" + triple(", ", first.cell[0], first.cell[1], first.cell[2]) + "); see the report");
    }
    bsv::warn(&this->Self, warnings);
    bsv::warn(&this->Self,
      bsv::uselessPatterns("Body Boundaries", this->Self.BodyBoundaries, bsv::defaultBodyBoundaries(),
        complex.boundaryNames, complex.boundaryTypes));
    bsv::warn(&this->Self,
      bsv::uselessPatterns("Symmetry Boundaries", this->Self.SymmetryBoundaries, bsv::defaultSymmetryBoundaries(),
        complex.boundaryNames, complex.boundaryTypes));
    for (const auto& entry : this->Self.BoundaryWallSpacings)
    {
      bsv::warn(&this->Self,
        bsv::uselessPatterns(
          "Boundary Wall Spacing", { entry.first }, {}, complex.boundaryNames, complex.boundaryTypes));
    }
  }

  vtkCatmullClarkToBSplineVolume& Self;
  const bsv::Execution Whole;
  const bsv::Ranks& Ranks;

  std::vector<vtkSmartPointer<vtkStructuredGrid>> MeshGrids;
  bsv::BlockMesh Mesh;
  std::unique_ptr<const bsv::BodySurface> Body;
  /// Block faces on the body, where no name tells the wall.
  std::vector<std::array<int, 2>> Found;
  /// Tag of the boundary that consists of chosen faces, or -1.
  int Selected = -1;
  /// The arrays that the options point to.
  std::vector<vtkSmartPointer<vtkDoubleArray>> SurfaceData;
  bsv::ConversionOptions Options;
  bsv::BlockComplexOptions ComplexOptions;
  bsv::CreaseRules Creases;
  bsv::BodyFitOptions Fit;
};

//------------------------------------------------------------------------------
int vtkCatmullClarkToBSplineVolume::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataObject* input = vtkDataObject::GetData(inputVector[0], 0);
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector, 0);
  auto* verdict = vtkTable::GetData(outputVector, 1);
  if (!output || !verdict)
  {
    vtkErrorMacro("An output is missing.");
    return 0;
  }
  this->ResetReport();
  bsv::setText(verdict, "");

  return bsv::execute(this, [&] {
    bsv::requiredInput(inputVector, 0);
    Request request(*this);
    request(input, vtkDataObject::GetData(inputVector[1], 0), output, verdict);
  });
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  const auto list = [&](const char* name, const std::vector<std::string>& values) {
    os << indent << name << ':';
    for (const std::string& value : values)
    {
      os << ' ' << value;
    }
    os << '\n';
  };
  list("BodyBoundaries", this->BodyBoundaries);
  list("SymmetryBoundaries", this->SymmetryBoundaries);
  os << indent << "BodyFaces:";
  for (const auto& [block, face] : this->BodyFaces)
  {
    os << " (" << block << ", " << face << ')';
  }
  os << '\n';
  os << indent << "UseCreaseAngle: " << (this->UseCreaseAngle ? "On" : "Off") << '\n';
  os << indent << "CreaseAngle: " << this->CreaseAngle << '\n';
  os << indent << "CreaseContrast: " << this->CreaseContrast << '\n';
  os << indent << "CreasesInsideBlocks: " << this->CreasesInsideBlocks << '\n';
  os << indent << "PlanarSides: " << this->PlanarSides << '\n';
  os << indent << "PlanarTolerance: " << this->PlanarTolerance << '\n';
  os << indent << "Twist: " << this->Twist << '\n';
  os << indent << "Continuity: " << this->Continuity << '\n';
  os << indent << "WallSpacing: " << this->WallSpacing << '\n';
  os << indent << "WallSpacingMode: " << this->WallSpacingMode << '\n';
  os << indent << "BoundaryWallSpacings:";
  for (const auto& [pattern, spacing] : this->BoundaryWallSpacings)
  {
    os << ' ' << pattern << '=' << spacing;
  }
  os << '\n';
  os << indent << "WallSpacingArray: " << this->WallSpacingArray << '\n';
  os << indent << "FarFieldSpacing: " << this->FarFieldSpacing << '\n';
  list("ExtensionBlocks", this->ExtensionBlocks);
  os << indent << "PropagationRange: " << this->PropagationRange << '\n';
  os << indent << "CheckSpans: " << this->CheckSpans << '\n';
  os << indent << "RepairSpans: " << (this->RepairSpans ? "On" : "Off") << '\n';
  os << indent << "Untangle: " << (this->Untangle ? "On" : "Off") << '\n';
  os << indent << "InputPoints: " << this->InputPoints << '\n';
  os << indent << "FitTolerance: " << this->FitTolerance << '\n';
  os << indent << "FitIterations: " << this->FitIterations << '\n';
  os << indent << "MatchTolerance: " << this->MatchTolerance << '\n';
  os << indent << "AllowDegenerate: " << (this->AllowDegenerate ? "On" : "Off") << '\n';
  os << indent << "CheckJoins: " << (this->CheckJoins ? "On" : "Off") << '\n';
  os << indent << "AllowOpenInterior: " << (this->AllowOpenInterior ? "On" : "Off") << '\n';
  os << indent << "ReceivedBytes: " << this->ReceivedBytes << '\n';
  os << indent << "Report: " << this->Report << '\n';
}

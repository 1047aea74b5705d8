// SPDX-License-Identifier: BSD-3-Clause
// One execution of the filter.
#include "vtkCatmullClarkToBSplineVolume.h"

#include "Base/MemoryCheck.h"
#include "Body/BodyEdges.h"
#include "Complex/CreaseEdges.h"
#include "Complex/MeshDoctor.h"
#include "Data/BSplineVolumeData.h"
#include "Data/ConversionResult.h"
#include "Data/HexBlockData.h"
#include "Data/MeshInput.h"
#include "Data/NURBSSurfaceData.h"
#include "Data/Verdict.h"
#include "Execution/FilterExecution.h"
#include "Ranks/Ranks.h"
#include "Wall/FacesOnBody.h"

#include "vtkDataObject.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkIdTypeArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkStringArray.h"
#include "vtkTable.h"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <sstream>

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
    this->readBody(body);
    this->setOptions();
    bsv::ConvertedMesh result;
    const double end = this->Self.CheckJoins ? 0.8 : 1.0;
    this->convert(result, 0.1, end);
    const std::string creaseText = this->tryCreases(result, end);
    const std::vector<bsv::Index> received =
      this->Ranks.gatherAll(std::vector<bsv::Index>{ this->Ranks.receivedBytes() });
    this->fillOutput(output, result);
    const bsv::EntityClasses classes = bsv::classifyEntities(result.complex);
    this->setCounts(result, classes);
    this->Self.ReceivedBytes = received[this->Ranks.rank()];
    const bsv::BodyDistance distance = this->Options.body
      ? bsv::wallDistance(result, this->Options, *this->Options.body, this->execution(end, end))
      : bsv::BodyDistance{};
    std::string text;
    for (const std::string& line : this->verdictLines(output, result, distance))
    {
      text += line + '\n';
    }
    bsv::setText(verdict, text.substr(0, text.size() - 1));
    const bsv::BlockComplex& complex = result.complex;
    const bsv::ConversionReport& counts = result.counts;
    this->Self.Report = text +
      bsv::reportText(complex, classes, this->Options, result.wallPoints, counts, result.knots) +
      (creaseText.empty() ? "" : creaseText + '\n') + bsv::shareText(result.shares) +
      bsv::motionText(result.motion, result.wallPoints.onBody) + bsv::spanText(complex, this->Options, counts.spans) +
      bsv::rankText(complex, received);
    this->warn(result, distance, creaseText);
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
    bsv::requireBlocks(this->Mesh);
    bsv::requireMesh(this->MeshGrids, this->Ranks, "only meshes are converted");

    double controlPoints = 0.0;
    for (const bsv::MeshBlock& block : this->Mesh.blocks)
    {
      const bsv::Ijk& counts = block.points.counts();
      controlPoints += block.points.isHere() ? (counts[0] + 2.0) * (counts[1] + 2.0) * (counts[2] + 2.0) : 0.0;
    }
    bsv::requireMemory(controlPoints * bsv::BytesPerControlPoint, "the volume", "its control points");
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
  void convert(bsv::ConvertedMesh& result, double first, double last)
  {
    const auto part = [&](double from, double to) {
      return this->execution(first + from * (last - first), first + to * (last - first));
    };
    bsv::BlockComplex& complex = result.complex;
    complex = this->complexOfMesh(part(0.0, 0.38), part(0.38, 0.42));
    this->setRoles(complex);
    const bsv::EntityRules rules = bsv::classify(complex, this->Options, part(0.42, 0.42));
    result.wallPoints = bsv::takeWallPoints(
      complex, this->Options, rules, this->Self.InputPoints, this->Self.BodyBoundaries, this->Fit, part(0.42, 0.55));

    // Control nets of blocks on other ranks stay null.
    std::vector<bsv::ControlNetStorage> storage(complex.blocks.size());
    result.nets.resize(complex.blocks.size());
    result.knots = bsv::conversionKnots(complex, this->Options);
    for (std::size_t b = 0; b < complex.blocks.size(); ++b)
    {
      if (complex.blocks[b].rank == this->Ranks.rank())
      {
        result.nets[b] = bsv::controlNet(complex.blocks[b], result.knots[b], storage[b]);
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
      bsv::joinBlocks(result, storage, part(1.0, 1.0));
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
  std::string tryCreases(bsv::ConvertedMesh& result, double end)
  {
    std::string creaseText;
    if (this->Self.RepairSpans && !this->Self.UseCreaseAngle && !result.counts.spans.left.empty())
    {
      this->ComplexOptions.creaseAngle = this->Self.CreaseAngle;
      bsv::ConvertedMesh other;
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

  void fillOutput(vtkPartitionedDataSetCollection* output, const bsv::ConvertedMesh& result) const
  {
    const bsv::BlockComplex& complex = result.complex;
    std::vector<std::string> names;
    for (const bsv::ComplexBlock& block : complex.blocks)
    {
      names.push_back(block.name);
    }
    bsv::setBlocks(output, result.nets, names, "BSplineVolume");
    bsv::setContacts(output, complex);
    // The pipeline passes on that of the input, in mesh points of blocks that may have been cut.
    bsv::setCreases(output->GetFieldData(), bsv::creasesOfNets(this->Mesh.creases, complex, result.knots));
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
  void setCounts(const bsv::ConvertedMesh& result, const bsv::EntityClasses& classes)
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

  /// @param distance of the wall from the body at knots and between them: interpolation can overshoot where spacing
  /// changes
  std::vector<std::string> verdictLines(
    vtkPartitionedDataSetCollection* output, const bsv::ConvertedMesh& result, const bsv::BodyDistance& distance) const
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
    for (std::string& sentence : bsv::wallSentences(result.wallPoints, this->Options.body != nullptr, distance))
    {
      lines.push_back(std::move(sentence));
    }
    if (counts.spans.checked > 0)
    {
      const bsv::Index invalid = counts.spans.invalid + counts.spans.invalidCells - counts.spans.undecidedCells;
      const bsv::Index undecided = counts.spans.undecided + counts.spans.undecidedCells;
      lines.push_back("Spans: " + std::to_string(counts.spans.checked) + " checked, " +
        (invalid + undecided == 0 ? std::string("all valid")
                                  : std::to_string(invalid) + " invalid, " + std::to_string(undecided) + " undecided"));
    }
    else
    {
      lines.emplace_back(this->Options.checkSpans == bsv::CheckSpans::None
          ? "Spans: not checked (Check Spans)"
          : "Spans: none are near special rules, others were not checked (Check Spans)");
    }
    if (result.complex.tangledCells > 0)
    {
      lines.push_back("Borderline: " + std::to_string(result.complex.tangledCells) + " tangled cells in the mesh");
    }
    return lines;
  }

  void warn(const bsv::ConvertedMesh& result, const bsv::BodyDistance& distance, const std::string& creaseText) const
  {
    const bsv::BlockComplex& complex = result.complex;
    const bsv::ConversionReport& counts = result.counts;
    std::vector<std::string> warnings = complex.warnings;
    // Beyond what coarse cells leave between their points.
    constexpr double MostEdges = 0.5;
    if (distance.inEdges > MostEdges)
    {
      std::ostringstream text;
      text.precision(4);
      text << "the wall is off the body by up to " << distance.largest << ", " << 100.0 * distance.inEdges
           << " % of a span's side, at " << distance.where.transpose()
           << ": the mesh does not fit this body there; is the body moved, or of another size or version?";
      warnings.push_back(text.str());
    }
    if (!creaseText.empty())
    {
      warnings.push_back(creaseText);
    }
    if (!counts.spans.left.empty())
    {
      const bsv::SpanReport::Place& first = counts.spans.left.front();
      warnings.push_back(std::to_string(counts.spans.left.size()) +
        (this->Options.untangle ? " spans are not valid" : " spans are not valid although their mesh cells are") +
        ", the first in block '" + complex.blocks[first.block].name + "', cell (" +
        bsv::triple(", ", first.cell[0], first.cell[1], first.cell[2]) + "); see the report");
    }
    bsv::warn(&this->Self, warnings);
    bsv::warn(&this->Self,
      bsv::uselessPatterns("Body Boundaries", this->Self.BodyBoundaries, bsv::defaultBodyBoundaries(),
        complex.boundaryNames, complex.boundaryTypes));
    bsv::warn(&this->Self,
      bsv::uselessPatterns("Symmetry Boundaries", this->Self.SymmetryBoundaries, bsv::defaultSymmetryBoundaries(),
        complex.boundaryNames, complex.boundaryTypes));
    bsv::warn(&this->Self, this->Self.BodySelection.unknown("Walls", complex.boundaryNames));
    bsv::warn(&this->Self, this->Self.SymmetrySelection.unknown("Symmetry Planes", complex.boundaryNames));
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

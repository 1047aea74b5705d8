// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/BaseComplex.h"

#include "Base/ProgressPart.h"
#include "Complex/HexDecomposition.h"
#include "Complex/HexNumbering.h"

namespace bsv
{

BaseComplex HexDecomposition::decompose()
{
  this->Neighbours = findNeighbours(this->Mesh, this->Options.neighbours, progressPart(this->Run, 0.0, 0.5));
  this->Result.notes = std::move(this->Neighbours.notes);
  this->Result.warnings = std::move(this->Neighbours.warnings);
  const std::size_t faces = 6 * static_cast<std::size_t>(this->Mesh.cellCount());
  this->Separating = std::make_unique<std::atomic<std::uint8_t>[]>(faces);
  for (std::size_t face = 0; face < faces; ++face)
  {
    this->Separating[face].store(0, std::memory_order_relaxed);
  }
  this->findSingularEdges();
  this->Run.report(0.6);
  for (HexId face = 0; face < faces; ++face)
  {
    if (this->separates(face))
    {
      this->Front.push_back(face);
    }
  }
  this->spread();
  this->Run.report(0.65);
  this->flood();
  this->openClosedRegions();
  this->Run.report(0.75);
  this->makeBlocks();
  if (this->Options.mergeBlocks)
  {
    this->mergeBlocks();
  }
  this->Run.report(0.9);
  this->makeContacts();
  this->tell();
  this->Run.report(1.0);
  return std::move(this->Result);
}

void HexDecomposition::tell()
{
  const Index blocks = static_cast<Index>(this->Result.blocks.size());
  const Index cells = this->Mesh.cellCount();
  // A block of a few cells per direction leaves little to a spline.
  constexpr Index FewCells = 64;
  if (blocks > 1 && cells < FewCells * blocks)
  {
    this->Result.warnings.push_back("The mesh of " + std::to_string(cells) + " cells has " + std::to_string(blocks) +
      " blocks, " + text(static_cast<double>(cells) / blocks) +
      " cells each on average: it has little block structure, and splines gain little from it.");
  }
  if (this->Result.closedRegions > 0)
  {
    this->Result.notes.push_back(
      std::to_string(this->Result.closedRegions) + " regions closed on themselves and were cut.");
  }
}

BaseComplex baseComplex(HexMesh& mesh, const BaseComplexOptions& options, const Execution& run)
{
  if (!(options.neighbours.matchTolerance >= 0.0 && options.neighbours.matchTolerance < 0.5))
  {
    throw Error("Match Tolerance " + text(options.neighbours.matchTolerance) + " is not in [0, 0.5)");
  }
  if (!(options.featureAngle >= 0.0 && options.featureAngle <= 180.0))
  {
    throw Error("Feature Angle " + text(options.featureAngle) + " is not between 0 and 180 degrees");
  }
  if (mesh.cellCount() > MostHexCells)
  {
    throw Error(
      "the mesh has " + std::to_string(mesh.cellCount()) + " cells, more than " + std::to_string(MostHexCells));
  }
  if (mesh.cellCount() == 0)
  {
    return {};
  }
  if (!isScattered(mesh))
  {
    return HexDecomposition(mesh, options, run).decompose();
  }
  HexNumbering numbering(mesh, progressPart(run, 0.0, 0.2));
  BaseComplex result = HexDecomposition(numbering.mesh(), options, progressPart(run, 0.2, 1.0)).decompose();
  numbering.restore(result.blocks, run);
  return result;
}

} // namespace bsv

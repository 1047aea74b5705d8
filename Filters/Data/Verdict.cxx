// SPDX-License-Identifier: BSD-3-Clause
#include "Data/Verdict.h"

#include "Data/BSplineVolumeData.h"
#include "Quality/JoinClass.h"
#include "Volume/VolumeInterfaces.h"

#include <vtkNew.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

#include <sstream>

namespace bsv
{

//------------------------------------------------------------------------------
std::string shortNumber(double value)
{
  std::ostringstream text;
  text.precision(3);
  text << value;
  return text.str();
}

//------------------------------------------------------------------------------
JoinVerdict joinVerdict(vtkDataObject* volume, const std::vector<bool>& wall, const Execution& run)
{
  const BSplineVolumeBlocks blocks = bsplineVolumeBlocks(volume, *run.ranks);
  JoinVerdict verdict;
  if (blocks.volumes.empty())
  {
    return verdict;
  }
  std::vector<bool> wallFaces(6 * blocks.volumes.size(), false);
  for (const BoundaryPatch& patch : blocks.boundaries)
  {
    wallFaces[6 * std::size_t(patch.block) + patch.face] = wall[patch.tag];
  }
  SmoothnessOptions options;
  options.samplesPerSpan = 1;
  options.isWall = [&](int block, int face) { return wallFaces[6 * std::size_t(block) + face]; };
  options.rules = blocks.rules;
  options.blockName = [&](int block) { return blocks.label(block); };
  const SmoothnessResult result = measureSmoothness(blocks.volumes, blocks.interfaces, options, run);
  verdict.interfaces = static_cast<Index>(blocks.interfaces.size());
  for (const int n : rankedByClass(result))
  {
    const Join& join = result.joins[n];
    const ClassifiedJoin classified = classifyJoin(join);
    verdict.open += join.continuity == JoinContinuity::Open ? 1 : 0;
    verdict.expected += classified.of == JoinClass::Expected ? 1 : 0;
    verdict.gap = std::max(verdict.gap, join.worst[static_cast<int>(JumpKind::Gap)].value);
    if (classified.of == JoinClass::Defect && ++verdict.defects == 1)
    {
      const JumpMaximum& jump = join.worst[static_cast<int>(join.rankedBy())];
      const bool isGap = join.rankedBy() == JumpKind::Gap;
      verdict.worst = shortNumber(jump.value) + (isGap ? " wide" : " degrees") + " at " + shortNumber(jump.point[0]) +
        ' ' + shortNumber(jump.point[1]) + ' ' + shortNumber(jump.point[2]) + ", " + blocksText(join, blocks.names);
    }
  }
  run.report(1.0);
  return verdict;
}

//------------------------------------------------------------------------------
std::vector<std::string> joinSentences(const JoinVerdict& joins)
{
  std::vector<std::string> lines;
  lines.push_back(joins.open == 0 ? "Watertight: " + std::to_string(joins.interfaces) + " interfaces without a gap"
                                  : "Not watertight: " + std::to_string(joins.open) + " of " +
        std::to_string(joins.interfaces) + " interfaces are open, by up to " + shortNumber(joins.gap));
  lines.push_back(joins.defects == 0
      ? std::string("Joins: none rougher than expected")
      : "Joins: " + std::to_string(joins.defects) + " rougher than expected, the worst by " + joins.worst);
  return lines;
}

//------------------------------------------------------------------------------
void setText(vtkTable* table, const std::string& text)
{
  vtkNew<vtkStringArray> column;
  column->SetName("Text");
  column->InsertNextValue(text);
  table->Initialize();
  table->AddColumn(column);
}

} // namespace bsv

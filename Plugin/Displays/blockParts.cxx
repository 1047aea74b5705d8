// SPDX-License-Identifier: BSD-3-Clause
#include "blockParts.h"

#include "blockPartsModel.h"

#include "vtkDataObjectTreeIterator.h"
#include "vtkFieldData.h"

namespace bsv
{

namespace
{

/// Whether the first block that is here has knots; on all ranks.
bool isVolume(vtkDataObject* input, const Ranks& ranks)
{
  bool here = false;
  const auto look = [&](vtkDataObject* leaf) {
    here = here || (leaf && leaf->GetFieldData()->HasArray("KnotsU") && leaf->GetFieldData()->HasArray("KnotsW"));
  };
  if (auto* tree = vtkDataObjectTree::SafeDownCast(input))
  {
    auto leaves = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
    leaves->VisitOnlyLeavesOn();
    leaves->TraverseSubTreeOn();
    for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal() && !here; leaves->GoToNextItem())
    {
      look(leaves->GetCurrentDataObject());
    }
  }
  else
  {
    look(input);
  }
  return ranks.any(here);
}

} // namespace

vtkSmartPointer<vtkDataObjectTree> withLeaves(
  vtkDataObjectTree* tree, const std::function<vtkSmartPointer<vtkPolyData>(vtkDataObject*)>& surfaceOf)
{
  auto result = vtkSmartPointer<vtkDataObjectTree>::Take(tree->NewInstance());
  result->CopyStructure(tree);
  auto leaves = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  leaves->VisitOnlyLeavesOn();
  leaves->TraverseSubTreeOn();
  for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem())
  {
    if (const vtkSmartPointer<vtkPolyData> surface = surfaceOf(leaves->GetCurrentDataObject()))
    {
      result->SetDataSetFrom(leaves, surface);
    }
  }
  return result;
}

BlockParts blockParts(vtkDataObject* input, const BlockPartsOptions& options, const Execution& run)
{
  BlockParts parts;
  try
  {
    run.ranks->together([&] {
      parts.isVolume = isVolume(input, *run.ranks);
      if (isComplex(input, *run.ranks))
      {
        complexParts(parts, input, options, run);
      }
      else if (parts.isVolume)
      {
        volumeParts(parts, input, options, run);
      }
      else
      {
        meshParts(parts, input, options, run);
      }
    });
  }
  catch (const Error&)
  {
    // Said by those who read or convert it.
    parts.surfaces = nullptr;
  }
  if (!parts.surfaces)
  {
    parts.surfaces = treeOf(input, {}, {});
  }
  for (auto* lines : { &parts.nets, &parts.curves })
  {
    if (!*lines)
    {
      *lines = vtkSmartPointer<vtkPolyData>::New();
    }
  }
  return parts;
}

} // namespace bsv

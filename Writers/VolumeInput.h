// SPDX-License-Identifier: BSD-3-Clause
/// @file VolumeInput.h
/// What the writers of volumes and of their walls are given.
#pragma once

#include "Data/BSplineVolumeData.h"
#include "Formats/MeshToWrite.h"
#include "Formats/VolumeToWrite.h"
#include "Volume/VolumeInterfaces.h"

#include <vtkDataObject.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkFieldData.h>
#include <vtkSmartPointer.h>

namespace bsv
{

/// Whether any leaf of the input has the knots of a surface (KnotsU, KnotsV), or those of a volume (KnotsW as well).
inline bool hasKnots(vtkDataObject* input, bool ofVolume)
{
  const auto test = [=](vtkDataObject* leaf) {
    vtkFieldData* fields = leaf ? leaf->GetFieldData() : nullptr;
    return fields && fields->HasArray("KnotsV") && (fields->HasArray("KnotsW") != 0) == ofVolume;
  };
  auto* tree = vtkDataObjectTree::SafeDownCast(input);
  if (!tree)
  {
    return test(input);
  }
  const auto leaves = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  leaves->VisitOnlyLeavesOn();
  for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem())
  {
    if (test(leaves->GetCurrentDataObject()))
    {
      return true;
    }
  }
  return false;
}

/// Whether the input is a body of NURBS surfaces.
inline bool isSurface(vtkDataObject* input)
{
  return hasKnots(input, false);
}

/// Whether it is a B-spline volume.
inline bool isVolume(vtkDataObject* input)
{
  return hasKnots(input, true);
}

/// How contacts of these blocks are found; for as long as the blocks are there.
inline VolumeInterfaceOptions contactSearch(const BSplineVolumeBlocks& blocks)
{
  VolumeInterfaceOptions options;
  options.boundaries = blocks.boundaries;
  options.blockName = [&](int block) { return blocks.label(block); };
  return options;
}

/// A volume, with interfaces found where it has none. Collective.
inline VolumeToWrite volumeToWrite(const BSplineVolumeBlocks& blocks, const Execution& run)
{
  VolumeToWrite volume;
  volume.volumes = blocks.volumes;
  volume.names = blocks.names;
  for (std::size_t b = 0; b < blocks.volumes.size(); ++b)
  {
    volume.parents.push_back(static_cast<int>(b));
  }
  volume.interfaces = blocks.interfaces;
  volume.boundaries = blocks.boundaries;
  volume.boundaryNames = blocks.boundaryNames;
  volume.boundaryTypes = completeTypes(blocks.boundaryNames, blocks.boundaryTypes);
  if (!blocks.hasInterfaces)
  {
    volume.interfaces = findVolumeInterfaces(blocks.volumes, contactSearch(blocks), run);
  }
  completeVolume(volume, run);
  return volume;
}

} // namespace bsv

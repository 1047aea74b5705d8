// SPDX-License-Identifier: BSD-3-Clause
/// @file Verdict.h
/// What users ask of a result first, in a few lines: for the head of a report and as a text in the view.
#pragma once

#include "BSplineVolumeFiltersModule.h"

#include "Base/Types.h"

#include <string>
#include <vector>

class vtkDataObject;
class vtkTable;

namespace bsv
{

/// How the blocks of a volume join (Quality/JoinClass.h).
struct JoinVerdict
{
  Index interfaces = 0;
  Index open = 0;
  Index defects = 0;
  Index expected = 0;
  /// Largest gap of all joins, in the length unit of the volume.
  double gap = 0.0;
  /// Of the worst defect: kink or gap, "1.2 degrees at x y z, block / block"; a bar would begin a column in VTK's
  /// texts.
  std::string worst;
};

/// Measures it at the corners of the spans and refines the maxima. Collective.
/// @param wall whether a boundary is part of the wall, by its index
BSPLINEVOLUMEFILTERS_EXPORT JoinVerdict joinVerdict(
  vtkDataObject* volume, const std::vector<bool>& wall, const Execution& run);

/// One sentence: watertight or not, and the worst of the joins.
BSPLINEVOLUMEFILTERS_EXPORT std::vector<std::string> joinSentences(const JoinVerdict& joins);

/// A number with three digits.
BSPLINEVOLUMEFILTERS_EXPORT std::string shortNumber(double value);

/// Makes `table` what ParaView shows as a text: one row, one column `Text`.
BSPLINEVOLUMEFILTERS_EXPORT void setText(vtkTable* table, const std::string& text);

} // namespace bsv

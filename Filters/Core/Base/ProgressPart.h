// SPDX-License-Identifier: BSD-3-Clause
/// @file ProgressPart.h
/// Progress of one step among several.
#pragma once

#include "Base/Types.h"

namespace bsv
{

/// The same execution for a step whose progress runs from `from` to `to`, fractions of that of all steps.
inline Execution progressPart(const Execution& run, double from, double to)
{
  Execution result = run;
  result.progress = [progress = run.progress, from, to](
                      double fraction) { return progress(from + fraction * (to - from)); };
  return result;
}

} // namespace bsv

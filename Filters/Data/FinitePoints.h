// SPDX-License-Identifier: BSD-3-Clause
/// @file FinitePoints.h
/// Points of VTK data sets that the core does not look at.
#pragma once

#include "Base/Types.h"

#include <vtkDataSet.h>

#include <cmath>
#include <sstream>
#include <string>

namespace bsv
{

/// @throws Error, beginning with `name`, for the first point whose coordinates are not finite.
inline void requireFinitePoints(vtkDataSet* data, const std::string& name, const Execution& run = {})
{
  // The exception of the lowest range is that of the first point.
  run.parallelFor(data->GetNumberOfPoints(), 1 << 14, [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      double x[3];
      data->GetPoint(n, x);
      if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
      {
        std::ostringstream text;
        text << name << ", point " << n << ": coordinates (" << x[0] << ", " << x[1] << ", " << x[2]
             << ") are not finite";
        throw Error(text.str());
      }
    }
  });
}

} // namespace bsv

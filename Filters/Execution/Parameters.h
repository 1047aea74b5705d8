// SPDX-License-Identifier: BSD-3-Clause
/// @file Parameters.h
/// What must be the same on all ranks before an algorithm begins.
#pragma once

#include "BSplineVolumeFiltersModule.h"

#include <string>

class vtkAlgorithm;

namespace bsv
{

/// Number of connections per input port and properties of `algorithm`, a line for each: what its PrintSelf() adds to
/// that of vtkAlgorithm. So a class must print all its properties, no address, and no result of an earlier run.
BSPLINEVOLUMEFILTERS_EXPORT std::string parametersOf(vtkAlgorithm* algorithm);

/// @throws Error if a number among these properties is not finite, with its label.
BSPLINEVOLUMEFILTERS_EXPORT void requireFiniteParameters(vtkAlgorithm* algorithm);

} // namespace bsv

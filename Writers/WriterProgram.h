// SPDX-License-Identifier: BSD-3-Clause
/// @file WriterProgram.h
/// The program in which libraries write files for another process (LibraryFile.h).
#pragma once

#include "BSplineVolumeWritersModule.h"

namespace bsv
{

/// The whole of it: does what comes from standard input. @return its exit code
BSPLINEVOLUMEWRITERS_EXPORT int writerProgram(int argumentCount, char** arguments);

} // namespace bsv

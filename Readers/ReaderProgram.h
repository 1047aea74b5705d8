// SPDX-License-Identifier: BSD-3-Clause
/// @file ReaderProgram.h
/// The program that reads files for another process (ReaderJobs.h).
#pragma once

#include "BSplineVolumeReadersModule.h"

namespace bsv
{

/// The whole of it: reads the file that its arguments name. @return its exit code
BSPLINEVOLUMEREADERS_EXPORT int readerProgram(int argumentCount, char** arguments);

} // namespace bsv

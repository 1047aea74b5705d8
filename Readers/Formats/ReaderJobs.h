// SPDX-License-Identifier: BSD-3-Clause
/// @file ReaderJobs.h
/// What is read with third-party libraries, CGNS and OpenCASCADE, in a process of its own (ChildProcess.h): that of the
/// program `BSplineVolumeReadFile`, which lies beside this library. Where it is missing, the same is done here, and a
/// warning says so.
#pragma once

#include "Formats/CGNSZones.h"
#include "Formats/NURBSFile.h"

#include <string>

namespace bsv
{

/// loadCGNS() in another process. The points are in memory that both share.
CGNSZones loadCGNSApart(const std::string& fileName, const Execution& run, const Piece& piece, int step = 0);

/// loadCGNSTimes() in another process.
std::vector<double> loadCGNSTimesApart(const std::string& fileName);

/// readCADFile() in another process.
NURBSFileContent readCADFileApart(
  const std::string& fileName, const std::string& format, double tolerance, const Execution& run);

} // namespace bsv

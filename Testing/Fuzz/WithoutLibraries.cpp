// SPDX-License-Identifier: BSD-3-Clause
// What the parsers leave to other libraries is not fuzzed here.
#include "Formats/ReaderJobs.h"

namespace bsv
{

NURBSFileContent readCADFileApart(const std::string& fileName, const std::string&, double, const Execution&)
{
  throw Error(fileName + ": not read");
}

} // namespace bsv

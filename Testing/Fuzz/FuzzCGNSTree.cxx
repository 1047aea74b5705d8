// SPDX-License-Identifier: BSD-3-Clause
// The look at the nodes of a CGNS file, before the CGNS library reads it.
#include "FuzzSupport.h"

#include "Formats/CGNSTree.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  fuzz::parse([&] { bsv::checkCGNSTree(fuzz::fileWith(data, size)); });
  return 0;
}

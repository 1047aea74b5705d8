// SPDX-License-Identifier: BSD-3-Clause
// The look at the nodes of a CGNS file, before the CGNS library reads it.
#include "FuzzSupport.h"

#include "Formats/CGNSTree.h"

/// In the program that reads files for the plugin an assertion of the library is one error; here it would end the run.
extern "C" void __assert_fail(const char* assertion, const char*, unsigned int, const char*)
{
  throw bsv::Error(assertion);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  fuzz::parse([&] { bsv::checkCGNSTree(fuzz::fileWith(data, size)); });
  return 0;
}

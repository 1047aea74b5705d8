// SPDX-License-Identifier: BSD-3-Clause
// GoTools g2: surfaces and volumes.
#include "FuzzSupport.h"

#include "Formats/BSplineVolumeFile.h"
#include "Formats/G2File.h"
#include "Formats/NURBSFile.h"

BSV_FUZZ_WORDS("100", "200", "210", "700", "200 1 0 0\n3 0", "700 1 0 0\n3 1", "2 2\n0 0 1 1", "4 4\n0 0 0 0 1 1 1 1")

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::parse([&] { bsv::parseG2(text, "input"); });
  fuzz::parse([&] { bsv::parseG2Volumes(text, "input"); });
  bsv::hasG2Class(text, bsv::G2Volume);
  return 0;
}

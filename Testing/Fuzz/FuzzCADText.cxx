// SPDX-License-Identifier: BSD-3-Clause
// The look at the text of IGES, STEP and BREP files before OpenCASCADE.
#include "FuzzSupport.h"

#include "Formats/CADText.h"
#include "Formats/NURBSFile.h"

BSV_FUZZ_WORDS("#1", "#2", "#99", "ADVANCED_FACE", "CURVE_STYLE", "SHAPE_REPRESENTATION", "'text'", "/* */", "(#1,#2)",
  "END-ISO-10303-21;", "#7=PLANE('',#8);", "      1D      1", "Locations ", "Curve2ds ", "TShapes ", "*", "+1 0")

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::parse([&] { bsv::checkSTEPText(text, "input"); });
  fuzz::parse([&] { bsv::checkIGESText(text, "input"); });
  fuzz::parse([&] { bsv::checkBREPText(text, "input"); });
  for (const char* format : { "STEP", "IGES", "BREP" })
  {
    bsv::plainCADText(text, format);
  }
  bsv::formatOfNURBSFile(fuzz::fileWith(data, size));
  return 0;
}

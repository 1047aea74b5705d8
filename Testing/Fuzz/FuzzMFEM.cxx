// SPDX-License-Identifier: BSD-3-Clause
// MFEM NURBS meshes.
#include "FuzzSupport.h"

#include "Formats/BSplineVolumeFile.h"

BSV_FUZZ_WORDS("dimension", "elements", "boundary", "edges", "vertices", "patches", "knotvectors", "controlpoints",
  "controlpoints_cartesian", "weights", "FiniteElementSpace", "FiniteElementCollection: NURBS2", "VDim: 3",
  "Ordering: 1", "MFEM NURBS mesh v1.0", "MFEM NURBS mesh v1.1", "#", "1 5 0 1 2 3 4 5 6 7", "1 3 0 1 2 3",
  "unitweights")

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::parse([&] { bsv::parseMFEMMesh(text, "input"); });
  return 0;
}

// SPDX-License-Identifier: BSD-3-Clause
// Quadflow cases (.qfmb).
#include "FuzzSupport.h"

#include "Quadflow/QuadflowFormat.h"

BSV_FUZZ_WORDS("QFMB 1.0", "QFBSP 1.0", "dimension 3", "index_base 1", "knots unit", "knots integer", "cp_order ijk",
  "counts vertices 8 edges 12 faces 6 blocks 1", "VERTICES", "EDGES", "FACES", "BLOCKS", "CONNECTIVITY", "BOUNDARY",
  "BCTABLE", "GEOMETRY", "binary little_endian", "binary big_endian", "file input", "end", "block 0", "type BSPLINE",
  "cells 1 1 1", "zone -", "zone a%20b", "regular", "boundary", "extraordinary:5", "crease", "planar", "0:+1", "11:-1",
  "5:7", "degree 3 3 3", "degree 1 1 1", "ncp 4 4 4", "ncp 2 2 2", "knots_i 0 0 1 1", "knots_j 0 0 1 1",
  "knots_k 0 0 1 1", "points", "0 1 1 0 3 1 2 3", "1 wall", "#")

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  std::vector<std::vector<double>> memory;
  const bsv::QuadflowStorage storage = [&](int, const std::array<int, 3>& counts) -> double* {
    const double values = 3.0 * counts[0] * counts[1] * counts[2];
    if (values > 1e7)
    {
      throw bsv::Error("more than a fuzzer's input can hold");
    }
    memory.emplace_back(static_cast<std::size_t>(values));
    return memory.back().data();
  };
  fuzz::parse([&] { bsv::readQuadflow(fuzz::fileWith(data, size), storage); });
  return 0;
}

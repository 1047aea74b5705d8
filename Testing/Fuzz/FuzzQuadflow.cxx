// SPDX-License-Identifier: BSD-3-Clause
// Quadflow cases (.qfmb).
#include "FuzzSupport.h"

#include "Quadflow/QuadflowFormat.h"

BSV_FUZZ_WORDS(
  "qfmb", "block", "interface", "boundary", "edge", "end", "binary", "ascii", "little", "big", "crease", "planar", "#")

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

// SPDX-License-Identifier: BSD-3-Clause
// Neutral maps of a mesh of two blocks.
#include "FuzzSupport.h"

#include "Formats/GridBlock.h"
#include "Formats/NeutralMapFile.h"

BSV_FUZZ_WORDS("ONE_TO_ONE", "'one-to-one  '", "1 to 1", "wall", "'far field'", "PATCHED", "TRUE", "FALSE", "#",
  "ONE_TO_ONE 1 4 1 3 1 3  2 3 1 3 1 3 FALSE", "wall 1 1 1 3 1 3", "sym 2 5 3 1 1 3")

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  // 3 x 3 x 3 points each, side by side along i.
  static const std::vector<bsv::GridBlock> blocks = [] {
    std::vector<bsv::GridBlock> result(2);
    for (int b = 0; b < 2; ++b)
    {
      result[b].name = "block " + std::to_string(b + 1);
      result[b].counts = { 3, 3, 3 };
      result[b].allocate(false);
      for (int p = 0; p < 27; ++p)
      {
        const double place[3] = { 2.0 * b + p % 3, double(p / 3 % 3), double(p / 9) };
        std::copy(place, place + 3, result[b].doubles.get() + 3 * p);
      }
    }
    return result;
  }();
  bsv::BlockMesh mesh;
  for (const bsv::GridBlock& block : blocks)
  {
    mesh.blocks.push_back(bsv::meshBlock(block));
  }
  std::vector<std::string> warnings;
  fuzz::parse([&] { bsv::readNeutralMap(fuzz::fileWith(data, size), mesh, warnings); });
  return 0;
}

// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/GridBlock.h"

#include <cmath>

namespace bsv
{

namespace
{

template <typename Real>
void checkFinite(const std::string& where, const GridBlock& block, const Real* values)
{
  const Index count = 3 * block.size();
  for (Index v = 0; v < count; ++v)
  {
    if (!std::isfinite(values[v]))
    {
      const Index point = v / 3;
      const Ijk& n = block.counts;
      throw Error(where + ": block '" + block.name + "', point (" + std::to_string(point % n[0]) + ", " +
        std::to_string(point / n[0] % n[1]) + ", " + std::to_string(point / n[0] / n[1]) + "): " + "xyz"[v % 3] +
        " is " + std::to_string(values[v]));
    }
  }
}

} // namespace

void checkFinite(const std::string& where, const GridBlock& block)
{
  if (block.floats)
  {
    checkFinite(where, block, block.floats.get());
  }
  else
  {
    checkFinite(where, block, block.doubles.get());
  }
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
// The conversion through the installed headers of the core: a box of uniform cells stays the identity map.
#include "Complex/BlockComplex.h"
#include "Conversion/Conversion.h"

#include <cstdio>
#include <vector>

int main()
{
  const bsv::Ijk counts{ 4, 5, 6 };
  std::vector<double> points;
  for (int k = 0; k < counts[2]; ++k)
  {
    for (int j = 0; j < counts[1]; ++j)
    {
      for (int i = 0; i < counts[0]; ++i)
      {
        points.insert(points.end(), { double(i), double(j), double(k) });
      }
    }
  }
  bsv::BlockMesh mesh;
  mesh.blocks.resize(1);
  mesh.blocks[0].points = bsv::GridView(points.data(), counts);
  const bsv::BlockComplex complex = bsv::buildBlockComplex(mesh);
  std::vector<double> net(3 * 6 * 7 * 8);
  std::vector<unsigned char> rules(6 * 7 * 8);
  bsv::convertToBSplineVolume(complex, {}, { { net.data(), rules.data() } });
  // Greville abscissas of clamped cubic integer knots: 0, 1/3, 1, 2, 8/3, 3.
  const double expected[] = { 0.0, 1.0 / 3.0, 1.0, 2.0, 8.0 / 3.0, 3.0 };
  for (int i = 0; i < 6; ++i)
  {
    if (net[3 * i] < expected[i] - 1e-15 || net[3 * i] > expected[i] + 1e-15)
    {
      std::printf("control point %d is at %.17g, not at %.17g\n", i, net[3 * i], expected[i]);
      return 1;
    }
  }
  return 0;
}

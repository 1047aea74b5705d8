// SPDX-License-Identifier: BSD-3-Clause
#include "Data/FaceBounds.h"

#include "Complex/BlockComplex.h"

namespace bsv
{

//------------------------------------------------------------------------------
Eigen::AlignedBox3d faceBounds(const BSplineVolumeBlocks& volume, const std::vector<bool>& faces, const Ranks& ranks)
{
  Eigen::AlignedBox3d mine;
  for (std::size_t b = 0; b < volume.volumes.size(); ++b)
  {
    for (int face = 0; face < 6; ++face)
    {
      if (!faces[6 * b + face] || !volume.isHere(b))
      {
        continue;
      }
      const BSplineVolume& block = volume.volumes[b];
      const Ijk last{ block.count(0) - 1, block.count(1) - 1, block.count(2) - 1 };
      for (int t = 0; t <= last[faceAxis(face, 1)]; ++t)
      {
        for (int s = 0; s <= last[faceAxis(face, 0)]; ++s)
        {
          const Ijk ijk = facePoint(last, face, s, t);
          const Index n = ijk[0] + Index(block.count(0)) * (ijk[1] + Index(block.count(1)) * ijk[2]);
          mine.extend(Vec3(block.points + 3 * n));
        }
      }
    }
  }
  std::vector<double> corners;
  if (!mine.isEmpty())
  {
    corners = { mine.min()[0], mine.min()[1], mine.min()[2], mine.max()[0], mine.max()[1], mine.max()[2] };
  }
  corners = ranks.gatherAll(corners);
  Eigen::AlignedBox3d box;
  for (std::size_t n = 0; n + 2 < corners.size(); n += 3)
  {
    box.extend(Vec3(corners.data() + n));
  }
  return box;
}

//------------------------------------------------------------------------------
std::vector<bool> facesOf(const BSplineVolumeBlocks& volume, const std::vector<bool>& chosen)
{
  std::vector<bool> faces(6 * volume.volumes.size(), false);
  for (const BoundaryPatch& patch : volume.boundaries)
  {
    faces[6 * std::size_t(patch.block) + patch.face] = chosen[patch.tag];
  }
  return faces;
}

} // namespace bsv

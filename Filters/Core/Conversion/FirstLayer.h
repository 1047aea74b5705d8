// SPDX-License-Identifier: BSD-3-Clause
/// @file FirstLayer.h
/// Where the first inserted layer lies next to walls (5.44) and on a far-field extension.
///
/// It is p_1/3 = c p_0 + (1 - c) p_1 on each mesh line that leaves a wall or a connection layer, with c = 2/3 (knot
/// insertion) everywhere else. Where c varies, q = c p_0 + (1 - c) p_1 is a layer of mesh points like any other to the
/// rules inside layers, so that it joins as smoothly across block borders.
#pragma once

#include "Conversion/Conversion.h"
#include "Conversion/FarField.h"
#include "Ranks/Ranks.h"

#include <array>
#include <functional>
#include <vector>

namespace bsv
{

class FirstLayer
{
public:
  /// Walls only: all of those of this rank's blocks, of others what is known of them. Collective.
  /// @param complex that of LocalStars.
  /// @throws Error for a c that is not between 0 and 1.
  FirstLayer(const BlockComplex& complex, const ConversionOptions& options, const Ranks& ranks);

  /// Height of the last inserted control point over the last one at mesh point (s, t) of a block face, along the
  /// normal.
  using LastDistance = std::function<double(const FaceUse& use, int s, int t, const Vec3& normal)>;

  /// The extension beyond a side; `spacing` is not Off. `lastDistance` is asked for faces of this rank's blocks only.
  /// Collective.
  void setSide(const FarFieldSide& side, FarFieldSpacing spacing, const LastDistance& lastDistance);

  /// c of the line that leaves a block's face into the block at one of the face's mesh points.
  double weight(int block, int face, const Ijk& point) const
  {
    const std::vector<double>& values = this->Weights[block][face];
    if (values.size() < 2)
    {
      return values.empty() ? KnotInsertion : values[0];
    }
    return values[point[faceAxis(face, 0)] +
      std::size_t(this->Complex.blocks[block].cells(faceAxis(face, 0)) + 1) * point[faceAxis(face, 1)]];
  }
  /// Whether c is 2/3 all over the face.
  bool isKnotInsertion(int block, int face) const { return this->Weights[block][face].empty(); }
  /// Whether c varies over the face.
  bool varies(int block, int face) const { return this->Weights[block][face].size() > 1; }

  /// Adds what was done to the report.
  void describe(ConversionReport& report) const;

private:
  void setWalls(const ConversionOptions& options);

  const BlockComplex& Complex;
  const Ranks& Processes;
  /// Per block and face: nothing for 2/3, one value, or one per mesh point of the face in its axes, s fastest.
  std::vector<std::array<std::vector<double>, 6>> Weights;
  std::vector<double> Distances;
  Index Limited = 0;
  std::array<double, 2> WallRange{ KnotInsertion, KnotInsertion };
};

} // namespace bsv

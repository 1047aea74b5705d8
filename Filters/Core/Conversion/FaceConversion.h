// SPDX-License-Identifier: BSD-3-Clause
/// @file FaceConversion.h
/// Control points owned by the interior of a block or face: copies, and the regular rule across one face.
#pragma once

#include "Conversion/ConversionContext.h"

namespace bsv
{

/// One layer of a block's interior. If `stream`, the memory is in order only after endStream().
void convertBlock(const ConversionContext& context, int block, int slab, bool stream);
void endStream();

void convertFace(const ConversionContext& context, int face);
/// Points (s, t) from `begin` on and before `end` of it, in the axes of its first use; the others belong to edges.
void convertFacePoints(
  const ConversionContext& context, int face, const std::array<int, 2>& begin, const std::array<int, 2>& end);

} // namespace bsv

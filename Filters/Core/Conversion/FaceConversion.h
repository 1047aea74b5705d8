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

} // namespace bsv

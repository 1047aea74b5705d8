// SPDX-License-Identifier: BSD-3-Clause
/// @file VertexConversion.h
/// Control points owned by a vertex: where layers of several directions meet.
#pragma once

#include "Conversion/ConversionContext.h"

namespace bsv
{

/// @return whether the vertex is a singular node.
bool convertVertex(const ConversionContext& context, int vertex);

} // namespace bsv

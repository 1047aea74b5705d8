// SPDX-License-Identifier: BSD-3-Clause
/// @file SurfaceConversion.h
/// The outer surface around a boundary vertex.
#pragma once

#include "Conversion/Star.h"

namespace bsv
{

/// Sets the centre and the inserted points on boundary edges and faces.
void convertSurface(const ConversionContext& context, Star& star);

/// What ConversionOptions gives at the vertices of the body. Collective.
GivenFeet givenFeet(const BlockComplex& complex, const ConversionOptions& options, const Ranks& ranks);

} // namespace bsv

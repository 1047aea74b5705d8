// SPDX-License-Identifier: BSD-3-Clause
/// @file Limits.h
/// How much of what a block complex may have.
#pragma once

namespace bsv
{

/// The most blocks at an edge, and boundary faces at a vertex of the boundary: the rules there take memory in
/// proportion to the square, and time to the cube, of their number. buildBlockComplex() refuses more.
constexpr int MostBlocksAtEdge = 100;

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
/// @file FarField.h
/// The far-field extension: blocks attached to the planar sides of the cuboidal first part of the far field.
#pragma once

#include "Conversion/Conversion.h"

#include <vector>

namespace bsv
{

/// One side of the cuboid with its connection layer: all inner block faces in the side's plane, also those beyond the
/// cuboid's edges, at which blocks attached to one side meet those attached to edges and corners only.
struct FarFieldSide
{
  /// Unit normal, away from the cuboid.
  Vec3 normal = Vec3::Zero();
  /// Global faces, and the block face on either side of each.
  std::vector<int> faces;
  std::vector<FaceUse> inner;
  std::vector<FaceUse> outer;
  /// Whether the face is part of the cuboid's side itself.
  std::vector<bool> onCuboid;
};

/// The sides to which an extension is attached, in the order of their normals' coordinates; none if there is no
/// extension.
///
/// Named blocks (ConversionOptions::extensionBlocks): every plane in which a named block meets another one. Its outside
/// is where the named blocks are, but never where the body is.
///
/// Automatic, whatever the numbering. A side is a plane of inner block faces that
/// - no block crosses, and beyond which lies no wall (the body does not touch it either);
/// - has one layer of blocks beyond it, each of which reaches from the plane to the outer boundary.
/// What lies inside all these planes must be a cuboid: its outer boundary but the body lies in planes at right angles
/// (within 1e-3), with the whole part behind each of them. At least at one edge in these planes other than four blocks
/// must meet (two on the outer boundary), as at the edges of a cuboid in which blocks surround the body: a grid that
/// goes on regularly needs no rule, it joins C2. A mesh without a body has no extension; one of several layers of
/// blocks must be named.
///
/// The same on all ranks. Collective.
///
/// @throws Error if blocks are named but none meets another block in a plane.
std::vector<FarFieldSide> farFieldSides(
  const BlockComplex& complex, const ConversionOptions& options, const Execution& run = {});

/// Role of a boundary face.
BoundaryRole roleOf(const ConversionOptions& options, const ComplexFace& face);

} // namespace bsv

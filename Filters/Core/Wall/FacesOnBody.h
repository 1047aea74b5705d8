// SPDX-License-Identifier: BSD-3-Clause
/// @file FacesOnBody.h
/// Which block faces are the wall, told by the body: for meshes that do not name their boundaries.
#pragma once

#include "Body/ClosestPoint.h"
#include "Mesh/BlockMesh.h"

#include <array>
#include <vector>

namespace bsv
{

/// Block faces that lie on the body, as pairs of block and face, in their order. Of up to 17 x 17 points of the face,
/// spread evenly, 19 of 20 are at most half as far from the body as the next point off the face, and at most a
/// twentieth of the mean length of the face's mesh edges there. Collective.
/// @throws Aborted
std::vector<std::array<int, 2>> facesOnBody(const BlockMesh& mesh, const BodySurface& body, const Execution& run = {});

} // namespace bsv

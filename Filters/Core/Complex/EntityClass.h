// SPDX-License-Identifier: BSD-3-Clause
/// @file EntityClass.h
/// What the vertices, edges and faces of a block complex are: regular, extraordinary, singular, on the boundary.
#pragma once

#include "Complex/BlockComplex.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace bsv
{

/// Values are the codes of the cell array `Class` of vtkHexBlockTopology.
enum class EntityClass : std::uint8_t
{
  Regular,       ///< inside, as in one structured grid
  Boundary,      ///< on the outer boundary, as in one structured grid or along its edge
  Extraordinary, ///< interior edge of valence other than 4; vertex inside such an edge's curve; boundary vertex away
                 ///< from creases and borders of named boundaries at which other than 4 boundary faces meet
  Singular,      ///< interior vertex at which extraordinary edges of more than one direction meet
  Crease,        ///< crease edge; vertex at the end of one or two of them
  Corner,        ///< vertex at which three or more crease edges meet
  Count
};

/// Names of the codes, in order.
const std::vector<std::string>& entityClassNames();

/// One entry per vertex, edge, face of the complex.
struct EntityClasses
{
  std::vector<EntityClass> vertices;
  std::vector<EntityClass> edges;
  std::vector<EntityClass> faces;
  Index extraordinaryEdges = 0;
  Index singularNodes = 0;
  /// Number of extraordinary curves per valence. A curve is a chain of extraordinary edges that ends at the boundary
  /// or at singular nodes, or is a closed ring.
  std::map<int, Index> extraordinaryCurves;
};

EntityClasses classifyEntities(const BlockComplex& complex);

} // namespace bsv

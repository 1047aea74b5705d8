// SPDX-License-Identifier: BSD-3-Clause
/// @file FaceContact.h
/// Contacts of block faces as files declare them: a range on either side that may run backwards, checked against the
/// points of the mesh.
#pragma once

#include "Mesh/BlockMesh.h"

#include <string>
#include <vector>

namespace bsv
{

/// Rectangle of mesh points on a face, from 0, along the face's axes. Each axis runs from begin to end, which may be
/// the smaller one.
struct DirectedRange
{
  int block = 0;
  int face = 0;
  std::array<int, 2> begin{ 0, 0 };
  std::array<int, 2> end{ 0, 0 };

  /// The same rectangle without directions.
  FaceRange range() const;
};

/// The contact of two ranges: the point begin of `a` meets the point begin of `b`, and the first axis of `a` runs along
/// the first of `b`, or along the second one if `swapped`.
/// @throws Error if the ranges differ in size. The text names no file; the caller adds it.
Interface faceContact(const DirectedRange& a, const DirectedRange& b, bool swapped);

/// The same contact with its sides in ascending order, so that both declarations of one contact compare equal.
Interface orderedContact(const Interface& contact);
/// Any strict order, for std::set.
bool operator<(const Interface& a, const Interface& b);

/// A contact and where it is declared, for messages: "mesh.nmf, line 7".
struct DeclaredContact
{
  Interface contact;
  std::string where;
};

/// Checks that the points of the two sides coincide: no farther apart than 5 % of the shortest mesh edge at either of
/// them (edges of zero length do not count). Collective; a process that is alone and has not all blocks checks the
/// contacts of those that it has.
/// @throws Error naming the place, blocks, point, distance and tolerance, for the first contact that is wrong.
void checkContacts(BlockMesh mesh, const std::vector<DeclaredContact>& contacts, const Ranks& ranks);

/// Checks that the range lies in the face and spans at least one cell along both axes.
/// @throws Error naming block, face and range. The text names no file; the caller adds it.
void checkRange(const BlockMesh& mesh, const DirectedRange& range);

} // namespace bsv

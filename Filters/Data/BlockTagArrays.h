// SPDX-License-Identifier: BSD-3-Clause
/// @file BlockTagArrays.h
/// What a block brings with it (BlockTags.h), out of its arrays and between ranks.
#pragma once

#include "Data/BlockTags.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace bsv
{

inline FaceRange wholeFace(const Ijk& counts, int face)
{
  return { { 0, 0 }, { counts[faceAxis(face, 0)] - 1, counts[faceAxis(face, 1)] - 1 } };
}

/// The point (s, t) of a face.
inline Ijk pointOn(const Ijk& counts, int face, int s, int t)
{
  Ijk p{};
  p[faceDirection(face)] = faceSide(face) ? counts[faceDirection(face)] - 1 : 0;
  p[faceAxis(face, 0)] = s;
  p[faceAxis(face, 1)] = t;
  return p;
}

inline Ijk pointAt(const Ijk& counts, Index n)
{
  return { static_cast<int>(n % counts[0]), static_cast<int>(n / counts[0] % counts[1]),
    static_cast<int>(n / counts[0] / counts[1]) };
}

inline Index sizeOf(const Ijk& counts)
{
  return Index(counts[0]) * counts[1] * counts[2];
}

/// Empty if there is no such array, or if it has other components.
std::vector<std::string> stringsOf(vtkFieldData* fields, const char* name);
std::vector<int> intsOf(vtkFieldData* fields, const char* name, int components);

/// What a block brings with it, and where its points were in the block that it was.
struct Tags
{
  std::string key;
  /// Points per direction of the block that it was.
  Ijk counts{ 0, 0, 0 };
  /// False if its points form no box of that block.
  bool placed = false;
  /// Direction of the former block along which each direction runs, and the places there.
  Ijk axis{ 0, 1, 2 };
  std::array<std::vector<int>, 3> places;

  struct Contact
  {
    Interface contact; // blockA and blockB are not used
    std::string other;
  };
  std::vector<Contact> contacts;
  struct Boundary
  {
    int face;
    FaceRange range;
    std::string name;
    std::string type;
  };
  std::vector<Boundary> boundaries;
  std::vector<CreaseLine> creases; // block is not used

  bool was(const Ijk& points) const { return this->counts == points; }
};

/// Tags of a grid that is here; one without a key brings nothing.
Tags readTags(vtkStructuredGrid* grid);

/// Those of all blocks, on all ranks. Collective.
std::vector<Tags> gatherTags(const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks);

} // namespace bsv

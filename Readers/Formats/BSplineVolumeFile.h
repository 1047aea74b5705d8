// SPDX-License-Identifier: BSD-3-Clause
/// @file BSplineVolumeFile.h
/// Reads B-spline volumes, polynomial or rational, from GoTools `.g2` files and MFEM NURBS meshes.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Volume/BSplineVolume.h"

#include <string>
#include <utility>
#include <vector>

namespace bsv
{

/// A block that owns its control points.
struct BSplineVolumeFileBlock
{
  std::string name;
  /// Degrees and knots; its pointers are not set.
  BSplineVolume volume;
  /// First direction fastest, not multiplied by the weights.
  std::vector<Vec3> points;
  /// One per point, positive. Empty in all blocks if the weights of all blocks are 1.
  std::vector<double> weights;
  /// Whether the weights of this block differ.
  bool rational = false;
  /// MFEM's attribute of the element (its material); 0 for g2.
  int attribute = 0;
};

struct BSplineVolumeFileContent
{
  /// "GoTools g2" or "MFEM NURBS mesh".
  std::string format;
  std::vector<BSplineVolumeFileBlock> blocks;
  /// Contacts and boundaries that the file declares, all of whole faces; their ranges are not set.
  std::vector<Interface> interfaces;
  std::vector<BoundaryPatch> boundaries;
  std::vector<std::string> boundaryNames;
  /// What the file holds besides volumes and was left out: name and count.
  std::vector<std::pair<std::string, int>> others;
};

/// Whether the file is one that readBSplineVolumeFile() is for: a `.g2` file with a spline volume, or any kind of MFEM
/// NURBS mesh, also one that is then refused.
bool isBSplineVolumeFile(const std::string& fileName);

/// Reads a file; its format is found from its first bytes.
/// @throws Error naming the file, and the line for what is wrong at one, or if it holds no volume.
BSplineVolumeFileContent readBSplineVolumeFile(const std::string& fileName, const Execution& run = {});

/// GoTools: all spline volumes (class 700); all else is counted and left out.
BSplineVolumeFileContent parseG2Volumes(
  const std::string& text, const std::string& fileName, const Execution& run = {});

/// MFEM NURBS mesh v1.0 of hexahedral patches, in both of its forms, and v1.1, whose spacing functions are left out.
///
/// - `patches`: every patch with its knot vectors and control points.
/// - `knotvectors`: knot vectors shared through the section `edges`; weights and coordinates numbered over the whole
///   mesh: vertices first, then the control points inside every edge (in the order of `edges`, from the vertex of the
///   lower number to the other), inside every face (in the order of first appearance in the elements, in the axes of
///   the element where it first appears) and inside every patch.
///
/// A knot vector runs along an edge from the first vertex listed to the second. Interfaces are faces with the same
/// four vertices; boundaries are named "boundary <attribute>", in ascending order of the attributes, unless a comment
/// before the first section says "# boundary attribute <attribute>: <name>", and blocks likewise.
///
/// Source: MFEM's documentation of its mesh formats (https://mfem.org/mesh-formats) and the meshes that come with it.
BSplineVolumeFileContent parseMFEMMesh(const std::string& text, const std::string& fileName, const Execution& run = {});

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
/// @file VolumeFormats.h
/// Exact multi-block B-spline volumes for isogeometric programs: MFEM, G+Smo, GoTools. All are text with the shortest
/// digits that read back to the same double.
#pragma once

#include "Formats/VolumeToWrite.h"
#include "IO/FileParts.h"

namespace bsv
{

/// MFEM NURBS mesh v1.0 with one patch per block. MFEM knows faces and edges by their vertices alone and needs
/// right-handed patches: blocks that meet themselves, or other blocks more than once, are cut (with a note), and
/// left-handed ones are written with u reversed. Boundary attributes are 1, 2, .. in the order of the boundary names,
/// the next one for what has no name; element attributes are block numbers from 1. Comments say which is which.
///
/// Source: https://mfem.org/mesh-formats. Collective.
/// @throws Error for blocks that face each other with different degrees or knots, or turned round on themselves.
void writeMFEM(VolumeToWrite volume, AtomicFile& file, const Execution& run, std::vector<std::string>& notes);

/// G+Smo XML: a MultiPatch with its interfaces and a boundary per name, and a TensorBSpline3 or, if it is rational, a
/// TensorNurbs3 per block. Boundaries without a name are one without a label.
///
/// Source: https://gismo.github.io. Collective.
void writeGismo(const VolumeToWrite& volume, AtomicFile& file, const Execution& run);

/// GoTools `.g2`: a SplineVolume (class 700) per block. No interfaces, no names.
///
/// Source: GoTools' SplineVolume and ObjectHeader classes, https://github.com/SINTEF-Geometry/GoTools. Collective.
void writeG2Volumes(const VolumeToWrite& volume, AtomicFile& file, const Execution& run);

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
/// @file QuadflowFormat.h
/// The multi-block topology file `.qfmb`, text or with binary control points. Everything that is known of its syntax is
/// in QuadflowSyntax.h, QuadflowReader.cpp and QuadflowWriter.cpp; Writers/quadflow_format.md describes it.
///
/// This is a dialect of this project. No public sample of the solver's own file was available, and compatibility with
/// it is not claimed.
#pragma once

#include "Quadflow/QuadflowCase.h"
#include "Ranks/Piece.h"

#include <functional>

namespace bsv
{

struct QuadflowOptions
{
  /// First id of vertices, edges, faces and blocks: 0 or 1.
  int indexBase = 0;
  /// Knots divided by their range, instead of as they are. Reading multiplies by the number of spans: integer knots
  /// come back exactly, others lose their scale.
  bool unitKnots = false;
  /// Control points and knots in a second file, the extension replaced by `.bsp`.
  bool separateGeometry = false;
  /// Control points as numbers of this machine's byte order between the lines of text: faster, and smaller.
  bool binary = false;
};

/// Writes `all`, which must have passed checkQuadflowCase(). Nothing is left behind after an error or an abort, and
/// an old file is untouched.
///
/// Ranks write one file, the same for any number of them: rank 0 what comes before the geometry, and each its own
/// blocks, all at once. They must see the same folder.
/// @throws Error, Aborted
void writeQuadflow(
  const QuadflowCase& all, const std::string& path, const QuadflowOptions& options = {}, const Execution& run = {});

/// Whether the file begins as a topology file: its first 4096 bytes are read.
bool looksLikeQuadflow(const std::string& path);

/// Memory for the control points of block `block`: `counts[0] * counts[1] * counts[2]` triples.
using QuadflowStorage = std::function<double*(int block, const std::array<int, 3>& counts)>;

/// Reads and checks a file, text or binary in any byte order, and the geometry file that it names. Counts are compared
/// with the size of the file before memory is asked for. Collective.
///
/// Of blocks that do not belong to `piece` the control points are skipped. As their numbers are not known before,
/// blocks are shared out by those of a cubic with simple knots, cells + 3 per direction.
/// @throws Error naming file and line, Aborted
QuadflowCase readQuadflow(
  const std::string& path, const QuadflowStorage& storage, const Execution& run = {}, const Piece& piece = {});

} // namespace bsv

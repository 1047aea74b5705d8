// SPDX-License-Identifier: BSD-3-Clause
/// @file Plot3DFile.h
/// PLOT3D grid files, three-dimensional, of one or many blocks.
///
/// All kinds hold the same sequence, in integers and reals of 4 or 8 bytes: the number of blocks, the points per
/// direction of every block, then per block all x, all y, all z and optionally all iblank values, i fastest. A file of
/// a single block may lack the number of blocks. The kinds differ in how the sequence is stored:
/// - ASCII: Fortran list-directed, that is separated by blanks, commas or line ends anywhere, with repeats `2*65` and
///   exponents e, d or q; lines before the first number that start with #, !, / or % are left out;
/// - raw binary: nothing else;
/// - Fortran unformatted: three sorts of records (number of blocks; points per direction; one block each) between
///   markers of 4 or 8 bytes that tell their length. Other records are read as well, such as one per coordinate, or
///   the parts of one that is longer than 2 GiB.
///
/// Source: P. P. Walatka et al., PLOT3D User's Manual, NASA TM-101067 (1990), chapter 8.
#pragma once

#include "Base/Types.h"
#include "Formats/GridBlock.h"
#include "Ranks/Piece.h"

#include <string>
#include <vector>

namespace bsv
{

enum class Plot3DFormat
{
  Automatic,
  Ascii,
  Binary,
  Fortran,  ///< record markers of 4 bytes
  Fortran64 ///< record markers of 8 bytes
};

enum class ByteOrder
{
  Automatic,
  LittleEndian,
  BigEndian
};

enum class RealType
{
  Automatic,
  Float,
  Double
};

enum class IBlank
{
  Automatic,
  Absent,
  Present
};

/// How to read a file; Automatic where the file shall tell. Byte order and real type do not matter for ASCII, whose
/// points are always doubles.
struct Plot3DOptions
{
  Plot3DFormat format = Plot3DFormat::Automatic;
  ByteOrder byteOrder = ByteOrder::Automatic;
  RealType realType = RealType::Automatic;
  IBlank iblank = IBlank::Automatic;
};

/// What a file holds and how: nothing Automatic any more.
struct Plot3DLayout : Plot3DOptions
{
  /// Whether the file starts with the number of blocks.
  bool multiBlock = true;
  /// Whether the records are others than those below: only their contents, one after the other, count.
  bool joined = false;
  /// Bytes of an integer of a binary file: 4 or 8.
  int integerSize = 4;
  /// Lines before the first number of an ASCII file that are left out.
  Index comments = 0;
  /// Points per direction of every block.
  std::vector<Ijk> counts;

  /// For the user, such as "Fortran unformatted, little-endian, double, without iblank".
  std::string description() const;
};

/// Finds the layout: the one that explains the size of the file to the byte (ASCII: to the number), looked for in the
/// order of the enumerators above, several blocks before one. A header within record markers rules raw binary out.
/// Should several explain the file, the first one whose coordinates are of believable size is taken.
/// @throws Error if none does: the text names the file and what it is instead (two-dimensional, planes format, a
/// solution or function file, compressed, UTF-16), or what was tried and where that failed.
Plot3DLayout plot3DLayout(const std::string& fileName, const Plot3DOptions& options = {}, const Execution& run = {});

/// Whether the header is that of a PLOT3D file, well or ill formed behind it. Never throws.
bool looksLikePlot3D(const std::string& fileName);

/// Reads the blocks of a piece. They are named "block 1", "block 2", .. Of binary files only the header and these
/// blocks are read; the numbers of an ASCII file are looked at in any case, those of other pieces not as closely.
/// @throws Error naming file, block and line or offset, and the value; Aborted.
std::vector<GridBlock> readPlot3D(
  const std::string& fileName, const Plot3DLayout& layout, const Execution& run = {}, const Piece& piece = {});

} // namespace bsv

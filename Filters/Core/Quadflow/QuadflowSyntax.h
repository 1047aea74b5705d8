// SPDX-License-Identifier: BSD-3-Clause
/// @file QuadflowSyntax.h
/// Words of the file `.qfmb`, shared by its reader and its writer.
#pragma once

#include "Base/Types.h"

#include <cstdint>
#include <cstring>
#include <string>

namespace bsv::quadflow
{

inline constexpr const char* Magic = "QFMB";
inline constexpr const char* GeometryMagic = "QFBSP";
inline constexpr const char* Version = "1.0";
/// Words for the byte orders of binary control points, and the number that precedes those of each block.
inline constexpr const char* LittleEndian = "little_endian";
inline constexpr const char* BigEndian = "big_endian";
inline constexpr double ByteOrderMark = 1.0;
/// Control points between two reports of progress.
inline constexpr Index PointsPerReport = 1 << 16;
inline constexpr const char* KnotLabels[3] = { "knots_i", "knots_j", "knots_k" };
inline constexpr const char* EdgeClassNames[5] = { "regular", "boundary", "extraordinary", "crease", "planar" };

inline const char* ownByteOrder()
{
  const std::uint16_t two = 2;
  unsigned char first;
  std::memcpy(&first, &two, 1);
  return first == 2 ? LittleEndian : BigEndian;
}

/// Folder of a path with the slash at its end, or nothing.
inline std::string folderOf(const std::string& path)
{
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash + 1);
}

} // namespace bsv::quadflow

// SPDX-License-Identifier: BSD-3-Clause
/// @file MeshFiles.h
/// Writes mesh cases as PLOT3D, neutral map and CGNS files, and reads files with vtkHexBlockMeshReader, for tests.
#pragma once

#include "Support/Files.h"
#include "Support/MeshCases.h"
#include "Support/Messages.h"

#include "vtkHexBlockMeshReader.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkExecutive.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkSmartPointer.h>
#include <vtk_cgns.h>
// clang-format off
#include VTK_CGNS(cgnslib.h)
// clang-format on

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

namespace meshfiles
{

using bsv::Ijk;
using meshcases::MeshCase;

using bsvtest::readFile;
using bsvtest::TemporaryFolder;
using bsvtest::writeFile;

//----------------------------------------------------------------------------------------------------------------------
// PLOT3D

/// How a PLOT3D file is written; marker 0 is raw binary.
struct Plot3DKind
{
  bool ascii = false;
  int marker = 4;
  bool bigEndian = false;
  bool isFloat = false;
  bool iblank = false;
  bool multiBlock = true;

  std::string name() const
  {
    if (this->ascii)
    {
      return std::string("ASCII") + (this->iblank ? ", with iblank" : ", without iblank");
    }
    return std::string(this->marker == 0 ? "raw binary"
               : this->marker == 4       ? "Fortran unformatted"
                                         : "Fortran unformatted (8-byte markers)") +
      (this->bigEndian ? ", big-endian" : ", little-endian") + (this->isFloat ? ", float" : ", double") +
      (this->iblank ? ", with iblank" : ", without iblank");
  }
};

inline std::vector<Plot3DKind> allPlot3DKinds()
{
  std::vector<Plot3DKind> kinds;
  for (int bits = 0; bits < 32; ++bits)
  {
    const bool multi = bits & 1;
    const bool iblank = bits & 2;
    if (bits < 4)
    {
      kinds.push_back({ true, 0, false, false, iblank, multi });
    }
    for (const int marker : { 0, 4, 8 })
    {
      if (bits < 16)
      {
        kinds.push_back({ false, marker, (bits & 4) != 0, (bits & 8) != 0, iblank, multi });
      }
    }
  }
  return kinds;
}

/// Appends values in the byte order wanted, on a little-endian machine.
template <typename Value>
void append(std::string& out, Value value, bool bigEndian)
{
  char bytes[sizeof(Value)];
  std::memcpy(bytes, &value, sizeof(Value));
  if (bigEndian)
  {
    std::reverse(bytes, bytes + sizeof(Value));
  }
  out.append(bytes, sizeof(Value));
}

/// The iblank value written for a point.
inline int iblankValue(std::size_t point)
{
  return point % 7 == 3 ? 0 : -static_cast<int>(point % 5);
}

inline std::string plot3D(const MeshCase& mesh, const Plot3DKind& kind)
{
  std::string file;
  std::string record;
  const auto integer = [&](int value) {
    kind.ascii ? record += " " + std::to_string(value) : (append(record, std::int32_t(value), kind.bigEndian), record);
  };
  const auto real = [&](double value) {
    if (kind.ascii)
    {
      char text[40];
      std::snprintf(text, sizeof(text), " %.17g", value);
      record += text;
    }
    else if (kind.isFloat)
    {
      append(record, float(value), kind.bigEndian);
    }
    else
    {
      append(record, value, kind.bigEndian);
    }
  };
  const auto endRecord = [&] {
    std::string marker;
    if (kind.ascii)
    {
      record += "\n";
    }
    else if (kind.marker == 4)
    {
      append(marker, std::int32_t(record.size()), kind.bigEndian);
    }
    else if (kind.marker == 8)
    {
      append(marker, std::int64_t(record.size()), kind.bigEndian);
    }
    file += marker + record + marker;
    record.clear();
  };

  if (kind.multiBlock)
  {
    integer(static_cast<int>(mesh.blocks.size()));
    endRecord();
  }
  for (const MeshCase::Block& block : mesh.blocks)
  {
    for (const int count : block.counts)
    {
      integer(count);
    }
  }
  endRecord();
  for (const MeshCase::Block& block : mesh.blocks)
  {
    for (int axis = 0; axis < 3; ++axis)
    {
      for (std::size_t p = 0; p < block.points.size(); ++p)
      {
        real(block.points[p][axis]);
        record += kind.ascii && p % 5 == 4 ? "\n" : "";
      }
    }
    for (std::size_t p = 0; kind.iblank && p < block.points.size(); ++p)
    {
      integer(iblankValue(p));
    }
    endRecord();
  }
  return file;
}

//----------------------------------------------------------------------------------------------------------------------
// Contacts

/// Corners (s, t) of a contact on B's face, by the corners of A's range: [s][t].
inline std::array<std::array<std::array<int, 2>, 2>, 2> cornersOnB(const bsv::Interface& contact)
{
  std::array<std::array<std::array<int, 2>, 2>, 2> corners;
  const int n[2] = { contact.rangeA.hi[0] - contact.rangeA.lo[0], contact.rangeA.hi[1] - contact.rangeA.lo[1] };
  for (int s = 0; s < 2; ++s)
  {
    for (int t = 0; t < 2; ++t)
    {
      corners[s][t] = bsv::mapFacePoint(contact.orientation, s * n[0], t * n[1], n[0], n[1]);
      corners[s][t][0] += contact.originB[0];
      corners[s][t][1] += contact.originB[1];
    }
  }
  return corners;
}

/// The neutral map of a case. `flip` reverses both sides of every interface along the first direction, which must not
/// change its meaning.
inline std::string neutralMap(const MeshCase& mesh, bool flip = false)
{
  const int faceNumber[6] = { 3, 4, 5, 6, 1, 2 };
  const auto primary = [](int face) { return bsv::faceDirection(face) == 1 ? 1 : 0; };
  std::string text = "# comment\n " + std::to_string(mesh.blocks.size()) + "\n\n";
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    const Ijk& n = mesh.blocks[b].counts;
    text += std::to_string(b + 1) + " " + std::to_string(n[0]) + " " + std::to_string(n[1]) + " " +
      std::to_string(n[2]) + "  # size\n";
  }
  text += "# Type B1 F1 S1 E1 S2 E2 B2 F2 S1 E1 S2 E2 Swap\n";
  // begin and end are (s, t) points.
  const auto range = [&](int block, int face, const std::array<int, 2>& begin, const std::array<int, 2>& end) {
    std::string words = "  " + std::to_string(block + 1) + " " + std::to_string(faceNumber[face]);
    for (const int axis : { primary(face), 1 - primary(face) })
    {
      words += " " + std::to_string(begin[axis] + 1) + " " + std::to_string(end[axis] + 1);
    }
    return words;
  };
  for (const bsv::Interface& c : mesh.interfaces)
  {
    const auto corners = cornersOnB(c);
    std::array<int, 2> beginA = c.rangeA.lo;
    std::array<int, 2> endA = c.rangeA.hi;
    std::array<int, 2> beginB = corners[0][0];
    std::array<int, 2> endB = corners[1][1];
    if (flip)
    {
      std::swap(beginA[0], endA[0]);
      beginB = corners[1][0];
      endB = corners[0][1];
    }
    // Primary direction of A: from corner 00 to 10, or to 01 on j faces.
    const auto& next = primary(c.faceA) == 0 ? corners[1][0] : corners[0][1];
    const int along = next[0] != corners[0][0][0] ? 0 : 1;
    text += "ONE_TO_ONE" + range(c.blockA, c.faceA, beginA, endA) + range(c.blockB, c.faceB, beginB, endB) +
      (along == primary(c.faceB) ? " FALSE\n" : " TRUE\n");
  }
  for (const bsv::BoundaryPatch& patch : mesh.boundaries)
  {
    text +=
      "'" + mesh.boundaryNames[patch.tag] + "'" + range(patch.block, patch.face, patch.range.lo, patch.range.hi) + "\n";
  }
  return text;
}

//----------------------------------------------------------------------------------------------------------------------
// CGNS

struct CGNSKind
{
  int fileType = CG_FILE_ADF;
  bool isFloat = false;
  /// How boundary conditions list their points.
  enum Points
  {
    Range,
    List,
    FaceCenters
  } points = Range;
};

inline void require(int status)
{
  ASSERT_EQ(status, CG_OK) << cg_get_error();
}

/// 1-based (i, j, k) of a point (s, t) on a face.
inline std::array<cgsize_t, 3> pointOnFace(const Ijk& counts, int face, const std::array<int, 2>& st)
{
  std::array<cgsize_t, 3> point;
  point[bsv::faceDirection(face)] = bsv::faceSide(face) == 0 ? 1 : counts[bsv::faceDirection(face)];
  point[bsv::faceAxis(face, 0)] = st[0] + 1;
  point[bsv::faceAxis(face, 1)] = st[1] + 1;
  return point;
}

/// Writes all zones, families for the boundary names, and every contact in both zones.
inline void writeCGNS(const MeshCase& mesh, const std::string& fileName, const CGNSKind& kind = {})
{
  int file = 0;
  int base = 0;
  require(cg_set_file_type(kind.fileType));
  require(cg_open(fileName.c_str(), CG_MODE_WRITE, &file));
  require(cg_base_write(file, "Base", 3, 3, &base));
  for (const std::string& name : mesh.boundaryNames)
  {
    int family = 0;
    require(cg_family_write(file, base, name.c_str(), &family));
  }
  const auto zoneName = [&](int block) { return "zone " + std::to_string(block + 1); };
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    const MeshCase::Block& block = mesh.blocks[b];
    const Ijk& n = block.counts;
    const cgsize_t size[9] = { n[0], n[1], n[2], n[0] - 1, n[1] - 1, n[2] - 1, 0, 0, 0 };
    int zone = 0;
    require(cg_zone_write(file, base, zoneName(static_cast<int>(b)).c_str(), size, CGNS_ENUMV(Structured), &zone));
    for (int axis = 0; axis < 3; ++axis)
    {
      std::vector<float> floats;
      std::vector<double> doubles;
      for (const bsv::Vec3& x : block.points)
      {
        floats.push_back(float(x[axis]));
        doubles.push_back(x[axis]);
      }
      int coordinate = 0;
      const char* names[3] = { "CoordinateX", "CoordinateY", "CoordinateZ" };
      require(cg_coord_write(file, base, zone, kind.isFloat ? CGNS_ENUMV(RealSingle) : CGNS_ENUMV(RealDouble),
        names[axis], kind.isFloat ? (const void*)floats.data() : (const void*)doubles.data(), &coordinate));
    }
  }
  int number = 0;
  for (const bsv::Interface& c : mesh.interfaces)
  {
    const auto corners = cornersOnB(c);
    const Ijk& countsA = mesh.blocks[c.blockA].counts;
    const Ijk& countsB = mesh.blocks[c.blockB].counts;
    cgsize_t rangeA[6];
    cgsize_t rangeB[6];
    const auto fill = [](cgsize_t* range, const std::array<cgsize_t, 3>& begin, const std::array<cgsize_t, 3>& end) {
      std::copy(begin.begin(), begin.end(), range);
      std::copy(end.begin(), end.end(), range + 3);
    };
    fill(rangeA, pointOnFace(countsA, c.faceA, c.rangeA.lo), pointOnFace(countsA, c.faceA, c.rangeA.hi));
    fill(rangeB, pointOnFace(countsB, c.faceB, corners[0][0]), pointOnFace(countsB, c.faceB, corners[1][1]));
    const std::array<int, 3> transform = bsv::cgnsTransform(c.faceA, c.faceB, c.orientation);
    std::array<int, 3> inverse{};
    for (int d = 0; d < 3; ++d)
    {
      inverse[std::abs(transform[d]) - 1] = transform[d] < 0 ? -(d + 1) : d + 1;
    }
    int id = 0;
    const std::string name = "contact " + std::to_string(++number);
    require(cg_1to1_write(
      file, base, c.blockA + 1, name.c_str(), zoneName(c.blockB).c_str(), rangeA, rangeB, transform.data(), &id));
    require(cg_1to1_write(file, base, c.blockB + 1, (name + " back").c_str(), zoneName(c.blockA).c_str(), rangeB,
      rangeA, inverse.data(), &id));
  }
  for (const bsv::BoundaryPatch& patch : mesh.boundaries)
  {
    std::vector<std::array<cgsize_t, 3>> points;
    const bool centers = kind.points == CGNSKind::FaceCenters;
    std::array<int, 2> hi = patch.range.hi;
    hi[0] -= centers;
    hi[1] -= centers;
    if (kind.points == CGNSKind::List)
    {
      for (int t = patch.range.lo[1]; t <= hi[1]; ++t)
      {
        for (int s = patch.range.lo[0]; s <= hi[0]; ++s)
        {
          points.push_back(pointOnFace(mesh.blocks[patch.block].counts, patch.face, { s, t }));
        }
      }
    }
    else
    {
      points.push_back(pointOnFace(mesh.blocks[patch.block].counts, patch.face, hi));
      points.push_back(pointOnFace(mesh.blocks[patch.block].counts, patch.face, patch.range.lo));
    }
    int id = 0;
    require(cg_boco_write(file, base, patch.block + 1, ("condition " + std::to_string(++number)).c_str(),
      CGNS_ENUMV(FamilySpecified), kind.points == CGNSKind::List ? CGNS_ENUMV(PointList) : CGNS_ENUMV(PointRange),
      static_cast<cgsize_t>(points.size()), points[0].data(), &id));
    if (centers)
    {
      const CGNS_ENUMT(GridLocation_t)
        locations[3] = { CGNS_ENUMV(IFaceCenter), CGNS_ENUMV(JFaceCenter), CGNS_ENUMV(KFaceCenter) };
      require(cg_boco_gridlocation_write(file, base, patch.block + 1, id, locations[bsv::faceDirection(patch.face)]));
    }
    require(cg_goto(file, base, "Zone_t", patch.block + 1, "ZoneBC_t", 1, "BC_t", id, "end"));
    require(cg_famname_write(mesh.boundaryNames[patch.tag].c_str()));
  }
  require(cg_close(file));
}

//----------------------------------------------------------------------------------------------------------------------
// Reading

struct Reading
{
  vtkNew<vtkHexBlockMeshReader> reader;
  vtkSmartPointer<vtkPartitionedDataSetCollection> output;
  std::vector<std::string> errors;
  std::vector<std::string> warnings;
};

/// Reads with the properties set so far.
inline void update(Reading& reading)
{
  const bsvtest::Messages messages(reading.reader, reading.errors, reading.warnings);
  // The pipeline tells once more that the reader failed.
  vtkNew<vtkCallbackCommand> silence;
  reading.reader->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, silence);
  reading.reader->Update();
  reading.output = vtkPartitionedDataSetCollection::SafeDownCast(reading.reader->GetOutputDataObject(0));
}

inline void read(Reading& reading, const std::string& fileName)
{
  reading.reader->SetFileName(fileName.c_str());
  update(reading);
}

/// Reads a file that must be refused: one error, an error code, nothing in the output. Returns the error.
inline std::string refusal(Reading& reading, const std::string& fileName)
{
  read(reading, fileName);
  EXPECT_EQ(reading.errors.size(), 1u) << fileName;
  EXPECT_EQ(reading.output->GetNumberOfPartitionedDataSets(), 0u) << fileName;
  EXPECT_NE(reading.reader->GetErrorCode(), 0u) << fileName;
  return reading.errors.empty() ? "" : reading.errors[0];
}

inline std::string refusal(const std::string& fileName)
{
  Reading reading;
  return refusal(reading, fileName);
}

} // namespace meshfiles

// SPDX-License-Identifier: BSD-3-Clause
#include "Quadflow/QuadflowFormat.h"

#include "IO/FileParts.h"
#include "IO/TextOutput.h"
#include "Quadflow/QuadflowSyntax.h"

#include <algorithm>

namespace bsv
{

using namespace quadflow;

namespace
{

/// A name as one word without blanks: bytes that would end it, '%' and '#' become %XX; an empty name becomes "-".
std::string encoded(const std::string& name)
{
  if (name.empty())
  {
    return "-";
  }
  static const char* digits = "0123456789ABCDEF";
  std::string result;
  for (const char c : name)
  {
    const auto byte = static_cast<unsigned char>(c);
    if (byte <= ' ' || byte == 127 || c == '%' || c == '#' || name == "-")
    {
      result += { '%', digits[byte >> 4], digits[byte & 15] };
    }
    else
    {
      result += c;
    }
  }
  return result;
}
void writeHeader(TextOutput text, const char* magic, const std::string& title, const QuadflowOptions& options)
{
  text << "#"
       << (title.empty() ? " Multi-block B-spline topology, dialect of BSplineVolume " BSPLINEVOLUME_VERSION
                           "; see quadflow_format.md."
                         : title)
       << "\n"
       << magic << " " << Version << "\n"
       << "dimension 3\nindex_base " << options.indexBase << "\nknots " << (options.unitKnots ? "unit" : "integer")
       << "\ncp_order ijk\n";
}

void writeTopology(TextOutput text, const QuadflowCase& all, int base)
{
  text << "counts vertices " << static_cast<int>(all.vertices.size()) << " edges " << static_cast<int>(all.edges.size())
       << " faces " << static_cast<int>(all.faces.size()) << " blocks " << static_cast<int>(all.blocks.size()) << "\n";
  int id = base;
  text << "VERTICES # id x y z\n";
  for (const QuadflowVertex& vertex : all.vertices)
  {
    text << id++ << " ";
    text.point(vertex.position.data());
  }
  id = base;
  text << "EDGES # id v0 v1 n class\n";
  for (const QuadflowEdge& edge : all.edges)
  {
    text << id++ << " " << edge.vertices[0] + base << " " << edge.vertices[1] + base << " " << edge.cells << " "
         << EdgeClassNames[static_cast<int>(edge.kind)];
    if (edge.kind == QuadflowEdgeClass::Extraordinary)
    {
      text << ":" << edge.valence;
    }
    text << "\n";
  }
  id = base;
  text << "FACES # id v00 v10 v01 v11 es0 es1 et0 et1 ns nt nblocks bc\n";
  for (const QuadflowFace& face : all.faces)
  {
    text << id++;
    for (const int vertex : face.vertices)
    {
      text << " " << vertex + base;
    }
    for (const int edge : face.edges)
    {
      text << " " << edge + base;
    }
    text << " " << face.cells[0] << " " << face.cells[1] << " " << face.blocks << " " << face.boundary << "\n";
  }
  id = base;
  text << "BLOCKS\n";
  for (const QuadflowBlock& block : all.blocks)
  {
    text << "block " << id++ << " type BSPLINE cells " << block.cells[0] << " " << block.cells[1] << " "
         << block.cells[2] << " zone " << encoded(block.name) << "\n v";
    for (const int vertex : block.vertices)
    {
      text << " " << vertex + base;
    }
    text << "\n e";
    for (int e = 0; e < 12; ++e)
    {
      text << " " << block.edges[e] + base << (block.edgeReversed[e] ? ":-1" : ":+1");
    }
    text << "\n f";
    for (int f = 0; f < 6; ++f)
    {
      text << " " << block.faces[f] + base << ":" << block.faceOrientations[f];
    }
    text << "\n";
  }
  text << "CONNECTIVITY # blockA faceA blockB faceB o T1 T2 T3\n";
  for (const QuadflowInterface& entry : all.interfaces)
  {
    const Interface& c = entry.contact;
    text << c.blockA + base << " " << c.faceA << " " << c.blockB + base << " " << c.faceB << " " << c.orientation;
    for (const int direction : entry.transform)
    {
      text << " " << direction;
    }
    text << "\n";
  }
  text << "BOUNDARY # block face bc\n";
  for (const QuadflowBoundaryFace& face : all.boundaryFaces)
  {
    text << face.block + base << " " << face.face << " " << face.boundary << "\n";
  }
  text << "BCTABLE # bc name\n";
  for (const QuadflowBoundaryName& boundary : all.boundaryNames)
  {
    text << boundary.id << " " << encoded(boundary.name) << "\n";
  }
}

Index pointCount(const BSplineVolume& volume)
{
  return Index(volume.count(0)) * volume.count(1) * volume.count(2);
}

/// @param report told the control points done, every now and then
void writeBlock(
  TextOutput text, const BSplineVolume& volume, int id, const QuadflowOptions& options, const PartReport& report)
{
  text << "block " << id << "\n degree " << volume.degree[0] << " " << volume.degree[1] << " " << volume.degree[2]
       << "\n ncp " << volume.count(0) << " " << volume.count(1) << " " << volume.count(2) << "\n";
  for (int d = 0; d < 3; ++d)
  {
    const std::vector<double>& knots = volume.knots[d];
    text << " " << KnotLabels[d];
    for (const double knot : knots)
    {
      text << " " << (options.unitKnots ? (knot - knots.front()) / (knots.back() - knots.front()) : knot);
    }
    text << "\n";
  }
  text << " points\n";
  const Index size = pointCount(volume);
  if (options.binary)
  {
    text.raw(&ByteOrderMark, 1);
  }
  for (Index first = 0; first < size; first += PointsPerReport)
  {
    const Index last = std::min(size, first + PointsPerReport);
    report(static_cast<double>(first));
    if (options.binary)
    {
      text.raw(volume.points + 3 * first, 3 * (last - first));
      continue;
    }
    for (Index i = first; i < last; ++i)
    {
      text.point(volume.points + 3 * i);
    }
  }
  if (options.binary)
  {
    text << "\n";
  }
}

/// Writes the rest of a file on which rank 0 is, each rank its blocks.
void writeGeometry(AtomicFile& file, const QuadflowCase& all, const QuadflowOptions& options, const Execution& run)
{
  const auto onFirst = [&](const std::string& text) {
    if (run.ranks->rank() == 0)
    {
      file.write(text);
    }
  };
  std::vector<FilePart> parts;
  for (std::size_t b = 0; b < all.blocks.size(); ++b)
  {
    const BSplineVolume& volume = all.blocks[b].volume;
    const int id = static_cast<int>(b) + options.indexBase;
    parts.push_back({ volume.rank, static_cast<double>(pointCount(volume)),
      [&volume, id, &options](
        OutputBuffer& out, const PartReport& report) { writeBlock(TextOutput(out), volume, id, options, report); } });
  }
  onFirst(std::string("GEOMETRY") + (options.binary ? std::string(" binary ") + ownByteOrder() : "") + "\n");
  writeParts(file, parts, run);
  onFirst("end\n");
}

std::string withoutExtension(const std::string& path)
{
  const std::size_t slash = path.rfind('/');
  const std::size_t dot = path.rfind('.');
  const std::size_t name = slash == std::string::npos ? 0 : slash + 1;
  return dot == std::string::npos || dot <= name ? path : path.substr(0, dot);
}
} // namespace

//------------------------------------------------------------------------------
void writeQuadflow(
  const QuadflowCase& all, const std::string& path, const QuadflowOptions& options, const Execution& run)
{
  if (options.indexBase != 0 && options.indexBase != 1)
  {
    throw Error("the index base must be 0 or 1, not " + std::to_string(options.indexBase));
  }
  const Ranks& ranks = *run.ranks;
  const auto onFirst = [&](const auto& action) {
    if (ranks.rank() == 0)
    {
      action();
    }
  };
  FileGroup files(run);
  if (!options.separateGeometry)
  {
    AtomicFile& topology = files.add(path);
    onFirst([&] {
      writeHeader(TextOutput(topology), Magic, all.title, options);
      writeTopology(TextOutput(topology), all, options.indexBase);
    });
    writeGeometry(topology, all, options, run);
  }
  else
  {
    const std::string geometryPath = withoutExtension(path) + ".bsp";
    if (geometryPath == path)
    {
      throw Error("'" + path + "': the extension .bsp is that of the geometry file");
    }
    // The topology appears last: it names the other file.
    AtomicFile& geometry = files.add(geometryPath);
    AtomicFile& topology = files.add(path);
    onFirst([&] {
      writeHeader(TextOutput(topology), Magic, all.title, options);
      writeTopology(TextOutput(topology), all, options.indexBase);
      TextOutput(topology) << "GEOMETRY file " << encoded(geometryPath.substr(folderOf(geometryPath).size()))
                           << "\nend\n";
      writeHeader(TextOutput(geometry), GeometryMagic, all.title, options);
      TextOutput(geometry) << "counts blocks " << static_cast<int>(all.blocks.size()) << "\n";
    });
    writeGeometry(geometry, all, options, run);
  }
  files.publish();
}

} // namespace bsv

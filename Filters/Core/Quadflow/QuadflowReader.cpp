// SPDX-License-Identifier: BSD-3-Clause
#include "Quadflow/QuadflowFormat.h"

#include "IO/Encodings.h"
#include "IO/RegularFile.h"
#include "IO/TextLines.h"
#include "Quadflow/QuadflowSyntax.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <string_view>

namespace bsv
{

using namespace quadflow;

namespace
{

constexpr int Any = std::numeric_limits<int>::max();

class QuadflowReader
{
public:
  QuadflowReader(const std::string& path, const QuadflowStorage& storage, const Execution& run, const Piece& piece)
    : Storage(storage)
    , Run(run)
    , Part(piece)
    , In(path)
  {
  }

  QuadflowCase read()
  {
    this->parse();
    this->Run.ranks->nextStep();
    checkQuadflowCase(this->All, this->In.path(), this->GeometryPath, this->Run);
    this->Run.report(1.0);
    return std::move(this->All);
  }

private:
  void parse()
  {
    this->header(this->In, Magic);
    this->counts();
    this->vertices();
    this->edges();
    this->faces();
    this->blocks();
    this->interfaces();
    this->boundaryFaces();
    this->boundaryNames();

    this->In.expect("GEOMETRY");
    const std::string_view where = this->In.atEnd() ? "" : this->In.word();
    if (where != "file")
    {
      this->encoding(this->In, where);
      this->geometry(this->In);
      this->finish(this->In);
    }
    else
    {
      const std::string name = this->In.name("file name");
      if (name.empty() || name == "." || name == ".." || name.find('/') != std::string::npos ||
        name.find('\0') != std::string::npos)
      {
        this->In.fail("the geometry file must lie in the same folder");
      }
      this->In.end();
      this->GeometryPath = folderOf(this->In.path()) + name;
      TextLines geometry(this->GeometryPath);
      this->header(geometry, GeometryMagic);
      geometry.next("counts");
      geometry.expect("counts");
      geometry.expect("blocks");
      const int blocks = static_cast<int>(this->All.blocks.size());
      geometry.integer("number of blocks", blocks, blocks);
      geometry.end();
      geometry.next("GEOMETRY");
      geometry.expect("GEOMETRY");
      this->encoding(geometry, geometry.word());
      this->geometry(geometry);
      this->finish(geometry);
      this->In.next("end");
      this->finish(this->In, true);
    }
  }

  void header(TextLines& in, const char* magic)
  {
    in.next(magic);
    in.expect(magic);
    in.expect(Version);
    in.end();
    in.next("dimension");
    in.expect("dimension");
    in.expect("3");
    in.end();
    in.next("index_base");
    in.expect("index_base");
    const int base = in.integer("index base", 0, 1);
    in.end();
    in.next("knots");
    in.expect("knots");
    const std::string_view scale = in.word();
    if (scale != "integer" && scale != "unit")
    {
      in.fail("'integer' or 'unit' expected, '" + std::string(scale.substr(0, 40)) + "' found");
    }
    const bool unit = scale == "unit";
    in.end();
    if (&in != &this->In && (base != this->Base || unit != this->UnitKnots))
    {
      in.fail("index base and knots are not those of '" + this->In.path() + "'");
    }
    this->Base = base;
    this->UnitKnots = unit;
    this->All.indexBase = base;
    in.next("cp_order");
    in.expect("cp_order");
    in.expect("ijk");
    in.end();
  }

  void counts()
  {
    this->In.next("counts");
    this->In.expect("counts");
    const auto count = [&](const char* what) {
      this->In.expect(what);
      return this->In.integer(what, 0, Any - 1);
    };
    const Index vertices = count("vertices");
    const Index edges = count("edges");
    const Index faces = count("faces");
    const Index blocks = count("blocks");
    this->In.end();
    // The shortest possible lines. The numbers are also those of memory that is asked for.
    if (8 * vertices + 15 * edges + 26 * faces + 130 * blocks > this->In.remaining())
    {
      this->In.fail(
        "the counts need more than the " + std::to_string(this->In.remaining()) + " bytes that follow in the file");
    }
    this->All.countsLine = this->In.line();
    this->All.vertices.resize(vertices);
    this->All.edges.resize(edges);
    this->All.faces.resize(faces);
    this->All.blocks.resize(blocks);
  }

  void section(const char* name)
  {
    this->In.next(name);
    this->In.expect(name);
    this->In.end();
  }

  /// The own id that begins a line: they count up.
  void ownId(TextLines& in, std::size_t index)
  {
    const int expected = static_cast<int>(index) + this->Base;
    in.integer("id", expected, expected);
  }

  int id(TextLines& in, const char* what, std::size_t count) { return this->id(in, in.word(), what, count); }
  int id(TextLines& in, std::string_view text, const char* what, std::size_t count)
  {
    return in.integer(text, what, this->Base, static_cast<int>(count) + this->Base - 1) - this->Base;
  }

  void vertices()
  {
    this->section("VERTICES");
    for (std::size_t i = 0; i < this->All.vertices.size(); ++i)
    {
      QuadflowVertex& vertex = this->All.vertices[i];
      this->In.next("a vertex");
      this->ownId(this->In, i);
      for (int c = 0; c < 3; ++c)
      {
        vertex.position[c] = this->In.number("coordinate");
      }
      this->In.end();
      vertex.line = this->In.line();
    }
  }

  void edges()
  {
    this->section("EDGES");
    for (std::size_t i = 0; i < this->All.edges.size(); ++i)
    {
      QuadflowEdge& edge = this->All.edges[i];
      this->In.next("an edge");
      this->ownId(this->In, i);
      edge.vertices[0] = this->id(this->In, "vertex", this->All.vertices.size());
      edge.vertices[1] = this->id(this->In, "vertex", this->All.vertices.size());
      edge.cells = this->In.integer("number of cells", 1, Any);
      std::string_view kind = this->In.word();
      const std::size_t colon = kind.find(':');
      const std::string_view valence = colon == std::string_view::npos ? "" : kind.substr(colon + 1);
      const std::string_view name = kind.substr(0, colon);
      const auto found = std::find(std::begin(EdgeClassNames), std::end(EdgeClassNames), name);
      edge.kind = static_cast<QuadflowEdgeClass>(found - std::begin(EdgeClassNames));
      const bool known = found != std::end(EdgeClassNames);
      if (!known || (edge.kind == QuadflowEdgeClass::Extraordinary) != (colon != std::string_view::npos))
      {
        this->In.fail("'" + std::string(kind.substr(0, 40)) +
          "' is no class of an edge: regular, boundary, extraordinary:<valence>, crease, planar");
      }
      if (edge.kind == QuadflowEdgeClass::Extraordinary)
      {
        edge.valence = this->In.integer(valence, "valence", 1, Any);
      }
      this->In.end();
      edge.line = this->In.line();
    }
  }

  void faces()
  {
    this->section("FACES");
    for (std::size_t i = 0; i < this->All.faces.size(); ++i)
    {
      QuadflowFace& face = this->All.faces[i];
      this->In.next("a face");
      this->ownId(this->In, i);
      for (int& vertex : face.vertices)
      {
        vertex = this->id(this->In, "vertex", this->All.vertices.size());
      }
      for (int& edge : face.edges)
      {
        edge = this->id(this->In, "edge", this->All.edges.size());
      }
      face.cells[0] = this->In.integer("number of cells", 1, Any);
      face.cells[1] = this->In.integer("number of cells", 1, Any);
      face.blocks = this->In.integer("number of blocks", 1, 2);
      face.boundary = this->In.integer("boundary", 0, Any);
      this->In.end();
      face.line = this->In.line();
    }
  }

  void blocks()
  {
    this->section("BLOCKS");
    for (std::size_t i = 0; i < this->All.blocks.size(); ++i)
    {
      QuadflowBlock& block = this->All.blocks[i];
      this->In.next("a block");
      this->In.expect("block");
      this->ownId(this->In, i);
      this->In.expect("type");
      this->In.expect("BSPLINE");
      this->In.expect("cells");
      for (int& cells : block.cells)
      {
        cells = this->In.integer("number of cells", 1, Any - MaxDegree);
      }
      this->In.expect("zone");
      block.name = this->In.name("name");
      this->In.end();
      block.line = this->In.line();

      this->In.next("v");
      this->In.expect("v");
      for (int& vertex : block.vertices)
      {
        vertex = this->id(this->In, "vertex", this->All.vertices.size());
      }
      this->In.end();
      this->In.next("e");
      this->In.expect("e");
      for (int e = 0; e < 12; ++e)
      {
        const auto [edge, sign] = this->pair("edge:sign");
        if (sign != "+1" && sign != "-1")
        {
          this->In.fail("edge:sign: +1 or -1 expected, '" + std::string(sign.substr(0, 40)) + "' found");
        }
        block.edges[e] = this->id(this->In, edge, "edge", this->All.edges.size());
        block.edgeReversed[e] = sign == "-1";
      }
      this->In.end();
      this->In.next("f");
      this->In.expect("f");
      for (int f = 0; f < 6; ++f)
      {
        const auto [face, orientation] = this->pair("face:orientation");
        block.faces[f] = this->id(this->In, face, "face", this->All.faces.size());
        block.faceOrientations[f] = this->In.integer(orientation, "orientation", 0, 7);
      }
      this->In.end();
    }
  }

  std::pair<std::string_view, std::string_view> pair(const char* what)
  {
    const std::string_view text = this->In.word();
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos)
    {
      this->In.fail(std::string(what) + " expected, '" + std::string(text.substr(0, 40)) + "' found");
    }
    return { text.substr(0, colon), text.substr(colon + 1) };
  }

  void interfaces()
  {
    this->section("CONNECTIVITY");
    for (this->In.next("BOUNDARY"); this->In.peek() != "BOUNDARY"; this->In.next("BOUNDARY"))
    {
      QuadflowInterface entry;
      Interface& c = entry.contact;
      c.blockA = this->id(this->In, "block", this->All.blocks.size());
      c.faceA = this->In.integer("face", 0, 5);
      c.blockB = this->id(this->In, "block", this->All.blocks.size());
      c.faceB = this->In.integer("face", 0, 5);
      c.orientation = this->In.integer("orientation", 0, 7);
      for (int& direction : entry.transform)
      {
        direction = this->In.integer("transform", -3, 3);
      }
      this->In.end();
      entry.line = this->In.line();
      this->All.interfaces.push_back(entry);
    }
    this->In.expect("BOUNDARY");
    this->In.end();
  }

  void boundaryFaces()
  {
    for (this->In.next("BCTABLE"); this->In.peek() != "BCTABLE"; this->In.next("BCTABLE"))
    {
      QuadflowBoundaryFace face;
      face.block = this->id(this->In, "block", this->All.blocks.size());
      face.face = this->In.integer("face", 0, 5);
      face.boundary = this->In.integer("boundary", 0, Any);
      this->In.end();
      face.line = this->In.line();
      this->All.boundaryFaces.push_back(face);
    }
    this->In.expect("BCTABLE");
    this->In.end();
  }

  void boundaryNames()
  {
    for (this->In.next("GEOMETRY"); this->In.peek() != "GEOMETRY"; this->In.next("GEOMETRY"))
    {
      QuadflowBoundaryName boundary;
      boundary.id = this->In.integer("boundary", 1, Any);
      boundary.name = this->In.name("name");
      this->In.end();
      boundary.line = this->In.line();
      this->All.boundaryNames.push_back(boundary);
    }
  }

  /// The rest of the line GEOMETRY, from its second word.
  void encoding(TextLines& in, std::string_view word)
  {
    this->Binary = !word.empty();
    if (this->Binary)
    {
      if (word != "binary")
      {
        in.fail("'binary', 'file' or nothing expected, '" + std::string(word.substr(0, 40)) + "' found");
      }
      const std::string_view order = in.word();
      if (order != LittleEndian && order != BigEndian)
      {
        in.fail("'little_endian' or 'big_endian' expected, '" + std::string(order.substr(0, 40)) + "' found");
      }
      this->SwapBytes = order != ownByteOrder();
    }
    in.end();
  }

  void rawNumbers(TextLines& in, double* to, Index count) const
  {
    in.raw(to, sizeof(double) * static_cast<std::size_t>(count));
    for (Index i = 0; this->SwapBytes && i < count; ++i)
    {
      char bytes[sizeof(double)];
      std::memcpy(bytes, to + i, sizeof(double));
      std::reverse(bytes, bytes + sizeof(double));
      std::memcpy(to + i, bytes, sizeof(double));
    }
  }

  /// @param points null if they are left out.
  void binaryPoints(TextLines& in, const std::string& block, double* points, Index size, double total) const
  {
    double mark = 0.0;
    this->rawNumbers(in, &mark, 1);
    if (mark != ByteOrderMark)
    {
      in.fail(block + ": the binary numbers do not begin with 1 in the byte order that is stated");
    }
    if (!points)
    {
      in.skipRaw(3 * Index(sizeof(double)) * size);
      return;
    }
    for (Index first = 0; first < size; first += PointsPerReport)
    {
      this->Run.report(std::max(0.0, 1.0 - static_cast<double>(in.remaining()) / total));
      const Index last = std::min(size, first + PointsPerReport);
      this->rawNumbers(in, points + 3 * first, 3 * (last - first));
      unsigned int faults = 0;
      for (Index i = 3 * first; i < 3 * last; ++i)
      {
        faults |= !(std::abs(points[i]) <= std::numeric_limits<double>::max());
      }
      for (Index i = 3 * first; faults != 0 && i < 3 * last; ++i)
      {
        if (!std::isfinite(points[i]))
        {
          in.fail(block + ": coordinate " + std::to_string(i % 3) + " of control point " + std::to_string(i / 3) +
            " is not finite");
        }
      }
    }
  }

  /// @param points null if they are left out.
  void textPoints(TextLines& in, double* points, Index size, double total) const
  {
    for (Index i = 0; i < size; ++i)
    {
      if (i % PointsPerReport == 0)
      {
        this->Run.report(std::max(0.0, 1.0 - static_cast<double>(in.remaining()) / total));
      }
      in.next("a control point");
      if (!points)
      {
        continue;
      }
      for (int c = 0; c < 3; ++c)
      {
        *points++ = in.number("coordinate");
      }
      in.end();
    }
  }

  void geometry(TextLines& in)
  {
    const double total = static_cast<double>(in.remaining()) + 1.0;
    std::vector<std::array<int, 3>> expected;
    for (const QuadflowBlock& block : this->All.blocks)
    {
      expected.push_back({ block.cells[0] + 3, block.cells[1] + 3, block.cells[2] + 3 });
    }
    const std::vector<int> owners = this->Part.owners(expected);
    for (std::size_t b = 0; b < this->All.blocks.size(); ++b)
    {
      QuadflowBlock& block = this->All.blocks[b];
      BSplineVolume& volume = block.volume;
      in.next("a block");
      in.expect("block");
      this->ownId(in, b);
      in.end();
      in.next("degree");
      in.expect("degree");
      for (int& degree : volume.degree)
      {
        degree = in.integer("degree", 1, MaxDegree);
      }
      in.end();
      in.next("ncp");
      in.expect("ncp");
      std::array<int, 3> counts{};
      // As text "0 0 0" and a line end, which the last line of the file may lack.
      const Index room = (in.remaining() + 1) / (this->Binary ? 24 : 6);
      Index size = 1;
      for (int d = 0; d < 3; ++d)
      {
        counts[d] = in.integer("number of control points", volume.degree[d] + 1, Any - 2 * MaxDegree);
        size = size > room / counts[d] ? room + 1 : size * counts[d];
      }
      in.end();
      if (size > room)
      {
        in.fail("block " + std::to_string(b + this->Base) + ": the control points need more than the " +
          std::to_string(in.remaining()) + " bytes that follow in the file");
      }
      for (int d = 0; d < 3; ++d)
      {
        this->knots(in, d, counts[d], block);
      }
      in.next("points");
      in.expect("points");
      in.end();
      block.pointsLine = in.line() + (this->Binary ? 0 : 1);
      double* points = owners[b] == this->Part.number ? this->Storage(static_cast<int>(b), counts) : nullptr;
      volume.points = points;
      volume.rank = owners[b];
      if (this->Binary)
      {
        this->binaryPoints(in, "block " + std::to_string(b + this->Base), points, size, total);
      }
      else
      {
        this->textPoints(in, points, size, total);
      }
    }
    for (QuadflowInterface& entry : this->All.interfaces)
    {
      Interface& c = entry.contact;
      const BSplineVolume& volume = this->All.blocks[c.blockA].volume;
      c.rangeA.hi = { volume.count(faceAxis(c.faceA, 0)) - 1, volume.count(faceAxis(c.faceA, 1)) - 1 };
    }
  }

  void knots(TextLines& in, int d, int count, QuadflowBlock& block)
  {
    in.next(KnotLabels[d]);
    in.expect(KnotLabels[d]);
    std::vector<double>& knots = block.volume.knots[d];
    const std::size_t expected = static_cast<std::size_t>(count) + block.volume.degree[d] + 1;
    while (!in.atEnd())
    {
      knots.push_back(in.number("knot"));
    }
    if (knots.size() != expected)
    {
      in.fail("block " + std::to_string(&block - this->All.blocks.data() + this->Base) + ": " +
        std::to_string(knots.size()) + " knots instead of " + std::to_string(expected));
    }
    const double cells = block.cells[d];
    for (double& knot : knots)
    {
      if (this->UnitKnots)
      {
        // Integer knots divided by their number come back as integers.
        const double nearest = std::round(knot * cells);
        const double slack = 4.0 * std::numeric_limits<double>::epsilon() * cells;
        knot = std::abs(knot * cells - nearest) <= slack ? nearest : knot * cells;
      }
    }
  }

  void finish(TextLines& in, bool atLine = false)
  {
    if (!atLine)
    {
      in.next("end");
    }
    in.expect("end");
    in.end();
  }

  QuadflowStorage Storage;
  Execution Run;
  Piece Part;
  TextLines In;
  std::string GeometryPath;
  int Base = 0;
  bool UnitKnots = false;
  bool Binary = false;
  bool SwapBytes = false;
  QuadflowCase All;
};

} // namespace

namespace
{

/// The comment in the first line, as far as it is one of reasonable length.
std::string titleOf(const std::string& path)
{
  std::ifstream stream(path, std::ios::binary);
  std::array<char, 512> line{};
  stream.getline(line.data(), line.size());
  std::string text(line.data());
  text.erase(0, startsWithMark(text) ? 3 : 0);
  if (!text.empty() && text.back() == '\r')
  {
    text.pop_back();
  }
  return stream && !text.empty() && text[0] == '#' ? text.substr(1) : std::string();
}

} // namespace

bool looksLikeQuadflow(const std::string& path)
{
  if (!isRegularFile(path))
  {
    return false;
  }
  // Comments may come first, but not more than this.
  std::vector<char> start(4096);
  std::ifstream stream(path, std::ios::binary);
  stream.read(start.data(), static_cast<std::streamsize>(start.size()));
  std::string head(start.data(), static_cast<std::size_t>(stream.gcount()));
  std::istringstream text(startsWithMark(head) ? head.substr(3) : head);
  std::string word;
  while (text >> word && word[0] == '#')
  {
    std::getline(text, word);
  }
  return word == Magic;
}

QuadflowCase readQuadflow(
  const std::string& path, const QuadflowStorage& storage, const Execution& run, const Piece& piece)
{
  QuadflowCase result = QuadflowReader(path, storage, run, piece).read();
  result.title = titleOf(path);
  return result;
}

} // namespace bsv

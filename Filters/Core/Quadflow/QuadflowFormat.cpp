// SPDX-License-Identifier: BSD-3-Clause
#include "Quadflow/QuadflowFormat.h"

#include "IO/AtomicFile.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <numeric>
#include <string_view>

#include <sys/stat.h>

namespace bsv
{

namespace
{

constexpr const char* Magic = "QFMB";
constexpr const char* GeometryMagic = "QFBSP";
constexpr const char* Version = "1.0";
/// Words for the byte orders of binary control points, and the number that precedes those of each block.
constexpr const char* LittleEndian = "little_endian";
constexpr const char* BigEndian = "big_endian";
constexpr double ByteOrderMark = 1.0;
/// Control points between two reports of progress.
constexpr Index PointsPerReport = 1 << 16;
constexpr const char* KnotLabels[3] = { "knots_i", "knots_j", "knots_k" };
constexpr const char* EdgeClassNames[5] = { "regular", "boundary", "extraordinary", "crease", "planar" };

const char* ownByteOrder()
{
  const std::uint16_t two = 2;
  unsigned char first;
  std::memcpy(&first, &two, 1);
  return first == 2 ? LittleEndian : BigEndian;
}

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

class Text
{
public:
  explicit Text(OutputBuffer& file)
    : File(file)
  {
  }

  Text& operator<<(const std::string& text)
  {
    this->File.write(text);
    return *this;
  }
  Text& operator<<(int value)
  {
    char* to = this->File.room(16);
    this->File.advance(std::to_chars(to, to + 16, value).ptr);
    return *this;
  }
  /// Shortest digits that read back to the same value.
  Text& operator<<(double value)
  {
    char* to = this->File.room(32);
    this->File.advance(std::to_chars(to, to + 32, value).ptr);
    return *this;
  }
  void point(const double* x)
  {
    char* to = this->File.room(100);
    for (int c = 0; c < 3; ++c)
    {
      to = std::to_chars(to, to + 32, x[c]).ptr;
      *to++ = c < 2 ? ' ' : '\n';
    }
    this->File.advance(to);
  }
  /// As they are in memory.
  void raw(const double* values, Index count)
  {
    this->File.write(reinterpret_cast<const char*>(values), sizeof(double) * static_cast<std::size_t>(count));
  }

private:
  OutputBuffer& File;
};

void writeHeader(Text text, const char* magic, const QuadflowOptions& options)
{
  text << "# Multi-block B-spline topology, dialect of BSplineVolume; see quadflow_format.md.\n"
       << magic << " " << Version << "\n"
       << "dimension 3\nindex_base " << options.indexBase << "\nknots " << (options.unitKnots ? "unit" : "integer")
       << "\ncp_order ijk\n";
}

void writeTopology(Text text, const QuadflowCase& all, int base)
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
void writeBlock(Text text, const BSplineVolume& volume, int id, const QuadflowOptions& options,
  const std::function<void(Index)>& report)
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
    report(first);
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

/// Writes the rest of a file on which rank 0 is, each rank its blocks, and finishes it. With several ranks they first
/// count their characters, to know the places of their blocks.
void writeGeometry(AtomicFile& file, const QuadflowCase& all, const QuadflowOptions& options, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  const bool first = ranks.rank() == 0;
  const bool several = ranks.size() > 1;
  double total = 1.0;
  for (const QuadflowBlock& block : all.blocks)
  {
    total += block.volume.rank == ranks.rank() ? static_cast<double>(pointCount(block.volume)) : 0.0;
  }
  const auto overOwn = [&](double from, double to, const auto& visit) {
    double done = 0.0;
    for (std::size_t b = 0; b < all.blocks.size(); ++b)
    {
      const BSplineVolume& volume = all.blocks[b].volume;
      if (volume.rank == ranks.rank())
      {
        visit(b, volume, static_cast<int>(b) + options.indexBase,
          [&](Index points) { run.report(from + (to - from) * (done + static_cast<double>(points)) / total); });
        done += static_cast<double>(pointCount(volume));
      }
    }
  };

  std::vector<Index> start; // of every block, and the end of the last
  ranks.together([&] {
    if (first)
    {
      Text(file) << "GEOMETRY" << (options.binary ? std::string(" binary ") + ownByteOrder() : "") << "\n";
    }
  });
  if (several)
  {
    start.assign(all.blocks.size() + 1, 0);
    Index position = 0;
    std::vector<Index> sizes(all.blocks.size(), 0);
    ranks.together([&] {
      CharacterCount written;
      position = first ? file.position() : 0;
      overOwn(0.0, 0.5, [&](std::size_t b, const BSplineVolume& volume, int id, const auto& report) {
        const Index before = written.count();
        writeBlock(Text(written), volume, id, options, report);
        sizes[b] = written.count() - before;
      });
    });
    ranks.share(sizes, [&](Index b) { return all.blocks[b].volume.rank; });
    std::copy(sizes.begin(), sizes.end(), start.begin() + 1);
    start[0] = ranks.gatherAll(std::vector<Index>{ position }).front();
    std::partial_sum(start.begin(), start.end(), start.begin());
  }
  ranks.together([&] {
    overOwn(several ? 0.5 : 0.0, 1.0, [&](std::size_t b, const BSplineVolume& volume, int id, const auto& report) {
      if (several)
      {
        file.seek(start[b]);
      }
      writeBlock(Text(file), volume, id, options, report);
    });
    if (first)
    {
      if (several)
      {
        file.seek(start.back());
      }
      Text(file) << "end\n";
    }
    file.finish();
  });
}

std::string withoutExtension(const std::string& path)
{
  const std::size_t slash = path.rfind('/');
  const std::size_t dot = path.rfind('.');
  const std::size_t name = slash == std::string::npos ? 0 : slash + 1;
  return dot == std::string::npos || dot <= name ? path : path.substr(0, dot);
}

std::string folderOf(const std::string& path)
{
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash + 1);
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
    ranks.together([&] {
      if (ranks.rank() == 0)
      {
        action();
      }
    });
  };
  AtomicFile topology(path, ranks);
  onFirst([&] {
    writeHeader(Text(topology), Magic, options);
    writeTopology(Text(topology), all, options.indexBase);
  });
  if (!options.separateGeometry)
  {
    writeGeometry(topology, all, options, run);
  }
  else
  {
    const std::string geometryPath = withoutExtension(path) + ".bsp";
    if (geometryPath == path)
    {
      throw Error("'" + path + "': the extension .bsp is that of the geometry file");
    }
    onFirst([&] {
      Text(topology) << "GEOMETRY file " << encoded(geometryPath.substr(folderOf(geometryPath).size())) << "\nend\n";
      topology.finish();
    });
    AtomicFile geometry(geometryPath, ranks);
    onFirst([&] {
      writeHeader(Text(geometry), GeometryMagic, options);
      Text(geometry) << "counts blocks " << static_cast<int>(all.blocks.size()) << "\n";
    });
    writeGeometry(geometry, all, options, run);
    ranks.together([&] { run.report(1.0); });
    onFirst([&] { geometry.publish(); });
  }
  ranks.together([&] { run.report(1.0); });
  onFirst([&] { topology.publish(); });
}

//------------------------------------------------------------------------------
namespace
{

/// Lines of a file without comments and empty ones, and the words on them.
class Lines
{
public:
  explicit Lines(const std::string& path)
    : Path(path)
    , File(std::fopen(path.c_str(), "rb"), &std::fclose)
    , Buffer(std::size_t(1) << 20)
  {
    struct stat status;
    if (!this->File || ::fstat(::fileno(this->File.get()), &status) != 0)
    {
      throw Error("Cannot open '" + path + "': " + std::strerror(errno));
    }
    if (!S_ISREG(status.st_mode))
    {
      throw Error("Cannot read '" + path + "': it is not a regular file");
    }
    this->Remaining = status.st_size;
  }

  const std::string& path() const { return this->Path; }
  int line() const { return this->Line; }
  /// Bytes after the current line.
  Index remaining() const { return this->Remaining; }

  [[noreturn]] void fail(const std::string& what) const
  {
    throw Error(this->Path + ", line " + std::to_string(this->Line) + ": " + what);
  }

  /// Goes to the next line that holds anything; `expected` says in the message what should have come.
  void next(const char* expected)
  {
    do
    {
      if (!this->nextRaw())
      {
        this->fail(std::string("the file ends, but ") + expected + " should follow");
      }
      this->skipBlanks();
    } while (this->At == this->End);
  }

  bool atEnd()
  {
    this->skipBlanks();
    return this->At == this->End;
  }

  /// Next word of the line, empty at its end.
  std::string_view word()
  {
    this->skipBlanks();
    const char* start = this->At;
    while (this->At != this->End && !isBlank(*this->At))
    {
      ++this->At;
    }
    return { start, static_cast<std::size_t>(this->At - start) };
  }

  /// The first word of the line without taking it.
  std::string_view peek()
  {
    const char* start = this->At;
    const std::string_view result = this->word();
    this->At = start;
    return result;
  }

  void expect(std::string_view text)
  {
    const std::string_view found = this->word();
    if (found != text)
    {
      this->fail("'" + std::string(text) + "' expected, '" + shown(found) + "' found");
    }
  }

  void end()
  {
    if (!this->atEnd())
    {
      this->fail("nothing more expected, '" + shown(this->word()) + "' found");
    }
  }

  int integer(const char* what, int first, int last) { return this->integer(this->word(), what, first, last); }

  int integer(std::string_view text, const char* what, int first, int last) const
  {
    int value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || stop != text.data() + text.size())
    {
      this->fail(std::string(what) + ": integer expected, '" + shown(text) + "' found");
    }
    if (value < first || value > last)
    {
      this->fail(std::string(what) + " " + std::to_string(value) +
        (last < first ? ": there are none" : " is not in " + std::to_string(first) + ".." + std::to_string(last)));
    }
    return value;
  }

  double number(const char* what)
  {
    this->skipBlanks();
    double value = 0.0;
    const auto [stop, error] = std::from_chars(this->At, this->End, value);
    if (error != std::errc() || !std::isfinite(value) || (stop != this->End && !isBlank(*stop)))
    {
      this->fail(std::string(what) + ": finite number expected, '" + shown(this->word()) + "' found");
    }
    this->At = stop;
    return value;
  }

  /// The bytes that follow the current line.
  void raw(void* to, std::size_t size)
  {
    char* bytes = static_cast<char*>(to);
    const std::size_t buffered = std::min(size, this->Last - this->First);
    std::memcpy(bytes, this->Buffer.data() + this->First, buffered);
    this->First += buffered;
    if (std::fread(bytes + buffered, 1, size - buffered, this->File.get()) != size - buffered)
    {
      if (std::ferror(this->File.get()))
      {
        throw Error("Cannot read '" + this->Path + "': " + std::strerror(errno));
      }
      this->fail("the file ends within binary numbers");
    }
    this->Remaining -= static_cast<Index>(size);
    // What was read of the line may have moved.
    this->At = this->End = nullptr;
  }

  /// Leaves out the bytes that follow the current line.
  void skipRaw(Index size)
  {
    if (size > this->Remaining)
    {
      this->fail("the file ends within binary numbers");
    }
    const Index buffered = std::min(size, static_cast<Index>(this->Last - this->First));
    this->First += static_cast<std::size_t>(buffered);
    if (size > buffered)
    {
      if (::fseeko(this->File.get(), size - buffered, SEEK_CUR) != 0)
      {
        throw Error("Cannot read '" + this->Path + "': " + std::strerror(errno));
      }
      this->Portion = SmallestPortion;
    }
    this->Remaining -= size;
    this->At = this->End = nullptr;
  }

  std::string name(const char* what)
  {
    const std::string_view text = this->word();
    if (text.empty())
    {
      this->fail(std::string(what) + " expected");
    }
    if (text == "-")
    {
      return "";
    }
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i)
    {
      if (text[i] != '%')
      {
        result += text[i];
        continue;
      }
      int byte = 0;
      const char* digits = text.data() + i + 1;
      const std::size_t left = text.size() - i - 1;
      if (left < 2 || std::from_chars(digits, digits + 2, byte, 16).ptr != digits + 2 || byte < 0)
      {
        this->fail(std::string(what) + ": '" + shown(text) + "' has a % without two hexadecimal digits");
      }
      result += static_cast<char>(byte);
      i += 2;
    }
    return result;
  }

private:
  static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

  /// Text from the file as it can stand in a message.
  static std::string shown(std::string_view text)
  {
    std::string result(text.substr(0, 40));
    for (char& c : result)
    {
      c = std::isprint(static_cast<unsigned char>(c)) ? c : '?';
    }
    return result + (text.size() > 40 ? ".." : "");
  }

  void skipBlanks()
  {
    while (this->At != this->End && isBlank(*this->At))
    {
      ++this->At;
    }
  }

  bool nextRaw()
  {
    const char* data = this->Buffer.data();
    const char* newline = nullptr;
    std::size_t searched = 0;
    while (true)
    {
      const char* start = data + this->First;
      newline = static_cast<const char*>(std::memchr(start + searched, '\n', this->Last - this->First - searched));
      if (newline || this->Finished)
      {
        break;
      }
      searched = this->Last - this->First;
      std::memmove(this->Buffer.data(), start, searched);
      this->First = 0;
      this->Last = searched;
      if (this->Last == this->Buffer.size())
      {
        constexpr std::size_t LongestLine = std::size_t(1) << 26;
        if (this->Last >= LongestLine)
        {
          ++this->Line;
          this->fail("the line is longer than " + std::to_string(LongestLine) + " bytes");
        }
        this->Buffer.resize(2 * this->Last);
      }
      data = this->Buffer.data();
      const std::size_t read = std::fread(this->Buffer.data() + this->Last, 1,
        std::min(this->Portion, this->Buffer.size() - this->Last), this->File.get());
      this->Portion = std::min(2 * this->Portion, this->Buffer.size());
      this->Last += read;
      this->Finished = read == 0;
      if (std::ferror(this->File.get()))
      {
        throw Error("Cannot read '" + this->Path + "': " + std::strerror(errno));
      }
    }
    const char* start = data + this->First;
    const char* stop = newline ? newline : data + this->Last;
    if (!newline && start == stop)
    {
      return false;
    }
    const std::size_t taken = static_cast<std::size_t>(stop - start) + (newline ? 1 : 0);
    this->First += taken;
    this->Remaining -= static_cast<Index>(taken);
    ++this->Line;
    const char* comment = static_cast<const char*>(std::memchr(start, '#', stop - start));
    this->At = start;
    this->End = comment ? comment : stop;
    return true;
  }

  std::string Path;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> File;
  std::vector<char> Buffer;
  /// Bytes to read next: few where the next thing may be to leave out many.
  static constexpr std::size_t SmallestPortion = std::size_t(1) << 14;
  std::size_t Portion = SmallestPortion;
  std::size_t First = 0;
  std::size_t Last = 0;
  bool Finished = false;
  Index Remaining = 0;
  int Line = 0;
  const char* At = nullptr;
  const char* End = nullptr;
};

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
    this->Run.ranks->together([this] { this->parse(); });
    checkQuadflowCase(this->All, this->In.path(), this->GeometryPath, this->Run);
    this->Run.ranks->together([this] { this->Run.report(1.0); });
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
      Lines geometry(this->GeometryPath);
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

  void header(Lines& in, const char* magic)
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
  void ownId(Lines& in, std::size_t index)
  {
    const int expected = static_cast<int>(index) + this->Base;
    in.integer("id", expected, expected);
  }

  int id(Lines& in, const char* what, std::size_t count) { return this->id(in, in.word(), what, count); }
  int id(Lines& in, std::string_view text, const char* what, std::size_t count)
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
  void encoding(Lines& in, std::string_view word)
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

  void rawNumbers(Lines& in, double* to, Index count) const
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
  void binaryPoints(Lines& in, const std::string& block, double* points, Index size, double total) const
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
  void textPoints(Lines& in, double* points, Index size, double total) const
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

  void geometry(Lines& in)
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

  void knots(Lines& in, int d, int count, QuadflowBlock& block)
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

  void finish(Lines& in, bool atLine = false)
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
  Lines In;
  std::string GeometryPath;
  int Base = 0;
  bool UnitKnots = false;
  bool Binary = false;
  bool SwapBytes = false;
  QuadflowCase All;
};

} // namespace

bool looksLikeQuadflow(const std::string& path)
{
  try
  {
    Lines in(path);
    in.next(Magic);
    return in.word() == Magic;
  }
  catch (const Error&)
  {
    return false;
  }
}

QuadflowCase readQuadflow(
  const std::string& path, const QuadflowStorage& storage, const Execution& run, const Piece& piece)
{
  return QuadflowReader(path, storage, run, piece).read();
}

} // namespace bsv

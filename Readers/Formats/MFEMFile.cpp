// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/BSplineVolumeFile.h"
#include "Formats/TextScanner.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <map>
#include <set>

namespace bsv
{

namespace
{

constexpr int Square = 3;
constexpr int Cube = 5;
/// Our corners (BlockTopology.h) in MFEM's order of the vertices of a cube.
constexpr int CubeCorners[8] = { 0, 1, 3, 2, 4, 5, 7, 6 };
/// MFEM's order of the faces of a cube; of each the vertex where its numbering starts, and those at the ends of its
/// first and second axis, as our face and corners.
struct CubeFace
{
  int face, origin, first, second;
};
constexpr CubeFace CubeFaces[6] = { { 4, 2, 3, 0 }, { 2, 0, 1, 4 }, { 1, 1, 3, 5 }, { 3, 3, 2, 7 }, { 0, 2, 0, 6 },
  { 5, 4, 5, 6 } };

struct KnotVector
{
  int degree = 0;
  std::vector<double> knots;

  int count() const { return static_cast<int>(this->knots.size()) - this->degree - 1; }
  bool operator==(const KnotVector& other) const { return this->degree == other.degree && this->knots == other.knots; }
  KnotVector reversed() const
  {
    KnotVector result{ this->degree, {} };
    for (auto knot = this->knots.rbegin(); knot != this->knots.rend(); ++knot)
    {
      result.knots.push_back(this->knots.front() + (this->knots.back() - *knot));
    }
    return result;
  }
};

/// The vertices of an edge or a face, ascending.
template <std::size_t N>
std::array<int, N> sorted(std::array<int, N> vertices)
{
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

class Parser
{
public:
  Parser(const std::string& text, const std::string& fileName, const Execution& run)
    : In(text, fileName, '#')
  {
    this->In.reportTo(run);
    this->readNames(text);
  }

  BSplineVolumeFileContent parse()
  {
    this->Content.format = "MFEM NURBS mesh";
    this->readHeader();
    this->readElements();
    this->readBoundary();
    this->readEdges();
    this->readVertices();
    this->findFaces();
    this->Content.blocks.resize(this->Elements.size());
    const std::string form = this->In.word("'knotvectors' or 'patches'");
    if (form == "patches")
    {
      this->readPatches();
    }
    else if (form == "knotvectors")
    {
      this->readKnotVectors();
      this->readNumberedPoints();
    }
    else
    {
      this->In.fail("'" + form + "' instead of 'knotvectors' or 'patches'");
    }
    if (!this->In.atEnd())
    {
      this->In.fail("the mesh is complete before '" + this->In.peek() + "'");
    }
    this->setContacts();
    return std::move(this->Content);
  }

private:
  struct Element
  {
    int attribute;
    std::array<int, 8> vertices; ///< of our corners
    int line;
  };
  struct BoundaryElement
  {
    int attribute;
    std::array<int, 4> vertices;
    int line;
  };
  struct Edge
  {
    int knotVector;
    bool reversed; ///< whether the knots run from the higher vertex to the lower
    Index firstPoint = 0;
  };
  struct FaceUse
  {
    int block, face;
  };
  struct Face
  {
    std::vector<FaceUse> uses;
    int origin, first, second; ///< vertices
    Index firstPoint = 0;
    Index firstAxisPoints = 0;
  };

  /// Names of attributes, which our writer keeps in comments: "# boundary attribute 1: wall".
  void readNames(const std::string& text)
  {
    static constexpr const char* Kinds[2] = { "# element attribute ", "# boundary attribute " };
    for (std::size_t at = 0; at < text.size();)
    {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      // They come first. Other programs may have changed the ends of lines.
      const auto isBlank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
      const bool blank = std::all_of(text.begin() + at, text.begin() + end, isBlank);
      if (!blank && text[at] != '#' && text.compare(at, 4, "MFEM") != 0)
      {
        return;
      }
      for (int kind = 0; kind < 2; ++kind)
      {
        const std::string start = Kinds[kind];
        if (text.compare(at, start.size(), start) == 0)
        {
          const std::string entry = text.substr(at + start.size(), end - at - start.size());
          const std::size_t colon = entry.find(": ");
          int attribute = 0;
          const auto [stop, error] =
            std::from_chars(entry.data(), entry.data() + std::min(colon, entry.size()), attribute);
          if (colon != std::string::npos && error == std::errc() && stop == entry.data() + colon)
          {
            std::string& name = this->Names[kind][attribute];
            name = entry.substr(colon + 2);
            name.erase(name.find_last_not_of(" \t\r") + 1);
          }
        }
      }
      at = end + 1;
    }
  }

  /// Spacing functions of version 1.1 tell how MFEM refines knot spans; the shape does not depend on them.
  void skipSpacing()
  {
    this->keyword("spacing");
    const int count = this->In.integer("the number of spacing functions", 0, std::numeric_limits<int>::max());
    for (int n = 0; n < count; ++n)
    {
      this->In.integer("a knot vector", 0, std::numeric_limits<int>::max());
      this->In.integer("a type of spacing", 0, std::numeric_limits<int>::max());
      const int integers = this->In.integer("the number of integers", 0, 1 << 20);
      const int reals = this->In.integer("the number of reals", 0, 1 << 20);
      for (int i = 0; i < integers; ++i)
      {
        this->In.next<int>("an integer of a spacing function");
      }
      for (int i = 0; i < reals; ++i)
      {
        this->In.next<double>("a number of a spacing function");
      }
    }
    if (count > 0)
    {
      this->Content.others.emplace_back("spacing function", count);
    }
  }

  void keyword(const char* expected)
  {
    const std::string word = this->In.word(expected);
    if (word != expected)
    {
      this->In.fail("'" + word + "' instead of '" + expected + "'");
    }
  }

  std::string label(std::size_t block) const { return "patch " + std::to_string(block + 1); }

  void checkCount(const char* what, Index numbers, int numbersEach)
  {
    this->In.expect(static_cast<double>(numbers) * numbersEach, what);
  }

  void readHeader()
  {
    const std::string title = this->In.restOfLine();
    if (title.rfind("MFEM NURBS NC-patch mesh", 0) == 0)
    {
      this->In.fail("'" + title + "' has patches that do not meet face to face, which is not supported; only 'MFEM " +
        "NURBS mesh v1.0' is read");
    }
    this->Spacing = title == "MFEM NURBS mesh v1.1";
    if (title != "MFEM NURBS mesh v1.0" && !this->Spacing)
    {
      this->In.fail("'" + title.substr(0, 60) + "' is not supported, only 'MFEM NURBS mesh v1.0' and 'v1.1'");
    }
    this->keyword("dimension");
    const int dimension = this->In.integer("the dimension", 1, 3);
    if (dimension != 3)
    {
      this->In.fail("the mesh has dimension " + std::to_string(dimension) + "; only volumes (3) are read");
    }
  }

  template <std::size_t N>
  std::array<int, N> readVertexList(const char* what)
  {
    std::array<int, N> vertices;
    for (int& vertex : vertices)
    {
      vertex = this->In.integer("a vertex", 0, std::numeric_limits<int>::max());
    }
    const std::array<int, N> order = sorted(vertices);
    const auto twice = std::adjacent_find(order.begin(), order.end());
    if (twice != order.end())
    {
      this->In.fail(std::string(what) + " has vertex " + std::to_string(*twice) + " twice");
    }
    return vertices;
  }

  int readGeometry(const char* what, int expected, const char* name)
  {
    constexpr int Largest = std::numeric_limits<int>::max();
    const int attribute = this->In.integer("an attribute", -Largest, Largest);
    const int geometry = this->In.integer("a geometry type", 0, Largest);
    if (geometry != expected)
    {
      this->In.fail(std::string(what) + " has geometry type " + std::to_string(geometry) + "; only " + name + " (" +
        std::to_string(expected) + ") is supported");
    }
    return attribute;
  }

  void readElements()
  {
    this->keyword("elements");
    const int count = this->In.integer("the number of elements", 0, std::numeric_limits<int>::max());
    this->checkCount("elements", count, 10);
    this->Elements.resize(count);
    for (Element& element : this->Elements)
    {
      element.attribute = this->readGeometry("an element", Cube, "CUBE");
      const std::array<int, 8> vertices = this->readVertexList<8>("an element");
      element.line = this->In.line();
      for (int v = 0; v < 8; ++v)
      {
        element.vertices[CubeCorners[v]] = vertices[v];
      }
    }
  }

  void readBoundary()
  {
    this->keyword("boundary");
    const int count = this->In.integer("the number of boundary elements", 0, std::numeric_limits<int>::max());
    this->checkCount("boundary elements", count, 6);
    this->Boundary.resize(count);
    for (BoundaryElement& element : this->Boundary)
    {
      element.attribute = this->readGeometry("a boundary element", Square, "SQUARE");
      element.vertices = this->readVertexList<4>("a boundary element");
      element.line = this->In.line();
    }
  }

  void readEdges()
  {
    this->keyword("edges");
    const int count = this->In.integer("the number of edges", 0, std::numeric_limits<int>::max());
    this->checkCount("edges", count, 3);
    for (int e = 0; e < count; ++e)
    {
      // A negative number -1 - k says that knot vector k runs backwards.
      const int number = this->In.next<int>("the knot vector of an edge");
      const std::array<int, 2> ends = this->readVertexList<2>("an edge");
      Edge edge{ number < 0 ? -1 - number : number, (number < 0) != (ends[0] > ends[1]) };
      if (!this->EdgeAt.emplace(sorted(ends), e).second)
      {
        this->In.fail(
          "the edge from vertex " + std::to_string(ends[0]) + " to " + std::to_string(ends[1]) + " is listed twice");
      }
      this->Edges.push_back(edge);
    }
  }

  void readVertices()
  {
    this->keyword("vertices");
    this->Vertices = this->In.integer("the number of vertices", 0, std::numeric_limits<int>::max());
    const auto check = [&](int vertex, int line, const char* what) {
      if (vertex >= this->Vertices)
      {
        this->In.failAt(line,
          std::string(what) + " has vertex " + std::to_string(vertex) + ", but there are only " +
            std::to_string(this->Vertices));
      }
    };
    for (const Element& element : this->Elements)
    {
      for (const int vertex : element.vertices)
      {
        check(vertex, element.line, "the element");
      }
    }
    for (const BoundaryElement& element : this->Boundary)
    {
      for (const int vertex : element.vertices)
      {
        check(vertex, element.line, "the boundary element");
      }
    }
  }

  void findFaces()
  {
    for (std::size_t b = 0; b < this->Elements.size(); ++b)
    {
      const Element& element = this->Elements[b];
      for (const CubeFace& at : CubeFaces)
      {
        const auto found = this->FaceAt.emplace(sorted(this->faceVertices(b, at.face)), this->Faces.size());
        if (found.second)
        {
          this->Faces.push_back(
            { {}, element.vertices[at.origin], element.vertices[at.first], element.vertices[at.second] });
        }
        Face& face = this->Faces[found.first->second];
        face.uses.push_back({ static_cast<int>(b), at.face });
        if (face.uses.size() > 2)
        {
          this->In.failAt(element.line, "more than two patches have the same face");
        }
        if (face.uses.size() == 2 && this->orientation(face) < 0)
        {
          this->In.failAt(element.line, "two patches share a face, but have its vertices in another order");
        }
      }
    }
  }

  /// Vertices of a face's corners (0,0), (1,0), (0,1), (1,1).
  std::array<int, 4> faceVertices(std::size_t block, int face) const
  {
    std::array<int, 4> vertices;
    for (int c = 0; c < 4; ++c)
    {
      vertices[c] = this->Elements[block].vertices[faceCorner(face, c & 1, c >> 1)];
    }
    return vertices;
  }

  /// Code from the first to the second use of a face, or -1 if there is none.
  int orientation(const Face& face) const
  {
    const std::array<int, 4> a = this->faceVertices(face.uses[0].block, face.uses[0].face);
    const std::array<int, 4> b = this->faceVertices(face.uses[1].block, face.uses[1].face);
    for (int o = 0; o < 8; ++o)
    {
      bool equal = true;
      for (int c = 0; c < 4; ++c)
      {
        const std::array<int, 2> m = mapFacePoint(o, c & 1, c >> 1, 1, 1);
        equal = equal && a[c] == b[m[0] + 2 * m[1]];
      }
      if (equal)
      {
        return o;
      }
    }
    return -1;
  }

  KnotVector readKnotVector()
  {
    KnotVector result;
    result.degree = this->In.integer("the order of a knot vector", 1, MaxDegree);
    const int count =
      this->In.integer("the number of control points", result.degree + 1, std::numeric_limits<int>::max() / 2);
    this->checkCount("control points", Index(count) + result.degree + 1, 1);
    result.knots.resize(static_cast<std::size_t>(count) + result.degree + 1);
    for (std::size_t i = 0; i < result.knots.size(); ++i)
    {
      result.knots[i] = this->In.next<double>("a knot");
      if (i > 0 && result.knots[i] < result.knots[i - 1])
      {
        this->In.fail("a knot is smaller than the one before it");
      }
    }
    return result;
  }

  double readWeight()
  {
    const double weight = this->In.next<double>("a weight");
    if (!(weight > 0.0))
    {
      this->In.fail("the weight " + std::to_string(weight) + " is not positive");
    }
    return weight;
  }

  void setKnots(std::size_t block, int direction, KnotVector knots)
  {
    BSplineVolume& volume = this->Content.blocks[block].volume;
    volume.degree[direction] = knots.degree;
    volume.knots[direction] = std::move(knots.knots);
  }

  void check(std::size_t block)
  {
    try
    {
      checkBSplineVolume(this->Content.blocks[block].volume, this->label(block));
    }
    catch (const Error& error)
    {
      this->In.fail(std::string("before this line: ") + error.what());
    }
  }

  void readPatches()
  {
    for (std::size_t b = 0; b < this->Elements.size(); ++b)
    {
      BSplineVolumeFileBlock& block = this->Content.blocks[b];
      this->keyword("knotvectors");
      this->In.integer("the number of knot vectors of a patch", 3, 3);
      double points = 1.0;
      for (int d = 0; d < 3; ++d)
      {
        this->setKnots(b, d, this->readKnotVector());
        points *= block.volume.count(d);
      }
      this->check(b);
      this->keyword("dimension");
      this->In.integer("the dimension of a patch", 3, 3);
      const std::string kind = this->In.word("'controlpoints'");
      const bool homogeneous = kind == "controlpoints" || kind == "controlpoints_homogeneous";
      if (!homogeneous && kind != "controlpoints_cartesian")
      {
        this->In.fail("'" + kind + "' instead of 'controlpoints'");
      }
      this->In.expect(4.0 * points, "control points");
      block.points.resize(static_cast<std::size_t>(points));
      block.weights.resize(block.points.size());
      for (std::size_t i = 0; i < block.points.size(); ++i)
      {
        for (int c = 0; c < 3; ++c)
        {
          block.points[i][c] = this->In.next<double>("a coordinate");
        }
        block.weights[i] = this->readWeight();
        if (homogeneous)
        {
          block.points[i] /= block.weights[i];
          if (!block.points[i].allFinite())
          {
            this->In.fail("the point divided by its weight is not finite");
          }
        }
      }
    }
    for (const Face& face : this->Faces)
    {
      this->checkSharedKnots(face);
    }
  }

  /// The two patches at a face must have the same degrees and numbers of control points there.
  void checkSharedKnots(const Face& face) const
  {
    if (face.uses.size() < 2)
    {
      return;
    }
    const int o = this->orientation(face);
    const FaceUse& a = face.uses[0];
    const FaceUse& b = face.uses[1];
    const BSplineVolume& volumeA = this->Content.blocks[a.block].volume;
    const BSplineVolume& volumeB = this->Content.blocks[b.block].volume;
    for (int axis = 0; axis < 2; ++axis)
    {
      const int da = faceAxis(a.face, axis);
      const int db = faceAxis(b.face, swapsAxes(o) ? 1 - axis : axis);
      if (volumeA.degree[da] != volumeB.degree[db] || volumeA.count(da) != volumeB.count(db))
      {
        this->In.fail("before this line: " + this->label(a.block) + " and " + this->label(b.block) +
          " share a face, but have there degree " + std::to_string(volumeA.degree[da]) + " and " +
          std::to_string(volumeB.degree[db]) + ", " + std::to_string(volumeA.count(da)) + " and " +
          std::to_string(volumeB.count(db)) + " control points");
      }
    }
  }

  void readKnotVectors()
  {
    const int count = this->In.integer("the number of knot vectors", 0, std::numeric_limits<int>::max());
    this->checkCount("knot vectors", count, 6);
    std::vector<KnotVector> knotVectors(count);
    for (KnotVector& knots : knotVectors)
    {
      knots = this->readKnotVector();
    }
    if (this->Spacing)
    {
      this->skipSpacing();
    }
    for (const Edge& edge : this->Edges)
    {
      if (edge.knotVector >= count)
      {
        this->In.fail("an edge has knot vector " + std::to_string(edge.knotVector) + ", but there are only " +
          std::to_string(count));
      }
    }
    for (std::size_t b = 0; b < this->Elements.size(); ++b)
    {
      for (int d = 0; d < 3; ++d)
      {
        for (int e = 0; e < 4; ++e)
        {
          const std::array<int, 2> ends = this->edgeVertices(b, edgeIndex(d, e & 1, e >> 1));
          const Edge& edge = this->edge(b, ends);
          const KnotVector& plain = knotVectors[edge.knotVector];
          KnotVector knots = edge.reversed != (ends[0] > ends[1]) ? plain.reversed() : plain;
          if (e == 0)
          {
            this->setKnots(b, d, std::move(knots));
          }
          else if (!(knots ==
                     KnotVector{ this->Content.blocks[b].volume.degree[d], this->Content.blocks[b].volume.knots[d] }))
          {
            this->In.fail("before this line: the edges of " + this->label(b) + " in direction " + std::to_string(d) +
              " have different knot vectors; one of them is from vertex " + std::to_string(ends[0]) + " to " +
              std::to_string(ends[1]));
          }
        }
      }
      this->check(b);
    }

    this->Points = this->Vertices;
    // Returns the number of the first of so many points.
    const auto add = [&](double points) {
      this->In.expect(3.0 * (static_cast<double>(this->Points) + points), "control points");
      this->Points += static_cast<Index>(points);
      return this->Points - static_cast<Index>(points);
    };
    for (Edge& edge : this->Edges)
    {
      edge.firstPoint = add(knotVectors[edge.knotVector].count() - 2);
    }
    for (Face& face : this->Faces)
    {
      const FaceUse& use = face.uses.front();
      const BSplineVolume& volume = this->Content.blocks[use.block].volume;
      const std::array<int, 2> inside{ volume.count(faceAxis(use.face, 0)) - 2,
        volume.count(faceAxis(use.face, 1)) - 2 };
      const bool swapped = this->cornerAt(use, face.first)[0] == this->cornerAt(use, face.origin)[0];
      face.firstPoint = add(double(inside[0]) * inside[1]);
      face.firstAxisPoints = inside[swapped ? 1 : 0];
    }
    for (const BSplineVolumeFileBlock& block : this->Content.blocks)
    {
      const auto inside = [&](int d) { return double(block.volume.count(d) - 2); };
      this->BlockPoints.push_back(add(inside(0) * inside(1) * inside(2)));
    }
  }

  /// Vertices at the start and the end of an edge of a block.
  std::array<int, 2> edgeVertices(std::size_t block, int edge) const
  {
    return { this->Elements[block].vertices[edgeCorner(edge, 0)], this->Elements[block].vertices[edgeCorner(edge, 1)] };
  }

  const Edge& edge(std::size_t block, const std::array<int, 2>& ends) const
  {
    const auto found = this->EdgeAt.find(sorted(ends));
    if (found == this->EdgeAt.end())
    {
      this->In.fail("before this line: " + this->label(block) + " has an edge from vertex " + std::to_string(ends[0]) +
        " to " + std::to_string(ends[1]) + ", which the section 'edges' does not list");
    }
    return this->Edges[found->second];
  }

  /// Position (0 or 1 along either axis) of a vertex on the face of a block.
  std::array<int, 2> cornerAt(const FaceUse& use, int vertex) const
  {
    const std::array<int, 4> vertices = this->faceVertices(use.block, use.face);
    const int c = static_cast<int>(std::find(vertices.begin(), vertices.end(), vertex) - vertices.begin());
    return { c & 1, c >> 1 };
  }

  /// Numbers of a block's control points, first direction fastest.
  std::vector<Index> numbers(int b) const
  {
    const BSplineVolume& volume = this->Content.blocks[b].volume;
    const Ijk counts{ volume.count(0), volume.count(1), volume.count(2) };
    const Ijk inside{ counts[0] - 2, counts[1] - 2, counts[2] - 2 };
    const Index strides[3] = { 1, counts[0], Index(counts[0]) * counts[1] };
    std::vector<Index> result(static_cast<std::size_t>(strides[2] * counts[2]));
    const auto end = [&](int d, int side) { return side ? strides[d] * (counts[d] - 1) : Index(0); };

    for (int corner = 0; corner < 8; ++corner)
    {
      result[end(0, cornerSide(corner, 0)) + end(1, cornerSide(corner, 1)) + end(2, cornerSide(corner, 2))] =
        this->Elements[b].vertices[corner];
    }
    for (int e = 0; e < 12; ++e)
    {
      const std::array<int, 2> ends = this->edgeVertices(b, e);
      const int d = edgeDirection(e);
      const Index start = end(faceAxis(2 * d, 0), edgeSide(e, 0)) + end(faceAxis(2 * d, 1), edgeSide(e, 1));
      const Index first = this->edge(b, ends).firstPoint;
      for (int i = 0; i < inside[d]; ++i)
      {
        result[start + (i + 1) * strides[d]] = first + (ends[0] < ends[1] ? i : inside[d] - 1 - i);
      }
    }
    for (int f = 0; f < 6; ++f)
    {
      const Face& face = this->Faces[this->FaceAt.at(sorted(this->faceVertices(b, f)))];
      const std::array<int, 2> origin = this->cornerAt({ b, f }, face.origin);
      const bool swapped = this->cornerAt({ b, f }, face.first)[0] == origin[0];
      const int ds = faceAxis(f, 0);
      const int dt = faceAxis(f, 1);
      const Index start = end(faceDirection(f), faceSide(f));
      for (int t = 0; t < inside[dt]; ++t)
      {
        for (int s = 0; s < inside[ds]; ++s)
        {
          const Index fromS = origin[0] ? inside[ds] - 1 - s : s;
          const Index fromT = origin[1] ? inside[dt] - 1 - t : t;
          result[start + (s + 1) * strides[ds] + (t + 1) * strides[dt]] =
            face.firstPoint + (swapped ? fromT + face.firstAxisPoints * fromS : fromS + face.firstAxisPoints * fromT);
        }
      }
    }
    Index number = this->BlockPoints[b];
    for (int k = 1; k <= inside[2]; ++k)
    {
      for (int j = 1; j <= inside[1]; ++j)
      {
        for (int i = 1; i <= inside[0]; ++i)
        {
          result[i + j * strides[1] + k * strides[2]] = number++;
        }
      }
    }
    return result;
  }

  void readNumberedPoints()
  {
    const std::string section = this->In.word("'weights'");
    std::vector<double> weights(static_cast<std::size_t>(this->Points), 1.0);
    if (section == "weights")
    {
      for (double& weight : weights)
      {
        weight = this->readWeight();
      }
    }
    else if (section != "unitweights" && section != "autoweights")
    {
      this->In.fail("section '" + section + "' is not supported; 'weights' should follow");
    }
    this->keyword("FiniteElementSpace");
    this->keyword("FiniteElementCollection:");
    const std::string collection = this->In.word("the name of the collection");
    this->checkCollection(collection);
    this->keyword("VDim:");
    this->In.integer("VDim", 3, 3);
    this->keyword("Ordering:");
    const bool interleaved = this->In.integer("Ordering", 0, 1) == 1;

    const bool byPatch = this->In.peek() == "NURBS_patches";
    std::vector<Vec3> points(byPatch ? 0 : weights.size());
    if (byPatch)
    {
      this->In.word("");
    }
    for (std::size_t i = 0; i < 3 * points.size(); ++i)
    {
      const double value = this->In.next<double>("a coordinate");
      (interleaved ? points[i / 3][i % 3] : points[i % points.size()][i / points.size()]) = value;
    }
    for (std::size_t b = 0; b < this->Elements.size(); ++b)
    {
      BSplineVolumeFileBlock& block = this->Content.blocks[b];
      for (const Index number : this->numbers(static_cast<int>(b)))
      {
        Vec3 point;
        for (int c = 0; c < 3; ++c)
        {
          point[c] = byPatch ? this->In.next<double>("a coordinate") : points[number][c];
        }
        block.points.push_back(point);
        block.weights.push_back(weights[number]);
      }
    }
  }

  /// Coordinates of another degree than the knots' would be numbered differently.
  void checkCollection(const std::string& collection)
  {
    if (collection == "NURBS")
    {
      return;
    }
    for (const BSplineVolumeFileBlock& block : this->Content.blocks)
    {
      for (const int degree : block.volume.degree)
      {
        if (collection != "NURBS" + std::to_string(degree))
        {
          this->In.fail(
            "the collection '" + collection + "' does not fit knot vectors of order " + std::to_string(degree));
        }
      }
    }
  }

  void setContacts()
  {
    for (std::size_t b = 0; b < this->Elements.size(); ++b)
    {
      const auto named = this->Names[0].find(this->Elements[b].attribute);
      this->Content.blocks[b].name = named != this->Names[0].end() ? named->second : "Patch " + std::to_string(b + 1);
      this->Content.blocks[b].attribute = this->Elements[b].attribute;
    }
    for (const Face& face : this->Faces)
    {
      if (face.uses.size() == 2)
      {
        Interface contact;
        contact.blockA = face.uses[0].block;
        contact.faceA = face.uses[0].face;
        contact.blockB = face.uses[1].block;
        contact.faceB = face.uses[1].face;
        contact.orientation = this->orientation(face);
        this->Content.interfaces.push_back(contact);
      }
    }
    std::map<int, int> tags;
    for (const BoundaryElement& element : this->Boundary)
    {
      tags.emplace(element.attribute, 0);
    }
    for (auto& tag : tags)
    {
      tag.second = static_cast<int>(this->Content.boundaryNames.size());
      const auto named = this->Names[1].find(tag.first);
      this->Content.boundaryNames.push_back(
        named != this->Names[1].end() ? named->second : "boundary " + std::to_string(tag.first));
    }
    std::set<std::size_t> seen;
    int inner = 0;
    for (const BoundaryElement& element : this->Boundary)
    {
      const auto found = this->FaceAt.find(sorted(element.vertices));
      if (found == this->FaceAt.end())
      {
        this->In.failAt(element.line, "the boundary element is no face of any element");
      }
      const Face& face = this->Faces[found->second];
      if (face.uses.size() == 2)
      {
        ++inner;
        continue;
      }
      if (!seen.insert(found->second).second)
      {
        this->In.failAt(element.line, "the boundary element is listed twice");
      }
      BoundaryPatch patch;
      patch.block = face.uses[0].block;
      patch.face = face.uses[0].face;
      patch.tag = tags.at(element.attribute);
      this->Content.boundaries.push_back(patch);
    }
    if (inner > 0)
    {
      this->Content.others.emplace_back("boundary element between two patches", inner);
    }
  }

  TextScanner In;
  bool Spacing = false;
  /// By attribute, of elements and of boundary elements.
  std::array<std::map<int, std::string>, 2> Names;
  BSplineVolumeFileContent Content;
  std::vector<Element> Elements;
  std::vector<BoundaryElement> Boundary;
  std::vector<Edge> Edges;
  std::map<std::array<int, 2>, int> EdgeAt;
  std::vector<Face> Faces;
  std::map<std::array<int, 4>, std::size_t> FaceAt;
  int Vertices = 0;
  Index Points = 0;
  /// Number of the first control point inside every block.
  std::vector<Index> BlockPoints;
};

} // namespace

BSplineVolumeFileContent parseMFEMMesh(const std::string& text, const std::string& fileName, const Execution& run)
{
  return Parser(text, fileName, run).parse();
}

} // namespace bsv

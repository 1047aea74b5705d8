// SPDX-License-Identifier: BSD-3-Clause
// B-spline volumes from GoTools g2 files and MFEM NURBS meshes: written by the tests, real ones, and damaged ones.
#include "Data/BSplineVolumeData.h"
#include "Support/Messages.h"
#include "Support/VolumeCases.h"

#include "vtkBSplineVolumeReader.h"
#include "vtkNURBSSurfaceReader.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkErrorCode.h>
#include <vtkExecutive.h>
#include <vtkFieldData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkStructuredGrid.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <numeric>
#include <set>
#include <sstream>

using namespace bsv;
using namespace bsvtest;

namespace
{

/// A file for one test, removed at its end.
class File
{
public:
  explicit File(const std::string& text)
  {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    this->Path = std::filesystem::temp_directory_path() /
      (std::string("bsv-volume-") + test->name() + "-" + std::to_string(std::random_device()()));
    this->write(text);
  }
  ~File() { std::filesystem::remove(this->Path); }
  void write(const std::string& text) const
  {
    // A new file: some file systems flush one that is overwritten to the disk.
    std::filesystem::remove(this->Path);
    std::ofstream(this->Path, std::ios::binary) << text;
  }
  std::string name() const { return this->Path.string(); }

private:
  std::filesystem::path Path;
};

struct Reading
{
  vtkNew<vtkBSplineVolumeReader> reader;
  std::vector<std::string> errors;
  std::vector<std::string> warnings;
  vtkPartitionedDataSetCollection* output = nullptr;

  explicit Reading(const std::string& fileName)
  {
    const bsvtest::Messages messages(this->reader, this->errors, this->warnings);
    vtkNew<vtkCallbackCommand> silence;
    this->reader->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, silence);
    this->reader->SetFileName(fileName.c_str());
    this->reader->Update();
    this->output = vtkPartitionedDataSetCollection::SafeDownCast(this->reader->GetOutputDataObject(0));
  }

  BSplineVolumeBlocks blocks() const { return bsplineVolumeBlocks(this->output); }
  int attribute(int block) const
  {
    auto* array = vtkIntArray::SafeDownCast(
      this->output->GetPartitionAsDataObject(block, 0)->GetFieldData()->GetArray("Attribute"));
    return array->GetValue(0);
  }
};

/// The one error of a file that must be refused, with an empty output.
std::string refused(const std::string& fileName)
{
  const Reading reading(fileName);
  EXPECT_EQ(reading.errors.size(), 1u) << fileName;
  EXPECT_EQ(reading.output->GetNumberOfPartitionedDataSets(), 0u);
  EXPECT_NE(reading.reader->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::NoError));
  return reading.errors.empty() ? "" : reading.errors[0];
}

void expectRefused(const std::string& text, const std::string& reason)
{
  const File file(text);
  const std::string error = refused(file.name());
  EXPECT_NE(error.find(reason), std::string::npos) << error << "\n instead of: " << reason;
  EXPECT_NE(error.find(file.name()), std::string::npos) << error;
}

std::string replaced(std::string text, const std::string& from, const std::string& to)
{
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string sharedFile(const std::string& name)
{
  const char* folder = std::getenv("BSV_SHARED_DATA");
  const std::string path = std::string(folder ? folder : "") + "/volumes/" + name;
  return folder && std::filesystem::exists(path) ? path : "";
}

/// Knots from 0 with the given steps between them, clamped.
std::vector<double> clampedKnots(int degree, const std::vector<double>& steps)
{
  std::vector<double> knots(degree + 1, 0.0);
  for (const double step : steps)
  {
    knots.push_back(knots.back() + step);
  }
  knots.insert(knots.end(), degree, knots.back());
  return knots;
}

std::string g2(const Block& block)
{
  std::ostringstream text;
  text << std::setprecision(17) << "700 1 0 0\n3 " << !block.weights.empty() << "\n";
  for (int d = 0; d < 3; ++d)
  {
    text << block.counts()[d] << " " << block.volume.degree[d] + 1 << "\n";
    for (const double knot : block.volume.knots[d])
    {
      text << knot << " ";
    }
    text << "\n";
  }
  for (std::size_t p = 0; p < block.points.size(); p += 3)
  {
    const double weight = block.weights.empty() ? 1.0 : block.weights[p / 3];
    for (int c = 0; c < 3; ++c)
    {
      text << block.points[p + c] * weight << " ";
    }
    if (!block.weights.empty())
    {
      text << weight;
    }
    text << "\n";
  }
  return text.str();
}

const char* const Surface = "200 1 0 4 255 0 0 255\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
/// A circle: dimension, radius, centre, normal, axis, parameters, and lines that are nearly headers.
const char* const Circle = "130 1 0 0\n3\n1\n0 0 0\n0 0 1\n700 1 0\n0 6.28\n0\n700 1 0 0.5\n0\n";

/// Volume by Gauss quadrature of the Jacobian with `n` points per span and direction; negative if left-handed.
double integral(const BSplineVolume& volume, int n)
{
  // Nodes are the roots of the Legendre polynomial, by Newton's method.
  std::vector<std::array<double, 2>> rule;
  for (int i = 1; i <= n; ++i)
  {
    double x = std::cos(M_PI * (i - 0.25) / (n + 0.5));
    double slope = 1.0;
    for (int step = 0; step < 50; ++step)
    {
      double p0 = 1.0, p1 = x;
      for (int k = 2; k <= n; ++k)
      {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      slope = n * (x * p1 - p0) / (x * x - 1.0);
      x -= p1 / slope;
    }
    rule.push_back({ 0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope) });
  }
  std::array<std::vector<std::array<double, 2>>, 3> nodes;
  for (int d = 0; d < 3; ++d)
  {
    for (const int s : nonEmptySpans(volume.degree[d], volume.knots[d]))
    {
      const double a = volume.knots[d][s];
      const double h = volume.knots[d][s + 1] - a;
      for (const auto& node : rule)
      {
        nodes[d].push_back({ a + h * node[0], h * node[1] });
      }
    }
  }
  double sum = 0.0;
  for (const auto& u : nodes[0])
  {
    for (const auto& v : nodes[1])
    {
      for (const auto& w : nodes[2])
      {
        const Vec3 at(u[0], v[0], w[0]);
        sum += u[1] * v[1] * w[1] *
          evaluate(volume, at, { 1, 0, 0 })
            .dot(evaluate(volume, at, { 0, 1, 0 }).cross(evaluate(volume, at, { 0, 0, 1 })));
      }
    }
  }
  return sum;
}

double totalVolume(const BSplineVolumeBlocks& blocks, int n)
{
  double sum = 0.0;
  for (const BSplineVolume& volume : blocks.volumes)
  {
    sum += std::abs(integral(volume, n));
  }
  return sum;
}

/// Parameters (s, t) in [0, 1]^2 of a face.
Vec3 onFace(const BSplineVolume& volume, int face, double s, double t)
{
  Vec3 at;
  const auto place = [&](int d, double x) {
    const double a = volume.knots[d][volume.degree[d]];
    const double b = volume.knots[d][volume.count(d)];
    at[d] = x == 1.0 ? b : a + x * (b - a);
  };
  place(faceDirection(face), faceSide(face));
  place(faceAxis(face, 0), s);
  place(faceAxis(face, 1), t);
  return evaluate(volume, at);
}

template <typename Visitor>
void overFace(Visitor&& visit)
{
  for (int i = 0; i <= 8; ++i)
  {
    for (int j = 0; j <= 8; ++j)
    {
      visit(i / 8.0, j / 8.0);
    }
  }
}

/// The two sides of every interface are the same surface.
void expectClosed(const BSplineVolumeBlocks& blocks, double tolerance)
{
  for (const Interface& contact : blocks.interfaces)
  {
    overFace([&](double s, double t) {
      const double u = swapsAxes(contact.orientation) ? t : s;
      const double v = swapsAxes(contact.orientation) ? s : t;
      const Vec3 a = onFace(blocks.volumes[contact.blockA], contact.faceA, s, t);
      const Vec3 b = onFace(blocks.volumes[contact.blockB], contact.faceB, contact.orientation & 2 ? 1.0 - u : u,
        contact.orientation & 4 ? 1.0 - v : v);
      ASSERT_LT((a - b).norm(), tolerance);
    });
  }
}

/// A box of 2 x 2 x 2 patches of a lattice: control points and weights are functions of the place, so that a file's
/// numbering of them can be written, and what is read be checked, without any numbering of a block. Vertices are
/// numbered, patches turned and edges directed at random.
class LatticeMesh
{
public:
  explicit LatticeMesh(unsigned seed)
    : Random(seed)
  {
    std::iota(this->VertexNumber.begin(), this->VertexNumber.end(), 0);
    std::shuffle(this->VertexNumber.begin(), this->VertexNumber.end(), this->Random);
    for (int d = 0; d < 3; ++d)
    {
      for (int half = 0; half < 2; ++half)
      {
        this->Degree[d][half] = 1 + (d + half) % 3;
        // Dyadic and not symmetric: reversed exactly, and reversal shows.
        this->Knots[d][half] = clampedKnots(this->Degree[d][half], { 0.25, 0.5 * (1 + d), 1.0 + half });
      }
    }
    const std::vector<Orientation> all = allOrientations();
    forEach({ 2, 2, 2 }, [&](const Ijk& at) {
      const Orientation o = all[std::uniform_int_distribution<std::size_t>(0, 47)(this->Random)];
      this->Patches.push_back({ at, o });
    });
    std::shuffle(this->Patches.begin(), this->Patches.end(), this->Random);
  }

  /// The text of the file: with numbered points, or with points per patch.
  std::string text(bool numbered)
  {
    std::ostringstream out;
    out << std::setprecision(17) << "MFEM NURBS mesh v1.0\n\n# a comment\n\ndimension\n3\n\nelements\n8\n";
    for (std::size_t p = 0; p < this->Patches.size(); ++p)
    {
      out << 10 + p << " 5 " << list(this->vertices(this->Patches[p])) << "\n";
    }
    // The sides i = 0 and i = 2 of the lattice, with corners in any order around the face, and one inner face.
    out << "\nboundary\n9\n";
    for (const int i : { 0, 2, 1 })
    {
      for (int c = 0; c < (i == 1 ? 1 : 4); ++c)
      {
        std::vector<int> corners;
        for (const auto& turn : { std::array<int, 2>{ 0, 0 }, { 1, 0 }, { 1, 1 }, { 0, 1 } })
        {
          corners.push_back(this->number({ i, c % 2 + turn[0], c / 2 + turn[1] }));
        }
        std::rotate(corners.begin(), corners.begin() + this->Random() % 4, corners.end());
        out << (i == 0 ? 7 : 3) << " 3 " << list(corners) << "\n";
      }
    }

    // Knot vector 2 n runs along the lattice, 2 n + 1 against it; n = 2 d + half.
    struct Edge
    {
      Ijk low, high;
      int d;
    };
    std::vector<Edge> edges;
    for (int d = 0; d < 3; ++d)
    {
      Ijk counts{ 3, 3, 3 };
      counts[d] = 2;
      forEach(counts, [&](const Ijk& at) {
        Ijk end = at;
        ++end[d];
        edges.push_back({ at, end, d });
      });
    }
    std::shuffle(edges.begin(), edges.end(), this->Random);
    out << "\nedges\n" << edges.size() << "\n";
    for (const Edge& edge : edges)
    {
      const bool against = this->Random() % 2 == 1;
      out << 2 * (2 * edge.d + edge.low[edge.d]) + against << " " << this->number(against ? edge.high : edge.low) << " "
          << this->number(against ? edge.low : edge.high) << "\n";
    }
    out << "\nvertices\n27\n\n";
    if (!numbered)
    {
      out << "patches\n";
      for (const Patch& patch : this->Patches)
      {
        out << "\n# patch\nknotvectors\n3\n";
        for (int d = 0; d < 3; ++d)
        {
          out << knotLine(this->knots(patch, d));
        }
        out << "dimension\n3\ncontrolpoints\n";
        forEach(this->counts(patch), [&](const Ijk& i) {
          const Vec3 x = this->place(patch, i);
          const double w = weight(x);
          out << w * x[0] << " " << w * x[1] << " " << w * x[2] << " " << w << "\n";
        });
      }
      return out.str();
    }

    out << "knotvectors\n12\n";
    for (int d = 0; d < 3; ++d)
    {
      for (int half = 0; half < 2; ++half)
      {
        out << knotLine({ this->Degree[d][half], this->Knots[d][half] })
            << knotLine({ this->Degree[d][half], reversedKnots(this->Knots[d][half]) });
      }
    }

    // MFEM's numbering, in places of the lattice.
    std::vector<Vec3> places(27);
    forEach({ 3, 3, 3 }, [&](const Ijk& at) { places[this->number(at)] = this->vertexPlace(at); });
    for (const Edge& edge : edges)
    {
      const bool forward = this->number(edge.low) < this->number(edge.high);
      this->addBetween(places, { this->vertexPlace(forward ? edge.low : edge.high) },
        { this->vertexPlace(forward ? edge.high : edge.low) });
    }
    std::set<std::vector<int>> seen;
    for (const Patch& patch : this->Patches)
    {
      const std::vector<int> v = this->vertices(patch);
      for (const std::array<int, 4>& face : std::vector<std::array<int, 4>>{
             { 3, 2, 1, 0 }, { 0, 1, 5, 4 }, { 1, 2, 6, 5 }, { 2, 3, 7, 6 }, { 3, 0, 4, 7 }, { 4, 5, 6, 7 } })
      {
        std::vector<int> key{ v[face[0]], v[face[1]], v[face[2]], v[face[3]] };
        std::sort(key.begin(), key.end());
        if (seen.insert(key).second)
        {
          this->addBetween(places, { this->placeOf(v[face[0]]), this->placeOf(v[face[3]]) },
            { this->placeOf(v[face[1]]), this->placeOf(v[face[2]]) });
        }
      }
    }
    for (const Patch& patch : this->Patches)
    {
      forEach(this->counts(patch), [&](const Ijk& i) {
        const Ijk n = this->counts(patch);
        if (i[0] > 0 && i[1] > 0 && i[2] > 0 && i[0] < n[0] - 1 && i[1] < n[1] - 1 && i[2] < n[2] - 1)
        {
          places.push_back(this->place(patch, i));
        }
      });
    }
    out << "\nweights\n";
    for (const Vec3& x : places)
    {
      out << weight(x) << "\n";
    }
    const bool interleaved = this->Random() % 2 == 1;
    out << "\nFiniteElementSpace\nFiniteElementCollection: NURBS\nVDim: 3\nOrdering: " << interleaved << "\n\n";
    for (std::size_t i = 0; i < 3 * places.size(); ++i)
    {
      out << (interleaved ? places[i / 3][i % 3] : places[i % places.size()][i / places.size()]) << "\n";
    }
    return out.str();
  }

  void expectRead(const Reading& reading, double tolerance) const
  {
    ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
    const BSplineVolumeBlocks blocks = reading.blocks();
    ASSERT_EQ(blocks.volumes.size(), 8u);
    for (std::size_t b = 0; b < 8; ++b)
    {
      const BSplineVolume& volume = blocks.volumes[b];
      const Patch& patch = this->Patches[b];
      EXPECT_EQ(reading.attribute(static_cast<int>(b)), static_cast<int>(10 + b));
      EXPECT_EQ(blocks.names[b], "Patch " + std::to_string(b + 1));
      for (int d = 0; d < 3; ++d)
      {
        ASSERT_EQ(volume.degree[d], this->knots(patch, d).degree);
        ASSERT_EQ(volume.knots[d], this->knots(patch, d).knots);
      }
      Index at = 0;
      ASSERT_NE(volume.weights, nullptr);
      forEach(this->counts(patch), [&](const Ijk& i) {
        const Vec3 x = this->place(patch, i);
        ASSERT_LE((Eigen::Map<const Vec3>(volume.points + 3 * at) - x).norm(), tolerance);
        ASSERT_NEAR(volume.weights[at], weight(x), tolerance);
        ++at;
      });
    }
    EXPECT_EQ(blocks.interfaces.size(), 12u);
    expectClosed(blocks, 1e-14);
    // Attribute 3 is i = 2, where the lattice ends at x = 3; attribute 7 is i = 0.
    ASSERT_EQ(blocks.boundaryNames, (std::vector<std::string>{ "boundary 3", "boundary 7" }));
    ASSERT_EQ(blocks.boundaries.size(), 8u);
    for (const BoundaryPatch& patch : blocks.boundaries)
    {
      overFace([&](double s, double t) {
        ASSERT_NEAR(onFace(blocks.volumes[patch.block], patch.face, s, t)[0], patch.tag == 0 ? 3.0 : 0.0, 1e-14);
      });
    }
    ASSERT_EQ(reading.warnings.size(), 1u);
    EXPECT_NE(reading.warnings[0].find("1 boundary element between two patches"), std::string::npos);
  }

private:
  struct Patch
  {
    Ijk at; ///< in the lattice
    Orientation orientation;
  };
  struct DegreeAndKnots
  {
    int degree;
    std::vector<double> knots;
  };

  template <typename Numbers>
  static std::string list(const Numbers& numbers)
  {
    std::ostringstream text;
    for (const auto number : numbers)
    {
      text << number << " ";
    }
    return text.str();
  }
  static std::string knotLine(const DegreeAndKnots& line)
  {
    std::ostringstream text;
    text << line.degree << " " << line.knots.size() - line.degree - 1 << " " << list(line.knots) << "\n";
    return text.str();
  }
  static double weight(const Vec3& x) { return 1.0 + 0.25 * x[0] + 0.5 * x[1] * x[2]; }

  int number(const Ijk& vertex) const { return this->VertexNumber[vertex[0] + 3 * vertex[1] + 9 * vertex[2]]; }
  /// Lattice lines at 0, 1, 3 of every direction, stretched.
  Vec3 vertexPlace(const Ijk& vertex) const
  {
    const double lines[3] = { 0.0, 1.0, 3.0 };
    return Vec3(lines[vertex[0]], 2.0 * lines[vertex[1]], 4.0 * lines[vertex[2]]);
  }
  Vec3 placeOf(int number) const
  {
    Vec3 x = Vec3::Zero();
    forEach({ 3, 3, 3 }, [&](const Ijk& at) { x = this->number(at) == number ? this->vertexPlace(at) : x; });
    return x;
  }
  int pointsBetween(int d, int half) const
  {
    return static_cast<int>(this->Knots[d][half].size()) - this->Degree[d][half] - 3;
  }
  /// Points strictly between two places that differ in one direction of the lattice, which tells their number.
  std::vector<Vec3> between(const Vec3& a, const Vec3& b) const
  {
    const Vec3 step = (b - a).cwiseAbs();
    int d = 0;
    step.maxCoeff(&d);
    const int half = std::min(a[d], b[d]) == 0.0 ? 0 : 1;
    const int n = this->pointsBetween(d, half);
    std::vector<Vec3> points;
    for (int i = 1; i <= n; ++i)
    {
      points.push_back(a + (b - a) * (static_cast<double>(i) / (n + 1)));
    }
    return points;
  }
  /// Points strictly inside an edge, or, from two opposite edges a[0]-b[0] and a[1]-b[1], inside a face: along a-b
  /// fastest.
  void addBetween(std::vector<Vec3>& places, const std::vector<Vec3>& a, const std::vector<Vec3>& b) const
  {
    if (a.size() == 1)
    {
      const std::vector<Vec3> points = this->between(a[0], b[0]);
      places.insert(places.end(), points.begin(), points.end());
      return;
    }
    const std::vector<Vec3> starts = this->between(a[0], a[1]);
    const std::vector<Vec3> ends = this->between(b[0], b[1]);
    for (std::size_t i = 0; i < starts.size(); ++i)
    {
      this->addBetween(places, { starts[i] }, { ends[i] });
    }
  }

  /// Lattice vertex of a patch's corner, each of i in {0, 1}.
  Ijk corner(const Patch& patch, const Ijk& i) const
  {
    const Ijk local = patch.orientation.old(i, { 2, 2, 2 });
    return { patch.at[0] + local[0], patch.at[1] + local[1], patch.at[2] + local[2] };
  }
  /// In MFEM's order.
  std::vector<int> vertices(const Patch& patch) const
  {
    std::vector<int> result;
    for (const Ijk& i : std::vector<Ijk>{
           { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 0, 1 }, { 1, 1, 1 }, { 0, 1, 1 } })
    {
      result.push_back(this->number(this->corner(patch, i)));
    }
    return result;
  }
  DegreeAndKnots knots(const Patch& patch, int direction) const
  {
    const int d = patch.orientation.order[direction];
    const int half = patch.at[d];
    const bool flip = patch.orientation.flip[direction];
    return { this->Degree[d][half], flip ? reversedKnots(this->Knots[d][half]) : this->Knots[d][half] };
  }
  Ijk counts(const Patch& patch) const
  {
    Ijk result;
    for (int direction = 0; direction < 3; ++direction)
    {
      const int d = patch.orientation.order[direction];
      result[direction] = this->pointsBetween(d, patch.at[d]) + 2;
    }
    return result;
  }
  Vec3 place(const Patch& patch, const Ijk& i) const
  {
    const Ijk n = this->counts(patch);
    const Vec3 origin = this->vertexPlace(this->corner(patch, { 0, 0, 0 }));
    Vec3 x = origin;
    for (int direction = 0; direction < 3; ++direction)
    {
      Ijk end{ 0, 0, 0 };
      end[direction] = 1;
      x += (this->vertexPlace(this->corner(patch, end)) - origin) *
        (static_cast<double>(i[direction]) / (n[direction] - 1));
    }
    return x;
  }

  std::mt19937 Random;
  std::array<int, 27> VertexNumber{};
  std::array<std::array<int, 2>, 3> Degree{};
  std::array<std::array<std::vector<double>, 2>, 3> Knots;
  std::vector<Patch> Patches;
};

const char* const Cube = "MFEM NURBS mesh v1.0\n"                                                               // 1
                         "dimension\n3\n"                                                                       // 2
                         "elements\n1\n"                                                                        // 4
                         "1 5 0 1 2 3 4 5 6 7\n"                                                                // 6
                         "boundary\n1\n"                                                                        // 7
                         "1 3 0 1 2 3\n"                                                                        // 9
                         "edges\n12\n"                                                                          // 10
                         "0 0 1\n0 3 2\n0 4 5\n0 7 6\n1 0 3\n1 1 2\n1 4 7\n1 5 6\n2 0 4\n2 1 5\n2 2 6\n2 3 7\n" // 12
                         "vertices\n8\n"                                                                        // 24
                         "knotvectors\n3\n"                                                                     // 26
                         "1 2 0 0 1 1\n1 2 0 0 1 1\n1 2 0 0 1 1\n"                                              // 28
                         "weights\n1 1 1 1 1 1 1 1\n"                                                           // 31
                         "FiniteElementSpace\nFiniteElementCollection: NURBS1\nVDim: 3\nOrdering: 1\n"          // 33
                         "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n";                            // 37

/// Whatever becomes of a damaged file: it is read, or there is one error that names it, nothing else.
void survive(const File& file, const std::string& text)
{
  file.write(text);
  const Reading reading(file.name());
  if (reading.errors.empty())
  {
    ASSERT_GT(reading.output->GetNumberOfPartitionedDataSets(), 0u);
    reading.blocks();
    return;
  }
  ASSERT_EQ(reading.errors.size(), 1u);
  ASSERT_NE(reading.errors[0].find(file.name()), std::string::npos) << reading.errors[0];
  ASSERT_EQ(reading.output->GetNumberOfPartitionedDataSets(), 0u);
}

void damage(const std::string& text)
{
  const File file("");
  // Cut before every word, every word replaced.
  std::size_t at = 0;
  while ((at = text.find_first_not_of(" \n", at)) != std::string::npos)
  {
    const std::size_t end = std::min(text.find_first_of(" \n", at), text.size());
    survive(file, text.substr(0, at));
    for (const char* word : { "-1", "0", "2", "99999999", "2147483648", "1e300", "nan", "x", "" })
    {
      survive(file, text.substr(0, at) + word + text.substr(end));
    }
    at = end;
  }
}

} // namespace

TEST(BSplineVolumeReader, G2VolumesKeepTheirNumbers)
{
  std::mt19937 random(1);
  std::vector<Block> volumes;
  std::string text = Surface;
  for (int degree = 1; degree <= MaxDegree; ++degree)
  {
    const std::array<int, 3> degrees{ degree, MaxDegree + 1 - degree, 1 + degree % 4 };
    std::array<std::vector<double>, 3> knots;
    for (int d = 0; d < 3; ++d)
    {
      knots[d] = clampedKnots(degrees[d], { 0.1, 0.7, degrees[d] > 1 ? 0.0 : 0.3, 1.3 });
    }
    volumes.push_back(randomBlock(random, degrees, knots, false));
    if (degree % 2 == 0)
    {
      for (std::size_t p = 0; p < volumes.back().points.size(); p += 3)
      {
        volumes.back().weights.push_back(0.25 * (1 + random() % 12));
      }
    }
    text += g2(volumes.back()) + (degree == 3 ? Circle : "") + (degree == 5 ? Surface : "");
  }
  const File file(text);
  EXPECT_EQ(vtkBSplineVolumeReader::CanReadFile(file.name().c_str()), 1);
  const Reading reading(file.name());
  ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
  ASSERT_EQ(reading.warnings.size(), 1u);
  EXPECT_NE(reading.warnings[0].find("1 circle, 2 spline surface"), std::string::npos) << reading.warnings[0];
  EXPECT_STREQ(reading.reader->GetNotRead(), "1 circle, 2 spline surface");
  EXPECT_EQ(reading.reader->GetNumberOfBlocks(), MaxDegree);
  EXPECT_EQ(reading.reader->GetNumberOfRationalBlocks(), MaxDegree / 2);
  const BSplineVolumeBlocks blocks = reading.blocks();
  ASSERT_EQ(blocks.volumes.size(), volumes.size());
  for (std::size_t b = 0; b < volumes.size(); ++b)
  {
    EXPECT_EQ(blocks.names[b], "Volume " + std::to_string(b + 1));
    EXPECT_EQ(blocks.volumes[b].degree, volumes[b].volume.degree);
    EXPECT_EQ(blocks.volumes[b].knots, volumes[b].volume.knots);
    ASSERT_NE(blocks.volumes[b].weights, nullptr);
    for (std::size_t i = 0; i < volumes[b].points.size(); ++i)
    {
      // Multiplied and divided by the weight: two roundings.
      const double x = volumes[b].points[i];
      ASSERT_NEAR(blocks.volumes[b].points[i], x, volumes[b].weights.empty() ? 0.0 : 4e-16 * std::abs(x));
      ASSERT_EQ(blocks.volumes[b].weights[i / 3], volumes[b].weights.empty() ? 1.0 : volumes[b].weights[i / 3]);
    }
  }
}

TEST(BSplineVolumeReader, WeightsOfOneMakeNoArray)
{
  std::mt19937 random(2);
  Block block =
    randomBlock(random, { 1, 2, 1 }, { clampedKnots(1, { 1 }), clampedKnots(2, { 1 }), clampedKnots(1, { 1 }) });
  block.weights.assign(block.points.size() / 3, 1.0);
  const File file(g2(block));
  const Reading one(file.name());
  EXPECT_EQ(one.blocks().volumes[0].weights, nullptr);
  EXPECT_EQ(one.reader->GetNumberOfRationalBlocks(), 0);
  block.weights[3] = 2.0;
  file.write(g2(block));
  const Reading other(file.name());
  EXPECT_NE(other.blocks().volumes[0].weights, nullptr);
  EXPECT_EQ(other.reader->GetNumberOfRationalBlocks(), 1);
}

// A quarter of a pipe with radii 1 and 2 and height 3 is round only with its weights.
TEST(BSplineVolumeReader, RationalVolumesStayRational)
{
  Block block;
  block.volume.degree = { 1, 2, 1 };
  block.volume.knots = { clampedKnots(1, { 1 }), clampedKnots(2, { 1 }), clampedKnots(1, { 1 }) };
  forEach(block.counts(), [&](const Ijk& i) {
    const Vec3 x((1 + i[0]) * (i[1] < 2 ? 1.0 : 0.0), (1 + i[0]) * (i[1] > 0 ? 1.0 : 0.0), 3.0 * i[2]);
    block.points.insert(block.points.end(), x.data(), x.data() + 3);
    block.weights.push_back(i[1] == 1 ? std::sqrt(0.5) : 1.0);
  });
  const File file(g2(block));
  const Reading reading(file.name());
  ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
  EXPECT_EQ(reading.reader->GetNumberOfRationalBlocks(), 1);
  const BSplineVolumeBlocks blocks = reading.blocks();
  overFace([&](double s, double t) {
    for (int side = 0; side < 2; ++side)
    {
      const Vec3 x = onFace(blocks.volumes[0], side, s, t);
      ASSERT_NEAR(std::hypot(x[0], x[1]), 1.0 + side, 1e-15 * 4);
    }
  });
  EXPECT_NEAR(totalVolume(blocks, 12), 0.25 * M_PI * 3.0 * 3.0, 1e-13);
}

TEST(BSplineVolumeReader, MFEMPatchesInAllOrientations)
{
  for (unsigned seed = 0; seed < 20; ++seed)
  {
    LatticeMesh mesh(seed);
    const File file(mesh.text(false));
    EXPECT_EQ(vtkBSplineVolumeReader::CanReadFile(file.name().c_str()), 1);
    mesh.expectRead(Reading(file.name()), 1e-14);
  }
}

TEST(BSplineVolumeReader, MFEMNumberedPointsInAllOrientations)
{
  for (unsigned seed = 0; seed < 20; ++seed)
  {
    LatticeMesh mesh(seed);
    const File file(mesh.text(true));
    mesh.expectRead(Reading(file.name()), 1e-14);
  }
}

TEST(BSplineVolumeReader, MFEMForms)
{
  const File file(Cube);
  const auto corner = [&] {
    const Reading reading(file.name());
    EXPECT_TRUE(reading.errors.empty()) << reading.errors[0];
    EXPECT_EQ(reading.output->GetNumberOfPartitionedDataSets(), 1u);
    return reading.errors.empty() ? Vec3(evaluate(reading.blocks().volumes[0], Vec3(1, 0.5, 1))) : Vec3(0, 0, 0);
  };
  EXPECT_EQ(corner(), Vec3(1, 0.5, 1));
  file.write(replaced(Cube, "weights\n1 1 1 1 1 1 1 1\n", "unitweights\n"));
  EXPECT_EQ(corner(), Vec3(1, 0.5, 1));
  // Windows line ends, a plus sign.
  std::string text = replaced(Cube, "1 2 0 0 1 1", "1 2 0 0 +1 1");
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2)
  {
    text.replace(at, 1, "\r\n");
  }
  file.write(text);
  EXPECT_EQ(corner(), Vec3(1, 0.5, 1));
  // Coordinates patch by patch, in the order of the patch.
  file.write(replaced(
    replaced(replaced(Cube, "Ordering: 1\n", "Ordering: 1\nNURBS_patches\n"), "1 1 0\n0 1 0\n", "0 1 0\n1 1 0\n"),
    "1 1 1\n0 1 1\n", "0 1 1\n1 1 1\n"));
  EXPECT_EQ(corner(), Vec3(1, 0.5, 1));
  const std::string patches = std::string(Cube, std::string(Cube).find("knotvectors")) +
    "patches\nknotvectors\n3\n1 2 0 0 1 1\n1 2 0 0 1 1\n1 2 0 0 1 1\ndimension\n3\ncontrolpoints_cartesian\n"
    "0 0 0 1\n1 0 0 2\n0 1 0 1\n1 1 0 2\n0 0 1 1\n1 0 1 2\n0 1 1 1\n1 1 1 2\n";
  file.write(patches);
  EXPECT_EQ(corner(), Vec3(1, 0.5, 1));
  // The same numbers as homogeneous coordinates.
  file.write(replaced(patches, "_cartesian", ""));
  EXPECT_EQ(corner(), Vec3(0.5, 0.25, 0.5));
}

TEST(BSplineVolumeReader, NamesOfMFEMDoNotDependOnLineEnds)
{
  const std::string first = "MFEM NURBS mesh v1.0";
  for (const char* end : { "\n", "\r\n", " \t\n", "\n\n", " \r\n \r\n" })
  {
    for (const char* mark : { "", "\xef\xbb\xbf" })
    {
      const std::string names =
        first + end + "# element attribute 1: hub" + end + "# boundary attribute 1: far field" + end;
      const File file(mark + replaced(Cube, first + "\n", names));
      const Reading reading(file.name());
      ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
      EXPECT_EQ(reading.blocks().names[0], "hub");
      EXPECT_EQ(reading.blocks().boundaryNames, (std::vector<std::string>{ "far field" }));
    }
  }
  expectRefused(std::string("\xff\xfe") + "M", "UTF-16");
}

TEST(BSplineVolumeReader, RefusesWithLineAndValue)
{
  const std::string cube = Cube;
  expectRefused("", "the file is empty");
  expectRefused("solid", "neither a GoTools g2 file nor an MFEM mesh");
  expectRefused(replaced(cube, "v1.0", "v1.1"), "'weights' instead of 'spacing'");
  expectRefused(replaced(cube, "v1.0", "v1.2"), "line 1: 'MFEM NURBS mesh v1.2' is not supported");
  expectRefused(replaced(cube, "NURBS mesh", "mesh"), "line 1: 'MFEM mesh v1.0' is not supported");
  expectRefused(replaced(cube, "NURBS mesh", "NURBS NC-patch mesh"), "do not meet face to face");
  expectRefused(replaced(cube, "dimension\n3", "dimension\n2"), "line 3: the mesh has dimension 2");
  expectRefused(
    replaced(cube, "elements\n1", "elements\n100000000"), "line 5: the file is too short for the number of elements");
  expectRefused(replaced(cube, "1 5 0", "1 4 0"), "line 6: an element has geometry type 4");
  expectRefused(replaced(cube, "6 7\nb", "6 6\nb"), "line 6: an element has vertex 6 twice");
  expectRefused(replaced(cube, "6 7\nb", "6 8\nb"), "line 6: the element has vertex 8, but there are only 8");
  expectRefused(replaced(cube, "1 3 0 1 2 3", "1 3 0 1 2 4"), "line 9: the boundary element is no face");
  expectRefused(
    replaced(cube, "boundary\n1\n", "boundary\n2\n1 3 3 2 1 0\n"), "line 10: the boundary element is listed twice");
  expectRefused(replaced(cube, "2 3 7", "2 7 3\n2 3 7"), "line 24: '2' instead of 'vertices'");
  expectRefused(replaced(cube, "2 3 7", "2 2 6"), "line 23: the edge from vertex 2 to 6 is listed twice");
  expectRefused(
    replaced(cube, "2 3 7", "2 3 6"), "has an edge from vertex 3 to 7, which the section 'edges' does not list");
  expectRefused(replaced(cube, "2 3 7", "3 3 7"), "an edge has knot vector 3, but there are only 3");
  expectRefused(replaced(cube, "1 2 0 0 1 1\nweights", "1 2 0 0 1 0\nweights"), "line 30: a knot is smaller");
  expectRefused(replaced(cube, "1 2 0 0 1 1", "9 10 0 0 1 1"), "line 28: the order of a knot vector is 9, not in 1..8");
  expectRefused(replaced(cube, "1 2 0 0 1 1", "1 20000000 0 0 1 1"), "line 28: the file is too short");
  expectRefused(replaced(cube, "weights\n1 1", "weights\n1 0"), "line 32: the weight 0.000000 is not positive");
  expectRefused(replaced(cube, "weights\n1", "weights\n-1"), "line 32: the weight -1.000000 is not positive");
  expectRefused(replaced(cube, "weights\n", "periodic\n0\n0\nweights\n"), "section 'periodic' is not supported");
  expectRefused(replaced(cube, "NURBS1", "NURBS2"), "line 34: the collection 'NURBS2' does not fit");
  expectRefused(replaced(cube, "NURBS1", "H1_3D_P1"), "line 34: the collection 'H1_3D_P1' does not fit");
  expectRefused(replaced(cube, "VDim: 3", "VDim: 2"), "line 35: VDim is 2");
  expectRefused(cube + "1\n", "line 45: the mesh is complete before '1'");
  expectRefused(replaced(cube, "1 0 1\n", "1 0 inf\n"), "line 42: 'inf' is no finite number");
  // Knot vectors of parallel edges that differ only by their sense.
  expectRefused(replaced(replaced(cube, "1 2 0 0 1 1", "1 3 0 0 0.25 1 1"), "0 3 2\n", "0 2 3\n"),
    "the edges of patch 1 in direction 0 have different knot vectors");

  std::mt19937 random(3);
  const std::vector<double> knots = clampedKnots(2, { 1, 0, 1 });
  const std::string volume = g2(randomBlock(random, { 2, 2, 2 }, { knots, knots, knots }));
  expectRefused(Surface, "holds no volume; it holds: 1 spline surface");
  expectRefused(replaced(volume, "3 0\n", "2 0\n"), "line 2: the volume has dimension 2 instead of 3");
  expectRefused(replaced(volume, "5 3\n", "500000 3\n"), "line 3: the file is too short");
  expectRefused(replaced(volume, "5 3\n", "12 10\n"), "line 3: the order is 10, not in 2..9");
  const std::vector<double> torn = clampedKnots(2, { 1, 0, 0, 1 });
  expectRefused(g2(randomBlock(random, { 2, 2, 2 }, { knots, torn, knots })), "is repeated more than 2 times");
  expectRefused(volume + "999 1 0 0\n", "class 999 is none of GoTools");
  expectRefused(volume.substr(0, volume.find_last_of(' ', volume.size() - 3)), "the file ends where");
  EXPECT_NE(refused("/no/such/file.g2").find("/no/such/file.g2: no such file"), std::string::npos);
}

// g2 is the extension of surfaces and of volumes.
TEST(BSplineVolumeReader, EachReaderKnowsItsFiles)
{
  const File file(Surface);
  EXPECT_EQ(vtkBSplineVolumeReader::CanReadFile(file.name().c_str()), 0);
  EXPECT_EQ(vtkNURBSSurfaceReader::CanReadFile(file.name().c_str()), 1);
  file.write("MFEM NURBS NC-patch mesh v1.0\n");
  EXPECT_EQ(vtkBSplineVolumeReader::CanReadFile(file.name().c_str()), 1);
  file.write("MFEM mesh v1.0\n");
  EXPECT_EQ(vtkBSplineVolumeReader::CanReadFile(file.name().c_str()), 0);
  EXPECT_EQ(vtkBSplineVolumeReader::CanReadFile("/no/such/file"), 0);
}

TEST(BSplineVolumeReader, SurvivesDamage)
{
  damage(Cube);
  std::mt19937 random(4);
  Block block =
    randomBlock(random, { 1, 2, 1 }, { clampedKnots(1, { 1 }), clampedKnots(2, { 1 }), clampedKnots(1, { 1 }) });
  block.weights.assign(12, 1.5);
  damage(Surface + g2(block) + Circle + g2(block));
  std::string text = LatticeMesh(1).text(false);
  damage(text.substr(0, text.find("# patch", text.find("# patch") + 7)));
}

TEST(BSplineVolumeReader, RealMeshes)
{
  if (sharedFile("ball-nurbs.mesh").empty())
  {
    GTEST_SKIP() << "needs BSV_SHARED_DATA";
  }
  struct Known
  {
    const char* name;
    std::size_t blocks, interfaces;
    double volume; ///< 0: not known
  };
  for (const Known& known :
    { Known{ "ball-nurbs.mesh", 7, 12 + 6, 4.0 / 3.0 * M_PI }, { "beam-hex-nurbs.mesh", 2, 1, 8.0 },
      { "cube-nurbs.mesh", 1, 0, 1.0 }, { "cube-nurbs-deformed.mesh", 1, 0, 0.0 }, { "ijk-hex-nurbs.mesh", 8, 12, 8.0 },
      { "pipe-nurbs.mesh", 4, 4, 0.0 }, { "two-cubes-nurbs.mesh", 2, 1, 2.0 },
      { "two-cubes-nurbs-rot.mesh", 2, 1, 2.0 } })
  {
    const Reading reading(sharedFile(known.name));
    ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
    EXPECT_TRUE(reading.warnings.empty());
    const BSplineVolumeBlocks blocks = reading.blocks();
    EXPECT_EQ(blocks.volumes.size(), known.blocks) << known.name;
    EXPECT_EQ(blocks.interfaces.size(), known.interfaces) << known.name;
    // Weights and coordinates of the ball have 14 digits.
    expectClosed(blocks, 1e-13);
    if (known.volume > 0.0)
    {
      EXPECT_NEAR(totalVolume(blocks, 12), known.volume, 1e-11 * known.volume) << known.name;
    }
    for (const BoundaryPatch& patch : blocks.boundaries)
    {
      if (std::string(known.name) == "ball-nurbs.mesh")
      {
        overFace([&](double s, double t) {
          ASSERT_NEAR(onFace(blocks.volumes[patch.block], patch.face, s, t).norm(), 1.0, 1e-12);
        });
      }
    }
    if (std::string(known.name) == "pipe-nurbs.mesh")
    {
      // Radii 2 and 3, around the z axis at one end and around a parallel of the x axis at the other.
      for (const BSplineVolume& volume : blocks.volumes)
      {
        for (int side = 0; side < 2; ++side)
        {
          for (int i = 0; i <= 8; ++i)
          {
            const Vec3 start = onFace(volume, side, i / 8.0, 0.0);
            const Vec3 end = onFace(volume, side, i / 8.0, 1.0);
            ASSERT_EQ(start[2], 0.0);
            ASSERT_NEAR(std::hypot(start[0], start[1]), 2.0 + side, 1e-14);
            ASSERT_NEAR(end[0], 10.0, 1e-14);
            ASSERT_NEAR(std::hypot(end[1], end[2] - 20.0), 2.0 + side, 1e-14);
          }
        }
      }
    }
  }
  EXPECT_NE(refused(sharedFile("nc-nurbs3d.mesh")).find("do not meet face to face"), std::string::npos);
  // Version 1.1, with spacings.
  const Reading spaced(sharedFile("pipe-nurbs-log.mesh"));
  EXPECT_TRUE(spaced.errors.empty()) << spaced.errors[0];
  EXPECT_EQ(spaced.output->GetNumberOfPartitionedDataSets(), 4u);

  const Reading swept(sharedFile("swept_vol.g2"));
  ASSERT_TRUE(swept.errors.empty()) << swept.errors[0];
  const BSplineVolumeBlocks blocks = swept.blocks();
  ASSERT_EQ(blocks.volumes.size(), 5u);
  EXPECT_EQ(blocks.volumes[0].degree, (std::array<int, 3>{ 3, 3, 1 }));
  EXPECT_EQ(blocks.volumes[0].points[0], -0.5);
}

// SPDX-License-Identifier: BSD-3-Clause
// The wing-fuselage case: its block structure, validity of all cells, a body without gaps, the wall on it, and its
// conversion.
#include "Mesh/MeshCheck.h"
#include "Quality/JacobianBounds.h"
#include "Support/ConversionCases.h"
#include "Wall/BodyFit.h"
#include "WingFuselage/WingFuselageMesh.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

using namespace bsv;

namespace
{

constexpr int Blocks = 79;
const double Degree = std::acos(-1.0) / 180.0;

/// A mesh that owns its points.
struct Case
{
  explicit Case(const WingFuselageOptions& options = {}, const Execution& run = {})
    : layout(wingFuselageLayout(options))
    , body(wingFuselageBody(options.shape))
  {
    std::vector<double*> addresses;
    for (const Ijk& counts : this->layout.counts)
    {
      this->points.emplace_back(3 * std::size_t(counts[0]) * counts[1] * counts[2], std::nan(""));
    }
    for (std::vector<double>& block : this->points)
    {
      addresses.push_back(block.data());
    }
    wingFuselagePoints(options, this->body, addresses, run);
  }

  GridView view(int block) const { return GridView(this->points[block].data(), this->layout.counts[block]); }

  BlockMesh mesh() const
  {
    BlockMesh mesh;
    for (int b = 0; b < static_cast<int>(this->points.size()); ++b)
    {
      MeshBlock block;
      block.points = this->view(b);
      block.name = this->layout.names[b];
      mesh.blocks.push_back(block);
    }
    mesh.interfaces = this->layout.interfaces;
    mesh.boundaries = this->layout.boundaries;
    mesh.boundaryNames = this->layout.boundaryNames;
    mesh.creases = this->layout.creases;
    return mesh;
  }

  double minimumJacobian() const
  {
    double minimum = 1.0;
    for (int b = 0; b < static_cast<int>(this->points.size()); ++b)
    {
      minimum = std::min(minimum, minimumScaledJacobian(this->view(b)));
    }
    return minimum;
  }

  WingFuselageLayout layout;
  std::vector<BodyPatch> body;
  std::vector<std::vector<double>> points;
};

WingFuselageOptions atResolution(int resolution)
{
  WingFuselageOptions options;
  options.resolution = resolution;
  return options;
}

ConversionOptions conversionOptions(const WingFuselageLayout& layout)
{
  ConversionOptions options;
  for (const std::string& name : layout.boundaryNames)
  {
    options.roles.push_back(name.compare(0, 4, "wall") == 0 ? BoundaryRole::Body
        : name == "symmetry"                                ? BoundaryRole::Symmetry
                                                            : BoundaryRole::Other);
  }
  return options;
}

/// Geometry at t on a side of a patch.
SurfaceGeometry onSide(const std::vector<BodyPatch>& body, const PatchSide& side, double t)
{
  const double fixed = side.side % 2;
  return side.side < 2 ? surfaceGeometry(body[side.patch].surface, fixed, t)
                       : surfaceGeometry(body[side.patch].surface, t, fixed);
}

double angle(const Vec3& a, const Vec3& b)
{
  return std::atan2(a.cross(b).norm(), a.dot(b)) / Degree;
}

} // namespace

TEST(WingFuselage, BlockStructure)
{
  const Case made(atResolution(3));
  const BlockMesh mesh = made.mesh();
  BlockComplexOptions declared;
  declared.findInterfaces = false;
  const BlockComplex complex = buildBlockComplex(mesh, declared);
  ASSERT_EQ(complex.blocks.size(), std::size_t(Blocks));
  EXPECT_TRUE(complex.weldedPoints.empty()) << "shared points differ in their bits";
  EXPECT_EQ(complex.tangledCells, 0);
  EXPECT_TRUE(complex.warnings.empty());

  std::set<int> vertices, edges, faces;
  for (int b = 0; b < 40; ++b)
  {
    vertices.insert(complex.blocks[b].vertices.begin(), complex.blocks[b].vertices.end());
    edges.insert(complex.blocks[b].edges.begin(), complex.blocks[b].edges.end());
    faces.insert(complex.blocks[b].faces.begin(), complex.blocks[b].faces.end());
  }
  const auto shared = [](const std::set<int>& inside, const auto& own) {
    return std::count_if(own.begin(), own.end(), [&](int entity) { return inside.count(entity) > 0; });
  };
  for (int b = 40; b < Blocks; ++b)
  {
    EXPECT_EQ(shared(faces, complex.blocks[b].faces), b < 59 ? 1 : 0) << b;
    if (b >= 59)
    {
      // By an edge, of two corners, or by a corner only.
      EXPECT_EQ(shared(vertices, complex.blocks[b].vertices), 1 + shared(edges, complex.blocks[b].edges)) << b;
    }
  }

  // The search for coincident points finds the same contacts, and no others.
  BlockMesh bare = made.mesh();
  bare.interfaces.clear();
  bare.boundaries.clear();
  const BlockComplex found = buildBlockComplex(bare);
  EXPECT_EQ(found.blocks.size(), complex.blocks.size());
  EXPECT_EQ(found.faces.size(), complex.faces.size());
  EXPECT_EQ(found.vertices.size(), complex.vertices.size());

  // Every boundary face has a name, the symmetry plane is one, and what is named far field is the rest of the hull.
  for (const ComplexFace& face : complex.faces)
  {
    EXPECT_EQ(face.boundary(), face.tag >= 0);
  }
  for (const BoundaryPatch& patch : mesh.boundaries)
  {
    const GridView points = made.view(patch.block);
    const Ijk& counts = points.counts();
    const Ijk corner = facePoint({ counts[0] - 1, counts[1] - 1, counts[2] - 1 }, patch.face, 1, 1);
    const bool inPlane = mesh.boundaryNames[patch.tag] == "symmetry";
    EXPECT_EQ(points(corner)[1] == 0.0, inPlane);
  }
}

TEST(WingFuselage, CellsAreValid)
{
  for (const int resolution : { 2, 3, 4, 5, 6, 8, 12, 16, 24 })
  {
    const Case made(atResolution(resolution));
    const double minimum = made.minimumJacobian();
    std::printf("resolution %d: %lld points, smallest scaled Jacobian %.3f\n", resolution,
      static_cast<long long>(made.layout.points()), minimum);
    EXPECT_GT(minimum, 0.1) << resolution;
  }
}

TEST(WingFuselage, CellsAreValidAtTheLimits)
{
  double worst = 1.0;
  for (const int resolution : { 3, 8 })
  {
    for (int limits = 0; limits < 32; ++limits)
    {
      WingFuselageOptions options = atResolution(resolution);
      options.shape.span = limits & 1 ? 6.0 : 2.0;
      options.shape.sweepAngle = limits & 2 ? 45.0 : 0.0;
      options.firstLayerHeight = limits & 4 ? 1e-7 : 0.1;
      options.growthRatio = limits & 8 ? 2.0 : 1.02;
      options.farFieldDistance = limits & 16 ? 1000.0 : 2.0;
      const double minimum = Case(options).minimumJacobian();
      worst = std::min(worst, minimum);
      EXPECT_GT(minimum, 0.0) << "resolution " << resolution << ", combination " << limits;
    }
  }
  std::printf("smallest scaled Jacobian %.3f\n", worst);
}

TEST(WingFuselage, PointsGrowWithTheResolution)
{
  // From 10 thousand to more than 50 million, and never fewer at a higher resolution.
  Index before = 0;
  for (int resolution = 2; resolution <= 96; ++resolution)
  {
    const Index points = wingFuselageLayout(atResolution(resolution)).points();
    EXPECT_GT(points, before) << resolution;
    before = points;
  }
  EXPECT_LT(wingFuselageLayout(atResolution(2)).points(), 12000);
  EXPECT_GT(before, 50000000);
  // The wall: per n^2, 2 (1 + 2) patches of the fuselage, 6 (1 + 2) of the wing, the tip 2.
  const WingFuselageLayout layout = wingFuselageLayout(atResolution(10));
  Index cells = 0;
  for (int p = 0; p < WingFuselagePatches; ++p)
  {
    cells += Index(layout.counts[4 * p][0] - 1) * (layout.counts[4 * p][1] - 1);
  }
  EXPECT_EQ(cells, 26 * 100);
}

TEST(WingFuselage, LayersAtTheWall)
{
  WingFuselageOptions options;
  options.firstLayerHeight = 1e-4;
  const Case made(options);
  double largest = 0.0;
  for (int p = 0; p < WingFuselagePatches; ++p)
  {
    const GridView points = made.view(4 * p);
    const Ijk& counts = points.counts();
    for (int j = 0; j < counts[1]; ++j)
    {
      for (int i = 0; i < counts[0]; ++i)
      {
        const Vec3 n =
          surfaceGeometry(made.body[p].surface, double(i) / (counts[0] - 1), double(j) / (counts[1] - 1)).normal;
        const double first = n.dot(points(i, j, 1) - points(i, j, 0));
        const double second = n.dot(points(i, j, 2) - points(i, j, 1));
        largest = std::max(largest, std::abs(first / options.firstLayerHeight - 1.0));
        EXPECT_LT(second / first, options.growthRatio * 1.02);
      }
    }
  }
  // Lines bend by the second order of the height, which is 5e-5 of their length; corners are in least squares.
  EXPECT_LT(largest, 0.02);
}

TEST(WingFuselage, BodyHasNoGaps)
{
  for (const WingFuselageShape& shape :
    { WingFuselageShape(), WingFuselageShape{ 2.0, 0.0 }, WingFuselageShape{ 6.0, 45.0 } })
  {
    const std::vector<BodyPatch> body = wingFuselageBody(shape);
    ASSERT_EQ(body.size(), std::size_t(WingFuselagePatches));
    std::set<std::array<int, 2>> sides;
    for (const PatchSeam& seam : wingFuselageSeams())
    {
      sides.insert({ seam.first.patch, seam.first.side });
      sides.insert({ seam.second.patch, seam.second.side });
      double smallest = 180.0, largest = 0.0;
      for (int n = 0; n <= 256; ++n)
      {
        // Parameters and their mirror images without rounding.
        const double t = n / 256.0;
        const SurfaceGeometry a = onSide(body, seam.first, t);
        const SurfaceGeometry b = onSide(body, seam.second, seam.reversed ? 1.0 - t : t);
        EXPECT_LT((a.point - b.point).norm(), 4e-15) << seam.first.patch << " " << seam.second.patch << " " << t;
        smallest = std::min(smallest, angle(a.normal, b.normal));
        largest = std::max(largest, angle(a.normal, b.normal));
      }
      if (seam.crease)
      {
        EXPECT_GT(largest, 30.0) << seam.first.patch << " " << seam.second.patch;
      }
      else
      {
        // What the interpolation leaves; most at the round end of the leading edge.
        EXPECT_LT(largest, 1.0) << seam.first.patch << " " << seam.second.patch;
      }
    }
    // All others lie in the symmetry plane.
    EXPECT_EQ(sides.size(), std::size_t(4 * WingFuselagePatches - 4));
    for (int p = 0; p < 4; ++p)
    {
      EXPECT_EQ(sides.count({ p, 2 }), 0u);
      for (int n = 0; n <= 64; ++n)
      {
        EXPECT_EQ(onSide(body, { p, 2 }, n / 64.0).point[1], 0.0);
      }
    }
    // Closed by the symmetry plane: the area vector of the rest is normal to it.
    Vec3 area = Vec3::Zero();
    for (const BodyPatch& patch : body)
    {
      constexpr int Cells = 128;
      for (int j = 0; j < Cells; ++j)
      {
        for (int i = 0; i < Cells; ++i)
        {
          const auto at = [&](int a, int b) {
            return evaluate(patch.surface, double(i + a) / Cells, double(j + b) / Cells).x;
          };
          area += 0.5 * (at(1, 1) - at(0, 0)).cross(at(0, 1) - at(1, 0));
        }
      }
    }
    EXPECT_LT(std::hypot(area[0], area[2]), 1e-12);
    EXPECT_GT(area[1], 3.0);
  }
}

TEST(WingFuselage, WallPassesThroughTheBody)
{
  for (const int resolution : { 2, 3, 8 })
  {
    const Case made(atResolution(resolution));
    const BlockMesh mesh = made.mesh();
    const BodySurface body(made.body);
    const ConversionOptions options = conversionOptions(made.layout);
    const conversioncases::Converted converted = conversioncases::convert(mesh, options);
    double largest = 0.0, atCorners = 0.0;
    for (int p = 0; p < WingFuselagePatches; ++p)
    {
      const Ijk& counts = made.layout.counts[4 * p];
      for (int j = 0; j < counts[1]; ++j)
      {
        for (int i = 0; i < counts[0]; ++i)
        {
          // The point of the patch at the same parameters, not just any.
          const Vec3 x = evaluate(converted.volumes[4 * p], Vec3(i, j, 0.0));
          const Vec3 onBody =
            evaluate(made.body[p].surface, double(i) / (counts[0] - 1), double(j) / (counts[1] - 1)).x;
          // Next to the corners of patches the masks know nothing of the rules where creases meet or end.
          const bool next = std::min(i, counts[0] - 1 - i) < 2 && std::min(j, counts[1] - 1 - j) < 2;
          double& where = next ? atCorners : largest;
          where = std::max(where, (x - onBody).norm());
        }
      }
    }
    const WallDistances distances = wallDistances(converted.complex, options, body);
    std::printf("resolution %d: distance of the wall's mesh points %.3g, next to corners of patches %.3g, as control "
                "points %.3g\n",
      resolution, largest, atCorners, distances.inputPoints);
    EXPECT_LT(largest, 1e-11);
    EXPECT_GT(distances.inputPoints, 1e-4);
    EXPECT_LT(atCorners, 0.05 * distances.inputPoints);
  }
}

TEST(WingFuselage, Conversion)
{
  const Case made(atResolution(4));
  const BodySurface body(made.body);
  ConversionOptions options = conversionOptions(made.layout);
  options.body = &body;
  const BlockMesh mesh = made.mesh();
  const conversioncases::Converted converted = conversioncases::convert(mesh, options);
  ASSERT_EQ(converted.volumes.size(), std::size_t(Blocks));
  EXPECT_EQ(conversioncases::interfaceJumps(converted).openControlPoints, 0);
  Index valid = 0, others = 0;
  for (const BSplineVolume& volume : converted.volumes)
  {
    const JacobianReport report = jacobianBounds(volume, "block");
    valid += report.valid;
    others += report.invalid + report.undecided;
  }
  EXPECT_GT(valid, 10000);
  EXPECT_EQ(others, 0);

  // C2 where all is regular.
  const conversioncases::Jumps jumps = conversioncases::interfaceJumps(converted);
  EXPECT_EQ(jumps.openControlPoints, 0);
  EXPECT_GT(jumps.regular, 5000);
  for (const double jump : jumps.worst)
  {
    EXPECT_LE(jump, 1.0);
  }
}

TEST(WingFuselage, Threads)
{
  const Case one(atResolution(5));
  const Case two(atResolution(5), conversioncases::twoThreads());
  for (int b = 0; b < Blocks; ++b)
  {
    ASSERT_EQ(one.points[b].size(), two.points[b].size());
    EXPECT_EQ(std::memcmp(one.points[b].data(), two.points[b].data(), sizeof(double) * one.points[b].size()), 0) << b;
  }
}

TEST(WingFuselage, BadOptions)
{
  const auto message = [](const WingFuselageOptions& options) -> std::string {
    try
    {
      wingFuselageLayout(options);
    }
    catch (const Error& error)
    {
      return error.what();
    }
    return "";
  };
  const double nan = std::nan("");
  WingFuselageOptions options = atResolution(1);
  EXPECT_EQ(message(options), "Resolution 1 is not between 2 and 96");
  options = {};
  options.shape.span = 7.0;
  EXPECT_EQ(message(options), "Span 7 is not between 2 and 6");
  options = {};
  options.shape.sweepAngle = -1.0;
  EXPECT_EQ(message(options), "Sweep Angle -1 is not between 0 and 45");
  options = {};
  options.farFieldDistance = nan;
  EXPECT_EQ(message(options), "Far Field Distance nan is not between 2 and 1000");
  options = {};
  options.firstLayerHeight = 0.0;
  EXPECT_EQ(message(options), "First Layer Height 0 is not between 1e-07 and 0.1");
  options = {};
  options.growthRatio = 1.0;
  EXPECT_EQ(message(options), "Growth Ratio 1 is not between 1.02 and 2");
  options = atResolution(80);
  options.firstLayerHeight = 0.05;
  EXPECT_NE(
    message(options).find("First Layer Height 0.05 is larger than the outer cells, 0.025 high"), std::string::npos)
    << message(options);
  EXPECT_THROW(wingFuselageBody({ 1.0, 25.0 }), Error);
}

// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/G2File.h"

#include <map>

namespace bsv
{

namespace
{

const std::map<int, std::string>& classNames()
{
  static const std::map<int, std::string> names = { { 100, "spline curve" }, { 110, "curve on surface" },
    { 120, "line" }, { 130, "circle" }, { 140, "ellipse" }, { 150, "bounded curve" }, { 160, "hyperbola" },
    { 170, "parabola" }, { 200, "spline surface" }, { 210, "bounded (trimmed) surface" }, { 220, "surface on volume" },
    { 250, "plane" }, { 260, "cylinder" }, { 270, "sphere" }, { 280, "cone" }, { 290, "torus" },
    { 291, "surface of revolution" }, { 292, "disc" }, { 400, "point cloud" }, { 410, "line cloud" },
    { 700, "spline volume" }, { 710, "bounded volume" } };
  return names;
}

/// The class if a line is a header, else 0: a known class, version 1 0, the number of auxiliary data and these. All of
/// them whole numbers; a point can look so only with weight 0.
int classOfHeader(const std::string& line)
{
  if (line.find_first_not_of("0123456789 \t") != std::string::npos)
  {
    return 0;
  }
  TextScanner in(line, {});
  try
  {
    const int code = in.integer("", 0, 999);
    if (classNames().count(code) == 0)
    {
      return 0;
    }
    in.integer("", 1, 1);
    in.integer("", 0, 0);
    for (int extra = in.integer("", 0, 64); extra > 0; --extra)
    {
      in.next<long long>("");
    }
    return in.atEnd() ? code : 0;
  }
  catch (const Error&)
  {
    return 0;
  }
}

} // namespace

std::string nameOfG2Class(int code)
{
  const auto found = classNames().find(code);
  return found == classNames().end() ? "unknown" : found->second;
}

int readG2Header(TextScanner& in)
{
  const int code = in.integer("the class", 0, 999999);
  in.integer("the major version", 0, 999);
  in.integer("the minor version", 0, 999);
  const int extra = in.integer("the number of auxiliary data", 0, 64);
  for (int i = 0; i < extra; ++i)
  {
    in.next<long long>("auxiliary data");
  }
  return code;
}

G2Spline readG2Spline(TextScanner& in, int code, int maxDegree)
{
  const int directions = code == G2Volume ? 3 : code == G2Surface ? 2 : 1;
  const int dimension = in.integer("the dimension", 1, 3);
  const bool rational = in.integer("the rational flag", 0, 1) == 1;
  if (directions > 1 && dimension != 3)
  {
    in.fail(std::string("the ") + (directions == 2 ? "surface" : "volume") + " has dimension " +
      std::to_string(dimension) + " instead of 3");
  }
  G2Spline spline;
  double count = 1.0;
  for (int d = 0; d < directions; ++d)
  {
    const int points = in.integer("the number of control points", 2, 1 << 28);
    const int order = in.integer("the order", 2, maxDegree + 1);
    if (order > points)
    {
      in.fail("the order " + std::to_string(order) + " exceeds the number of control points " + std::to_string(points));
    }
    count *= points;
    in.expect(count * dimension, "control points");
    spline.degree[d] = order - 1;
    spline.knots[d].resize(static_cast<std::size_t>(points) + order);
    for (std::size_t i = 0; i < spline.knots[d].size(); ++i)
    {
      spline.knots[d][i] = in.next<double>("a knot");
      if (i > 0 && spline.knots[d][i] < spline.knots[d][i - 1])
      {
        in.fail("a knot is smaller than the one before it");
      }
    }
  }
  in.expect(count * (dimension + rational), "control points");
  spline.points.resize(static_cast<std::size_t>(count), Vec3::Zero());
  spline.weights.resize(rational ? spline.points.size() : 0);
  for (std::size_t i = 0; i < spline.points.size(); ++i)
  {
    for (int c = 0; c < dimension; ++c)
    {
      spline.points[i][c] = in.next<double>("a coordinate");
    }
    if (rational)
    {
      const double weight = in.next<double>("a weight");
      if (!(weight > 0.0))
      {
        in.fail("the weight " + std::to_string(weight) + " is not positive");
      }
      spline.points[i] /= weight;
      if (!spline.points[i].allFinite())
      {
        in.fail("the point divided by its weight is not finite");
      }
      spline.weights[i] = weight;
    }
  }
  return spline;
}

void skipG2Object(TextScanner& in)
{
  while (!in.atEnd())
  {
    TextScanner line = in;
    if (classOfHeader(line.restOfLine()) != 0)
    {
      return;
    }
    in.restOfLine();
  }
}

bool hasG2Class(const std::string& text, int code)
{
  TextScanner in(text, {});
  while (!in.atEnd())
  {
    if (classOfHeader(in.restOfLine()) == code)
    {
      return true;
    }
  }
  return false;
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
#include "NURBSFile.h"

#include "BSplineVolume.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>

namespace bsv
{

namespace
{

constexpr int MaxCutsPerSpan = 32;

std::string readAll(const std::string& fileName)
{
  std::ifstream stream(fileName, std::ios::binary);
  if (!stream)
  {
    throw Error(fileName + ": cannot be opened");
  }
  std::string text{ std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>() };
  if (stream.bad())
  {
    throw Error(fileName + ": cannot be read");
  }
  return text;
}

/// Numbers of a text, with line numbers for messages.
class Scanner
{
public:
  Scanner(const std::string& text, const std::string& fileName)
    : At(text.data())
    , End(text.data() + text.size())
    , FileName(fileName)
  {
  }

  [[noreturn]] void fail(const std::string& what) const
  {
    throw Error(this->FileName + ", line " + std::to_string(this->Line) + ": " + what);
  }

  bool atEnd()
  {
    for (; this->At != this->End; ++this->At)
    {
      if (*this->At == '\n')
      {
        ++this->Line;
      }
      else if (*this->At != ' ' && *this->At != '\t' && *this->At != '\r')
      {
        return false;
      }
    }
    return true;
  }

  template <typename Number>
  Number next(const char* what)
  {
    if (this->atEnd())
    {
      this->fail(std::string("the file ends where ") + what + " should follow");
    }
    const char* end = std::find_if(this->At, this->End, [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); });
    Number value{};
    // from_chars knows no plus sign.
    const char* begin = *this->At == '+' ? this->At + 1 : this->At;
    const auto result = std::from_chars(begin, end, value);
    if (result.ec != std::errc() || result.ptr != end || !std::isfinite(static_cast<double>(value)))
    {
      this->fail("'" + std::string(this->At, std::min(end, this->At + 40)) + "' is no " +
        (std::is_integral<Number>::value ? "whole number" : "finite number") + " (" + what + ")");
    }
    this->At = end;
    return value;
  }

  int integer(const char* what, int low, int high)
  {
    const long long value = this->next<long long>(what);
    if (value < low || value > high)
    {
      this->fail(std::string(what) + " is " + std::to_string(value) + ", not in " + std::to_string(low) + ".." +
        std::to_string(high));
    }
    return static_cast<int>(value);
  }

  /// @throws Error if the rest of the file cannot hold so many numbers.
  void expect(double numbers) const
  {
    if (numbers > static_cast<double>(this->End - this->At) / 2.0 + 1.0)
    {
      this->fail("the file is too short for the number of control points that is given here");
    }
  }

private:
  const char* At;
  const char* End;
  int Line = 1;
  std::string FileName;
};

std::string className(int code)
{
  static const std::map<int, std::string> names = { { 110, "curve on surface" }, { 120, "line" }, { 130, "circle" },
    { 140, "ellipse" }, { 150, "bounded curve" }, { 160, "hyperbola" }, { 170, "parabola" },
    { 210, "bounded (trimmed) surface" }, { 220, "surface on volume" }, { 250, "plane" }, { 260, "cylinder" },
    { 270, "sphere" }, { 280, "cone" }, { 290, "torus" }, { 291, "surface of revolution" }, { 292, "disc" },
    { 400, "point cloud" }, { 410, "line cloud" }, { 700, "spline volume" }, { 710, "bounded volume" } };
  const auto found = names.find(code);
  return found == names.end() ? "unknown" : found->second;
}

} // namespace

std::string formatOfNURBSFile(const std::string& fileName)
{
  std::ifstream stream(fileName, std::ios::binary);
  std::string head(512, '\0');
  stream.read(&head[0], static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  const std::size_t start = head.find_first_not_of(" \t\r\n");
  if (start == std::string::npos)
  {
    return {};
  }
  if (head.compare(start, 12, "ISO-10303-21") == 0)
  {
    return "STEP";
  }
  if (head.compare(start, 20, "DBRep_DrawableShape") == 0 || head.compare(start, 19, "DBRep_DrawableShape") == 0 ||
    head.compare(start, 16, "CASCADE Topology") == 0)
  {
    return "BREP";
  }
  // The first card of an IGES file says S and 1 in its columns 73 to 80.
  if (head.size() >= 80 && head[72] == 'S' && head.find_first_not_of(" 0", 73) == 79 && head[79] == '1')
  {
    return "IGES";
  }
  // Four whole numbers, the first a class.
  std::size_t digits = start;
  while (digits < head.size() && head[digits] >= '0' && head[digits] <= '9')
  {
    ++digits;
  }
  if (digits == start + 3 && digits < head.size() && (head[digits] == ' ' || head[digits] == '\t'))
  {
    return "GoTools g2";
  }
  return {};
}

NURBSFileContent parseG2(const std::string& text, const std::string& fileName)
{
  NURBSFileContent content;
  content.format = "GoTools g2";
  Scanner in(text, fileName);
  int curves = 0;
  while (!in.atEnd())
  {
    const int code = in.integer("the class", 0, 999999);
    in.integer("the major version", 0, 999);
    in.integer("the minor version", 0, 999);
    const int extra = in.integer("the number of auxiliary data", 0, 64);
    for (int i = 0; i < extra; ++i)
    {
      in.next<long long>("auxiliary data");
    }
    if (code != 200 && code != 100)
    {
      in.fail("class " + std::to_string(code) + " (" + className(code) +
        ") is not supported; of GoTools files only spline surfaces (class 200) are read");
    }
    const int directions = code == 200 ? 2 : 1;
    const int dimension = in.integer("the dimension", 1, 3);
    const bool rational = in.integer("the rational flag", 0, 1) == 1;
    if (directions == 2 && dimension != 3)
    {
      in.fail("the surface has dimension " + std::to_string(dimension) + " instead of 3");
    }
    BodyPatch patch;
    double points = 1.0;
    for (int d = 0; d < directions; ++d)
    {
      const int count = in.integer("the number of control points", 2, 1 << 28);
      const int order = in.integer("the order", 2, MaxSurfaceDegree + 1);
      if (order > count)
      {
        in.fail(
          "the order " + std::to_string(order) + " exceeds the number of control points " + std::to_string(count));
      }
      points *= count;
      in.expect(points * dimension);
      patch.surface.degree[d] = order - 1;
      patch.surface.knots[d].resize(static_cast<std::size_t>(count) + order);
      for (double& knot : patch.surface.knots[d])
      {
        const double last = &knot == patch.surface.knots[d].data() ? knot : *(&knot - 1);
        knot = in.next<double>("a knot");
        if (&knot != patch.surface.knots[d].data() && knot < last)
        {
          in.fail("a knot is smaller than the one before it");
        }
      }
    }
    in.expect(points * (dimension + rational));
    if (directions == 1)
    {
      ++curves;
      for (double i = 0; i < points * (dimension + rational); ++i)
      {
        in.next<double>("a coordinate");
      }
      continue;
    }
    for (double i = 0; i < points; ++i)
    {
      Vec3 x;
      for (int c = 0; c < 3; ++c)
      {
        x[c] = in.next<double>("a coordinate");
      }
      if (rational)
      {
        const double weight = in.next<double>("a weight");
        if (!(weight > 0.0))
        {
          in.fail("the weight " + std::to_string(weight) + " is not positive");
        }
        x /= weight;
        patch.surface.weights.push_back(weight);
      }
      patch.surface.points.push_back(x);
    }
    patch.name = "Surface " + std::to_string(content.patches.size() + 1);
    try
    {
      checkBodyPatch(patch, "surface " + std::to_string(content.patches.size() + 1));
    }
    catch (const Error& error)
    {
      in.fail(std::string("before this line: ") + error.what());
    }
    content.patches.push_back(std::move(patch));
    content.layers.emplace_back();
  }
  if (curves > 0)
  {
    content.others.emplace_back("spline curve", curves);
  }
  return content;
}

void tessellateDomain(const NURBSSurface& surface, int patch, double tolerance, BodyTessellation& tessellation)
{
  std::array<std::vector<double>, 2> lines;
  for (int d = 0; d < 2; ++d)
  {
    const std::vector<int> spans = nonEmptySpans(surface.degree[d], surface.knots[d]);
    std::vector<double> others;
    const int o = 1 - d;
    for (const int s : nonEmptySpans(surface.degree[o], surface.knots[o]))
    {
      others.push_back(surface.knots[o][s]);
      others.push_back(0.5 * (surface.knots[o][s] + surface.knots[o][s + 1]));
    }
    others.push_back(surface.last(o));
    for (const int s : spans)
    {
      const double a = surface.knots[d][s];
      const double b = surface.knots[d][s + 1];
      // The sag of a chord over h is h^2 |x''| / 8; half the tolerance for each direction.
      double second = 0.0;
      for (const double other : others)
      {
        for (const double t : { a + 1e-6 * (b - a), 0.5 * (a + b), b - 1e-6 * (b - a) })
        {
          const SurfaceDerivatives at = d == 0 ? evaluate(surface, t, other) : evaluate(surface, other, t);
          second = std::max(second, (d == 0 ? at.uu : at.vv).norm());
        }
      }
      const double cuts = std::ceil((b - a) * std::sqrt(second / (4.0 * tolerance)));
      const int parts = static_cast<int>(std::min(std::max(cuts, 1.0), double(MaxCutsPerSpan)));
      for (int i = 0; i < parts; ++i)
      {
        lines[d].push_back(a + (b - a) * i / parts);
      }
    }
    lines[d].push_back(surface.last(d));
  }
  const int first = static_cast<int>(tessellation.vertices.size());
  const int row = static_cast<int>(lines[0].size());
  std::vector<Vec3> points;
  for (const double v : lines[1])
  {
    for (const double u : lines[0])
    {
      tessellation.vertices.push_back({ patch, u, v });
      points.push_back(evaluate(surface, u, v).x);
    }
  }
  const auto add = [&](int a, int b, int c) {
    // At a pole one side of a cell has no length.
    if (points[a] != points[b] && points[b] != points[c] && points[c] != points[a])
    {
      tessellation.triangles.push_back({ first + a, first + b, first + c });
    }
  };
  for (int j = 0; j + 1 < static_cast<int>(lines[1].size()); ++j)
  {
    for (int i = 0; i + 1 < row; ++i)
    {
      const int at = i + j * row;
      add(at, at + 1, at + row + 1);
      add(at, at + row + 1, at + row);
    }
  }
}

NURBSFileContent readNURBSFile(const std::string& fileName, double tolerance, const Execution& run)
{
  if (!(tolerance > 0.0))
  {
    throw Error("the tessellation tolerance is " + std::to_string(tolerance) + ", not positive");
  }
  const std::string format = formatOfNURBSFile(fileName);
  if (format.empty())
  {
    // Says why, if it cannot even be opened.
    const std::string text = readAll(fileName);
    throw Error(
      fileName + (text.empty() ? ": the file is empty" : ": neither an IGES, STEP, BREP nor a GoTools g2 file"));
  }
  NURBSFileContent content;
  if (format == "GoTools g2")
  {
    content = parseG2(readAll(fileName), fileName);
    Eigen::AlignedBox3d box;
    for (const BodyPatch& patch : content.patches)
    {
      for (const Vec3& point : patch.surface.points)
      {
        box.extend(point);
      }
    }
    for (std::size_t i = 0; i < content.patches.size(); ++i)
    {
      run.report(static_cast<double>(i) / static_cast<double>(content.patches.size()));
      tessellateDomain(content.patches[i].surface, static_cast<int>(i),
        std::max(tolerance * box.diagonal().norm(), 1e-300), content.tessellation);
    }
  }
  else
  {
    content = readCADFile(fileName, format, tolerance, run);
  }
  if (content.patches.empty())
  {
    std::string held;
    for (const auto& other : content.others)
    {
      held += (held.empty() ? "; it holds: " : ", ") + std::to_string(other.second) + " " + other.first;
    }
    throw Error(fileName + ": the " + format + " file holds no surface" + held);
  }
  return content;
}

} // namespace bsv

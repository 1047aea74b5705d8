// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/NURBSFile.h"

#include "Formats/CADText.h"
#include "Formats/G2File.h"
#include "Formats/ReaderJobs.h"
#include "IO/Encodings.h"
#include "IO/RegularFile.h"
#include "Volume/BSplineVolume.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace bsv
{

namespace
{

constexpr int MaxCutsPerSpan = 32;

} // namespace

namespace
{

/// formatOfNURBSFile() that says what is wrong with what is nearly one of the formats.
std::string formatOrError(const std::string& fileName)
{
  if (!isRegularFile(fileName))
  {
    return {};
  }
  std::ifstream stream(fileName, std::ios::binary);
  std::string head(4096, '\0');
  stream.read(&head[0], static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  std::string format = formatOfCADText(head);
  if (!format.empty())
  {
    return format;
  }
  const std::size_t start = head.find_first_not_of(" \t\r\n", startsWithMark(head) ? 3 : 0);
  if (start == std::string::npos)
  {
    return {};
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

} // namespace

std::string formatOfNURBSFile(const std::string& fileName)
{
  try
  {
    return formatOrError(fileName);
  }
  catch (const Error&)
  {
    return {};
  }
}

NURBSFileContent parseG2(const std::string& text, const std::string& fileName, const Execution& run)
{
  NURBSFileContent content;
  content.format = "GoTools g2";
  TextScanner in(text, fileName);
  in.reportTo(run);
  int curves = 0;
  while (!in.atEnd())
  {
    const int code = readG2Header(in);
    if (code != G2Surface && code != G2Curve)
    {
      in.fail("class " + std::to_string(code) + " (" + nameOfG2Class(code) +
        ") is not supported; of GoTools files only spline surfaces (class 200) are read");
    }
    G2Spline spline = readG2Spline(in, code, MaxSurfaceDegree);
    if (code == G2Curve)
    {
      ++curves;
      continue;
    }
    BodyPatch patch;
    for (int d = 0; d < 2; ++d)
    {
      patch.surface.degree[d] = spline.degree[d];
      patch.surface.knots[d] = std::move(spline.knots[d]);
    }
    patch.surface.points = std::move(spline.points);
    patch.surface.weights = std::move(spline.weights);
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
    content.others.emplace_back(nameOfG2Class(G2Curve), curves);
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
  std::string format;
  try
  {
    format = formatOrError(fileName);
  }
  catch (const Error& error)
  {
    throw Error(fileName + ": " + error.what());
  }
  if (format.empty())
  {
    // Says why, if it cannot even be opened.
    requireRegularFile(fileName);
    std::ifstream stream(fileName, std::ios::binary);
    if (!stream)
    {
      throw Error(fileName + ": cannot be opened");
    }
    std::string start(8, ' ');
    stream.read(start.data(), static_cast<std::streamsize>(start.size()));
    const std::string what = otherEncoding(start);
    throw Error(fileName + ": " +
      (stream.gcount() == 0 ? "the file is empty"
          : !what.empty()   ? "the file is " + what
                            : "neither an IGES, STEP, BREP nor a GoTools g2 file"));
  }
  NURBSFileContent content;
  if (format == "GoTools g2")
  {
    std::string text = readTextFile(fileName);
    content = parseG2(startsWithMark(text) ? text.substr(3) : text, fileName, run);
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
    content = readCADFileApart(fileName, format, tolerance, run);
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

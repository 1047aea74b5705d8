// SPDX-License-Identifier: BSD-3-Clause
#include "Volume/FaceGeometry.h"

#include "Mesh/BlockTopology.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace bsv
{

namespace
{

using Vec4 = Eigen::Vector4d;

/// The B-splines that are not zero at a parameter, with their first two derivatives.
struct Station
{
  int first;
  std::array<std::array<double, MaxDegree + 1>, 3> values;
};

Station stationAt(const BSplineVolume& volume, int direction, int span, double left, double right)
{
  const int degree = volume.degree[direction];
  const std::vector<double>& knots = volume.knots[direction];
  std::array<double, MaxDegree + 1> toLeft{};
  std::array<double, MaxDegree + 1> toRight{};
  for (int j = 1; j <= degree; ++j)
  {
    toLeft[j] = left + (knots[span] - knots[span + 1 - j]);
    toRight[j] = right + (knots[span + j] - knots[span + 1]);
  }
  Station station{ span - degree, {} };
  for (int order = 0; order <= std::min(2, degree); ++order)
  {
    basisFunctions(degree, order, toLeft.data(), toRight.data(), station.values[order].data());
  }
  return station;
}

std::vector<Station> stations(
  const BSplineVolume& volume, int direction, int parts, bool bothSides, std::vector<double>& parameters)
{
  std::vector<Station> result;
  const std::vector<double>& knots = volume.knots[direction];
  const std::vector<int> spans = nonEmptySpans(volume.degree[direction], knots);
  for (const int span : spans)
  {
    const double width = knots[span + 1] - knots[span];
    const bool ends = span == spans.back() || (bothSides && isRepeatedKnot(volume.degree[direction], knots, span + 1));
    for (int j = 0; j < parts + (ends ? 1 : 0); ++j)
    {
      parameters.push_back(j == parts ? knots[span + 1] : knots[span] + width * j / parts);
      result.push_back(stationAt(volume, direction, span, width * j / parts, width * (parts - j) / parts));
    }
  }
  return result;
}

} // namespace

FaceGeometry faceGeometry(
  const BSplineVolume& volume, int face, int parts, const Execution& run, int layer, bool bothSides)
{
  const int across = faceDirection(face);
  const int alongS = faceAxis(face, 0);
  const int alongT = faceAxis(face, 1);
  const int counts[2] = { volume.count(alongS), volume.count(alongT) };
  const Index strides[3] = { 1, volume.count(0), Index(volume.count(0)) * volume.count(1) };

  // The net of the face and of the derivative across it.
  const std::vector<int> spans = nonEmptySpans(volume.degree[across], volume.knots[across]);
  const bool last = faceSide(face) == 1;
  const int deepest = static_cast<int>(spans.size());
  const int depth = std::min(layer, deepest);
  // Number of the knot among those that bound spans; the span beside it that is nearer to the face's opposite.
  const int knot = last ? deepest - depth : depth;
  const int beside = last ? std::max(knot - 1, 0) : std::min(knot, deepest - 1);
  const int span = spans[beside];
  const double width = volume.knots[across][span + 1] - volume.knots[across][span];
  const double left = knot == beside ? 0.0 : width;
  const Station end = stationAt(volume, across, span, left, width - left);
  std::array<std::vector<Vec4>, 2> nets;
  for (std::vector<Vec4>& net : nets)
  {
    net.resize(std::size_t(counts[0]) * counts[1], Vec4::Zero());
  }
  for (int t = 0; t < counts[1]; ++t)
  {
    for (int s = 0; s < counts[0]; ++s)
    {
      for (int c = 0; c <= volume.degree[across]; ++c)
      {
        const Index at = s * strides[alongS] + t * strides[alongT] + (end.first + c) * strides[across];
        const double weight = volume.weights ? volume.weights[at] : 1.0;
        const double* x = volume.points + 3 * at;
        const Vec4 point(weight * x[0], weight * x[1], weight * x[2], weight);
        for (int order = 0; order < 2; ++order)
        {
          nets[order][s + std::size_t(counts[0]) * t] += end.values[order][c] * point;
        }
      }
    }
  }

  FaceGeometry result;
  const std::vector<Station> s = stations(volume, alongS, parts, bothSides, result.parameters[0]);
  const std::vector<Station> t = stations(volume, alongT, parts, bothSides, result.parameters[1]);
  result.samples = { static_cast<int>(s.size()), static_cast<int>(t.size()) };
  const std::size_t total = s.size() * t.size();
  result.points.resize(total);
  result.normals.resize(total);
  result.mean.resize(total);
  result.gaussian.resize(total);

  run.report(0.0);
  run.parallelFor(static_cast<Index>(t.size()), 16, [&](Index begin, Index endRow) {
    // Derivatives along t, and the one across, of the columns of control points.
    std::array<std::vector<Vec4>, 4> rows;
    for (Index row = begin; row < endRow; ++row)
    {
      for (int order = 0; order < 4; ++order)
      {
        rows[order].assign(counts[0], Vec4::Zero());
        const std::vector<Vec4>& net = nets[order == 3 ? 1 : 0];
        const auto& values = t[row].values[order == 3 ? 0 : order];
        for (int b = 0; b <= volume.degree[alongT]; ++b)
        {
          const Vec4* line = net.data() + std::size_t(counts[0]) * (t[row].first + b);
          for (int a = 0; a < counts[0]; ++a)
          {
            rows[order][a] += values[b] * line[a];
          }
        }
      }
      for (std::size_t column = 0; column < s.size(); ++column)
      {
        const Station& station = s[column];
        const auto sum = [&](int orderS, int net) {
          Vec4 value = Vec4::Zero();
          for (int a = 0; a <= volume.degree[alongS]; ++a)
          {
            value += station.values[orderS][a] * rows[net][station.first + a];
          }
          return value;
        };
        // Quotient rule, (4.20) of Piegl and Tiller; with weights 1 it changes nothing.
        const Vec4 h = sum(0, 0), hs = sum(1, 0), ht = sum(0, 1), hss = sum(2, 0), hst = sum(1, 1), htt = sum(0, 2);
        const Vec4 hn = sum(0, 3);
        const double w = h[3];
        const Vec3 x = h.head<3>() / w;
        const Vec3 xs = (hs.head<3>() - hs[3] * x) / w;
        const Vec3 xt = (ht.head<3>() - ht[3] * x) / w;
        const Vec3 xn = (hn.head<3>() - hn[3] * x) / w;
        const Vec3 xss = (hss.head<3>() - 2.0 * hs[3] * xs - hss[3] * x) / w;
        const Vec3 xst = (hst.head<3>() - hs[3] * xt - ht[3] * xs - hst[3] * x) / w;
        const Vec3 xtt = (htt.head<3>() - 2.0 * ht[3] * xt - htt[3] * x) / w;

        const std::size_t at = column + s.size() * row;
        result.points[at] = x;
        Vec3 normal = xs.cross(xt);
        const double area = normal.norm();
        // What rounding leaves of a tangent that vanishes, and of an angle.
        const auto rounding = [&](int orderS, int net) {
          double size = 0.0;
          for (int a = 0; a <= volume.degree[alongS]; ++a)
          {
            size += std::abs(station.values[orderS][a]) * rows[net][station.first + a].cwiseAbs().maxCoeff();
          }
          return 1e-12 * size / w;
        };
        if (!(area > 1e-10 * xs.norm() * xt.norm()) || !(xs.norm() > rounding(1, 0)) || !(xt.norm() > rounding(0, 1)))
        {
          result.normals[at] = Vec3::Zero();
          result.mean[at] = result.gaussian[at] = 0.0;
          continue;
        }
        normal /= normal.dot(last ? Vec3(-xn) : xn) < 0.0 ? -area : area;
        result.normals[at] = normal;
        const double e = xs.dot(xs), f = xs.dot(xt), g = xt.dot(xt);
        const double l = xss.dot(normal), m = xst.dot(normal), n = xtt.dot(normal);
        const double determinant = area * area;
        result.mean[at] = (e * n - 2.0 * f * m + g * l) / (2.0 * determinant);
        result.gaussian[at] = (l * n - m * m) / determinant;
      }
    }
  });

  // Poles: the values beside them.
  const Index across0 = static_cast<Index>(s.size());
  for (std::size_t at = 0; at < total; ++at)
  {
    if (!result.normals[at].isZero(0.0))
    {
      continue;
    }
    const Index i = static_cast<Index>(at) % across0, j = static_cast<Index>(at) / across0;
    for (const auto& step : { std::array<int, 2>{ 0, 1 }, { 0, -1 }, { 1, 0 }, { -1, 0 }, { 1, 1 }, { -1, -1 } })
    {
      const Index a = i + step[0], b = j + step[1];
      if (a < 0 || b < 0 || a >= across0 || b >= static_cast<Index>(t.size()))
      {
        continue;
      }
      const std::size_t beside = static_cast<std::size_t>(a + across0 * b);
      if (!result.normals[beside].isZero(0.0))
      {
        result.normals[at] = result.normals[beside];
        result.mean[at] = result.mean[beside];
        result.gaussian[at] = result.gaussian[beside];
        break;
      }
    }
  }
  return result;
}

} // namespace bsv

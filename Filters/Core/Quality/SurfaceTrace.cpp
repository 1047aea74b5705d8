// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/SurfaceTrace.h"

#include "Mesh/BlockTopology.h"

#include <algorithm>
#include <cmath>

namespace bsv
{

namespace
{

/// Weights of the control points next to a face, from the face inwards, for the value and the outward derivatives
/// there.
struct EndWeights
{
  int first; ///< control point on the face
  int step;  ///< +-1, inwards
  int count;
  double at;     ///< parameter of the face
  double length; ///< of the first span
  std::array<std::array<double, MaxDegree + 1>, 3> values;

  EndWeights(const BSplineVolume& volume, int face)
  {
    const int d = faceDirection(face);
    const int degree = volume.degree[d];
    const std::vector<double>& knots = volume.knots[d];
    const bool end = faceSide(face) != 0;
    const std::vector<int> spans = nonEmptySpans(degree, knots);
    const int span = end ? spans.back() : spans.front();
    this->first = end ? span : span - degree;
    this->step = end ? -1 : 1;
    this->count = degree + 1;
    this->at = knots[span + (end ? 1 : 0)];
    this->length = knots[span + 1] - knots[span];
    double left[MaxDegree + 1];
    double right[MaxDegree + 1];
    for (int j = 1; j <= degree; ++j)
    {
      left[j] = this->at - knots[span + 1 - j];
      right[j] = knots[span + j] - this->at;
    }
    for (int order = 0; order < 3; ++order)
    {
      basisFunctions(degree, order, left, right, this->values[order].data());
      if (end)
      {
        std::reverse(this->values[order].begin(), this->values[order].begin() + degree + 1);
      }
      else if (order == 1)
      {
        for (double& value : this->values[order])
        {
          value = -value;
        }
      }
    }
    while (this->count > 1 && this->values[0][this->count - 1] == 0.0 && this->values[1][this->count - 1] == 0.0 &&
      this->values[2][this->count - 1] == 0.0)
    {
      --this->count;
    }
  }
};

/// Block directions along the axes of a trace.
std::array<int, 2> traceAxes(int face, int within)
{
  const std::array<int, 2> axes{ faceAxis(face, 0), faceAxis(face, 1) };
  return within >= 0 && axes[0] == faceDirection(within) ? std::array<int, 2>{ axes[1], axes[0] } : axes;
}

} // namespace

double faceParameter(const BSplineVolume& volume, int face)
{
  return EndWeights(volume, face).at;
}

Trace emptyTrace(const BSplineVolume& volume, int face, int within)
{
  const std::array<int, 2> axes = traceAxes(face, within);
  Trace trace;
  trace.length = EndWeights(volume, face).length;
  for (int k = 0; k < (within < 0 ? 2 : 1); ++k)
  {
    trace.degree[k] = volume.degree[axes[k]];
    trace.count[k] = volume.count(axes[k]);
    trace.knots[k] = volume.knots[axes[k]];
  }
  return trace;
}

Trace makeTrace(const BSplineVolume& volume, int face, int within)
{
  const EndWeights across(volume, face);
  const std::array<int, 2> axes = traceAxes(face, within);
  Trace trace = emptyTrace(volume, face, within);
  trace.rational = volume.weights != nullptr;
  trace.net.reserve(trace.points());
  const std::array<Index, 3> stride{ 1, volume.count(0), Index(volume.count(0)) * volume.count(1) };
  const auto layers = [&](int i, int j) {
    Layers sum = Layers::Zero();
    Index place = i * stride[axes[0]] + j * stride[axes[1]] + across.first * stride[faceDirection(face)];
    for (int q = 0; q < across.count; ++q, place += across.step * stride[faceDirection(face)])
    {
      const double w = trace.rational ? volume.weights[place] : 1.0;
      const double* x = volume.points + 3 * place;
      const Homogeneous point(w * x[0], w * x[1], w * x[2], w);
      for (int order = 0; order < 3; ++order)
      {
        sum.segment<4>(4 * order) += across.values[order][q] * point;
      }
      for (int d = 0; d < 3; ++d)
      {
        // A NaN stays.
        trace.size = std::isnan(x[d]) || std::abs(x[d]) > trace.size ? std::abs(x[d]) : trace.size;
      }
    }
    return sum;
  };
  if (within < 0)
  {
    for (int j = 0; j < trace.count[1]; ++j)
    {
      for (int i = 0; i < trace.count[0]; ++i)
      {
        trace.net.push_back(layers(i, j));
      }
    }
    return trace;
  }
  const EndWeights side(volume, within);
  for (int i = 0; i < trace.count[0]; ++i)
  {
    Layers sum = Layers::Zero();
    for (int q = 0; q < side.count; ++q)
    {
      if (side.values[0][q] != 0.0)
      {
        sum += side.values[0][q] * layers(i, side.first + q * side.step);
      }
    }
    trace.net.push_back(sum);
  }
  return trace;
}

std::vector<double> packedTrace(const Trace& trace)
{
  std::vector<double> numbers{ trace.rational ? 1.0 : 0.0, trace.size };
  numbers.reserve(5 + 12 * trace.points());
  for (int layer = 0; layer < 3; ++layer)
  {
    numbers.push_back(trace.net[0][4 * layer + 3]);
  }
  for (const Layers& point : trace.net)
  {
    for (int layer = 0; layer < 3; ++layer)
    {
      numbers.insert(numbers.end(), point.data() + 4 * layer, point.data() + 4 * layer + (trace.rational ? 4 : 3));
    }
  }
  return numbers;
}

const double* unpackTrace(const double* numbers, Trace& trace)
{
  trace.rational = *numbers++ != 0.0;
  trace.size = *numbers++;
  const double* weights = numbers;
  numbers += 3;
  trace.net.resize(trace.points());
  for (Layers& point : trace.net)
  {
    for (int layer = 0; layer < 3; ++layer)
    {
      const int size = trace.rational ? 4 : 3;
      point[4 * layer + 3] = weights[layer];
      std::copy_n(numbers, size, point.data() + 4 * layer);
      numbers += size;
    }
  }
  return numbers;
}

} // namespace bsv

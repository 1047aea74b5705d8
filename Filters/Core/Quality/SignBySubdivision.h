// SPDX-License-Identifier: BSD-3-Clause
/// @file SignBySubdivision.h
/// Whether a polynomial in Bernstein form is positive, by halving.
#pragma once

#include "Quality/JacobianBounds.h"

#include <array>
#include <vector>

namespace bsv
{

/// SignVerdict on one polynomial, in the units in which it was computed.
struct SignVerdict
{
  Validity validity = Validity::Undecided;
  double lower;
  double upper;
  /// Where it is not positive, if invalid.
  std::array<double, 3> at{ 0.0, 0.0, 0.0 };
  double value = 0.0;
};

/// Decides the sign of polynomials in Bernstein form by halving.
class SignBySubdivision
{
public:
  SignBySubdivision(const std::array<int, 3>& counts, int maxDepth)
    : Counts(counts)
    , MaxDepth(maxDepth)
    , Size(static_cast<std::size_t>(counts[0]) * counts[1] * counts[2])
  {
  }

  std::vector<double>& root() { return this->part(0).coefficients; }

  /// @param error of the coefficients in root(); @param growth of it per rounded mean.
  SignVerdict operator()(double error, double growth);

private:
  struct Part
  {
    std::vector<double> coefficients;
    std::array<double, 3> start;
    std::array<double, 3> size;
    double error;
    int depth;
  };

  Part& part(std::size_t i);

  std::size_t cornerIndex(int corner) const;

  /// Calls visit(index of the first coefficient) for every row in direction d.
  template <typename Visitor>
  void rows(int d, Visitor&& visit) const
  {
    const int inner = d == 0 ? 1 : d == 1 ? this->Counts[0] : this->Counts[0] * this->Counts[1];
    const int block = inner * this->Counts[d];
    for (std::size_t o = 0; o < this->Size; o += block)
    {
      for (int i = 0; i < inner; ++i)
      {
        visit(o + i, inner);
      }
    }
  }

  /// Part `i` becomes the half with the larger coefficients, part i + 1 the other one: the next to be looked at.
  void halve(std::size_t i, double growth);

  std::array<int, 3> Counts;
  int MaxDepth;
  std::size_t Size;
  std::vector<Part> Parts;
};

} // namespace bsv

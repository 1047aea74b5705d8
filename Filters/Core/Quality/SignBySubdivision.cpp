// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/SignBySubdivision.h"

#include "Mesh/BlockTopology.h"
#include "Volume/BezierSegments.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bsv
{
namespace
{

constexpr double Infinity = std::numeric_limits<double>::infinity();

/// Parts of a span that are looked at before it is given up, and once it is known that it cannot be proven valid.
constexpr int MaxParts = 4096;
constexpr int MaxHopelessParts = 64;

} // namespace

SignVerdict SignBySubdivision::operator()(double error, double growth)
{
  SignVerdict verdict;
  const auto [low, high] = std::minmax_element(this->root().begin(), this->root().end());
  const double rootLower = *low - error;
  const double rootUpper = *high + error;
  verdict.lower = Infinity;
  verdict.upper = -Infinity;
  bool undecided = false;
  int budget = MaxParts;
  this->part(0).start = { 0.0, 0.0, 0.0 };
  this->part(0).size = { 1.0, 1.0, 1.0 };
  this->part(0).error = error;
  this->part(0).depth = 0;
  for (std::size_t top = 1; top > 0;)
  {
    Part& part = this->part(top - 1);
    --budget;
    const auto [smallest, largest] = std::minmax_element(part.coefficients.begin(), part.coefficients.end());
    const double lower = *smallest - part.error;
    const double upper = *largest + part.error;
    bool leaf = lower > 0.0;
    if (!leaf)
    {
      for (int corner = 0; corner < 8; ++corner)
      {
        const double value = part.coefficients[this->cornerIndex(corner)];
        if (value + part.error <= 0.0)
        {
          verdict.validity = Validity::Invalid;
          verdict.value = value + part.error;
          for (int d = 0; d < 3; ++d)
          {
            verdict.at[d] = part.start[d] + cornerSide(corner, d) * part.size[d];
          }
          verdict.lower = rootLower;
          verdict.upper = rootUpper;
          return verdict;
        }
        if (value - part.error <= 0.0)
        {
          // Zero up to rounding: no halving proves it positive, another part may still be negative.
          budget = std::min(budget, MaxHopelessParts);
        }
      }
      leaf = part.depth >= this->MaxDepth || budget <= 0;
      undecided = undecided || leaf;
    }
    if (leaf)
    {
      verdict.lower = std::min(verdict.lower, lower);
      verdict.upper = std::max(verdict.upper, upper);
      --top;
    }
    else
    {
      this->halve(top - 1, growth);
      ++top;
    }
  }
  verdict.lower = std::max(verdict.lower, rootLower);
  verdict.upper = std::min(verdict.upper, rootUpper);
  verdict.validity = undecided ? Validity::Undecided : Validity::Valid;
  return verdict;
}

SignBySubdivision::Part& SignBySubdivision::part(std::size_t i)
{
  while (this->Parts.size() <= i)
  {
    this->Parts.emplace_back();
    this->Parts.back().coefficients.resize(this->Size);
  }
  return this->Parts[i];
}

std::size_t SignBySubdivision::cornerIndex(int corner) const
{
  return (cornerSide(corner, 0) ? this->Counts[0] - 1 : 0) +
    this->Counts[0] *
    ((cornerSide(corner, 1) ? this->Counts[1] - 1 : 0) +
      static_cast<std::size_t>(this->Counts[1]) * (cornerSide(corner, 2) ? this->Counts[2] - 1 : 0));
}

void SignBySubdivision::halve(std::size_t i, double growth)
{
  this->part(i + 1); // may move the parts
  Part& part = this->Parts[i];
  Part& other = this->Parts[i + 1];
  int across = 0;
  double most = -1.0;
  for (int d = 0; d < 3; ++d)
  {
    double variation = 0.0;
    this->rows(d, [&](std::size_t first, int stride) {
      for (int n = 1; n < this->Counts[d]; ++n)
      {
        variation += std::abs(part.coefficients[first + n * stride] - part.coefficients[first + (n - 1) * stride]);
      }
    });
    if (variation > most)
    {
      most = variation;
      across = d;
    }
  }
  this->rows(across, [&](std::size_t first, int stride) {
    halveBezier(this->Counts[across] - 1, stride, part.coefficients.data() + first, other.coefficients.data() + first);
  });
  part.size[across] *= 0.5;
  part.error += (this->Counts[across] - 1) * growth;
  ++part.depth;
  other.start = part.start;
  other.size = part.size;
  other.start[across] += part.size[across];
  other.error = part.error;
  other.depth = part.depth;
  const auto smallest = [](const Part& p) { return *std::min_element(p.coefficients.begin(), p.coefficients.end()); };
  if (smallest(part) < smallest(other))
  {
    std::swap(part, other);
  }
}

} // namespace bsv

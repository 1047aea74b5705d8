// SPDX-License-Identifier: BSD-3-Clause
/// @file OrderFreeSum.h
/// Affine combinations of points whose value, to the last bit, does not depend on the order of the terms.
#pragma once

#include "Base/Types.h"

#include <algorithm>
#include <vector>

namespace bsv
{

/// Collects weighted points; result() is their sum over a denominator that equals the sum of the weights.
/// Per coordinate the products are sorted and added with error compensation (Neumaier 1974), so that every numbering
/// and orientation of the blocks gives the same bits. A coordinate that all points share comes back unchanged.
class OrderFreeSum
{
public:
  OrderFreeSum()
  {
    // As many terms as a fan of four sectors has, at once.
    this->Terms.reserve(9);
    this->Products.reserve(9);
  }

  void clear() { this->Terms.clear(); }

  void add(double weight, const Vec3& point)
  {
    if (weight != 0.0)
    {
      this->Terms.push_back({ weight, point });
    }
  }

  Vec3 result(double denominator)
  {
    Vec3 sum;
    for (int d = 0; d < 3; ++d)
    {
      this->Products.clear();
      bool allEqual = true;
      for (const Term& term : this->Terms)
      {
        allEqual = allEqual && term.point[d] == this->Terms.front().point[d];
        this->Products.push_back(term.weight * term.point[d]);
      }
      // Adding 0.0 gives zero its positive sign: copies of it may differ in sign.
      sum[d] = (allEqual ? this->Terms.front().point[d] : this->sortedSum() / denominator) + 0.0;
    }
    return sum;
  }

private:
  struct Term
  {
    double weight;
    Vec3 point;
  };

  double sortedSum()
  {
    std::sort(this->Products.begin(), this->Products.end());
    double sum = 0.0;
    double lost = 0.0;
    for (const double x : this->Products)
    {
      const double next = sum + x;
      lost += std::abs(sum) >= std::abs(x) ? (sum - next) + x : (x - next) + sum;
      sum = next;
    }
    return sum + lost;
  }

  std::vector<Term> Terms;
  std::vector<double> Products;
};

} // namespace bsv

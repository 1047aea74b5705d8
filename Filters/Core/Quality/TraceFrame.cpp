// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/TraceFrame.h"

namespace bsv
{

Trace FramedTrace::copy() const
{
  Trace result;
  result.rational = this->trace->rational;
  result.length = this->trace->length;
  result.size = this->trace->size;
  for (int k = 0; k < 2; ++k)
  {
    result.degree[k] = this->degree(k);
    result.count[k] = this->count(k);
    result.knots[k].clear();
    for (int i = 0; i < this->count(k) + this->degree(k) + 1; ++i)
    {
      result.knots[k].push_back(this->knot(k, i));
    }
  }
  result.net.reserve(this->trace->net.size());
  for (int j = 0; j < this->count(1); ++j)
  {
    for (int i = 0; i < this->count(0); ++i)
    {
      result.net.push_back(this->at(i, j));
    }
  }
  return result;
}

int compare(const FramedTrace& a, const FramedTrace& b)
{
  const auto sign = [](double x, double y) { return x < y ? -1 : x > y ? 1 : 0; };
  for (int k = 0; k < 2; ++k)
  {
    if (const int c = sign(a.count(k), b.count(k)))
    {
      return c;
    }
    if (const int c = sign(a.degree(k), b.degree(k)))
    {
      return c;
    }
  }
  for (int j = 0; j < a.count(1); ++j)
  {
    for (int i = 0; i < a.count(0); ++i)
    {
      const Layers& x = a.at(i, j);
      const Layers& y = b.at(i, j);
      for (int n = 0; n < 12; ++n)
      {
        if (const int c = sign(x[n], y[n]))
        {
          return c;
        }
      }
    }
  }
  for (int k = 0; k < 2; ++k)
  {
    for (int i = 0; i < a.count(k) + a.degree(k); ++i)
    {
      if (const int c = sign(a.knot(k, i + 1) - a.knot(k, i), b.knot(k, i + 1) - b.knot(k, i)))
      {
        return c;
      }
    }
  }
  return 0;
}

} // namespace bsv

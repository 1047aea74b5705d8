// SPDX-License-Identifier: BSD-3-Clause
/// @file TraceFrame.h
/// In which order and sense a join is evaluated, so that its bits do not depend on how blocks are stored.
#pragma once

#include "Mesh/BlockTopology.h"
#include "Quality/SurfaceTrace.h"

#include <array>

namespace bsv
{

/// Axis k of the frame runs along the trace's axis axis[k], backwards if flip[k].
struct TraceFrame
{
  std::array<int, 2> axis{ 0, 1 };
  std::array<bool, 2> flip{ false, false };

  /// The same frame seen from the other side of a contact.
  TraceFrame across(int orientation) const
  {
    TraceFrame other;
    for (int k = 0; k < 2; ++k)
    {
      other.axis[k] = swapsAxes(orientation) ? 1 - this->axis[k] : this->axis[k];
      other.flip[k] = this->flip[k] != ((orientation & (other.axis[k] == 0 ? 2 : 4)) != 0);
    }
    return other;
  }
};

/// View of a trace in a frame. Reversed knots change their sign, which keeps the bits of all differences.
struct FramedTrace
{
  const Trace* trace;
  TraceFrame frame;

  int count(int k) const { return this->trace->count[this->frame.axis[k]]; }
  int degree(int k) const { return this->trace->degree[this->frame.axis[k]]; }
  double knot(int k, int i) const
  {
    const std::vector<double>& knots = this->trace->knots[this->frame.axis[k]];
    return this->frame.flip[k] ? -knots[knots.size() - 1 - i] : knots[i];
  }
  const Layers& at(int i, int j) const
  {
    const std::array<int, 2> in{ this->frame.flip[0] ? this->count(0) - 1 - i : i,
      this->frame.flip[1] ? this->count(1) - 1 - j : j };
    return this->trace->at(in[this->frame.axis[0] == 0 ? 0 : 1], in[this->frame.axis[0] == 0 ? 1 : 0]);
  }

  Trace copy() const;
};

/// Lexicographic order of two framed traces: -1, 0, 1.
int compare(const FramedTrace& a, const FramedTrace& b);

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
#include "Volume/ControlPointRule.h"

namespace bsv
{

const std::vector<std::string>& controlPointRuleNames()
{
  static const std::vector<std::string> names{ "Copied", "Regular", "Boundary", "Symmetry", "PlanarSide", "Body",
    "BodyExtraordinaryVertex", "Crease", "Corner", "ExtraordinaryEdge", "SingularNode", "WallLayer", "FarFieldLayer" };
  return names;
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/JoinClass.h"

#include "Quality/JoinMeasurement.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>

namespace bsv
{

namespace
{

/// Degrees. Rules with single knots leave 0.3 to 4.8 at extraordinary edges of valence 3 to 8 of smooth bodies
/// (docs/exact_g1.md); twice that counts as theirs.
constexpr double SingleKnotKink = 10.0;

} // namespace

const char* joinClassName(JoinClass of)
{
  static const char* const names[JoinClasses] = { "defect", "expected", "deliberate", "smooth" };
  return names[static_cast<int>(of)];
}

ClassifiedJoin classifyJoin(const Join& join)
{
  if (join.crease)
  {
    return { JoinClass::Expected, "crease" };
  }
  if (join.continuity == JoinContinuity::Open)
  {
    return { JoinClass::Defect, "gap" };
  }
  if (join.continuity >= JoinContinuity::C1)
  {
    return { JoinClass::Smooth, continuityName(join.continuity) };
  }
  const auto& valences = join.valences;
  const auto isExtraordinary = [](int valence) { return valence > 0 && valence != 4; };
  const bool alongT = isExtraordinary(valences[0]) || isExtraordinary(valences[1]);
  const bool alongS = isExtraordinary(valences[2]) || isExtraordinary(valences[3]);
  if (join.continuity == JoinContinuity::G1)
  {
    return { JoinClass::Deliberate, !join.border() && (alongS || alongT) ? "extraordinary edge" : "change of spacing" };
  }
  if (join.atCrease)
  {
    return { JoinClass::Expected, "at a crease" };
  }
  if (!join.border() && std::any_of(valences.begin(), valences.end(), [](int valence) { return valence <= -3; }))
  {
    return { JoinClass::Expected, "at a reentrant edge" };
  }
  if (!join.border() && alongS && alongT)
  {
    return { JoinClass::Expected, "at a singular node" };
  }
  if ((alongS || alongT) && join.worst[int(join.rankedBy())].value <= SingleKnotKink)
  {
    return { JoinClass::Deliberate, "at an extraordinary edge" };
  }
  // What a corner of the body leaves around it fades within two spans.
  if (join.atKinkedVertex && join.layerJumpAway <= SingleKnotKink)
  {
    return { JoinClass::Expected, "at the end of a crease or reentrant edge" };
  }
  return { JoinClass::Defect, "kink" };
}

std::string blocksText(const Join& join, const std::vector<std::string>& names)
{
  const std::string& name = names[join.sides[0].block];
  if (!join.inner())
  {
    return name + " / " + names[join.sides[1].block];
  }
  const int direction = faceDirection(acrossFace(join, 0));
  std::ostringstream text;
  text << name << " at "
       << "uvw"[direction] << " = " << join.worst[static_cast<int>(join.rankedBy())].uvw[0][direction];
  return text.str();
}

std::vector<int> rankedByClass(const SmoothnessResult& result)
{
  // Of defect, expected, deliberate, smooth.
  static constexpr int Places[JoinClasses] = { 0, 2, 1, 3 };
  const auto place = [&](int join) { return Places[static_cast<int>(classifyJoin(result.joins[join]).of)]; };
  std::vector<int> order = result.ranking;
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return place(a) < place(b); });
  return order;
}

} // namespace bsv

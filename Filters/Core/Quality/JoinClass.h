// SPDX-License-Identifier: BSD-3-Clause
/// @file JoinClass.h
/// Which joins of a volume are as smooth as they should be, which are rough for a reason, and which are defects.
///
/// - Smooth: C1 or C2.
/// - Deliberate: G1, as the rules make it at extraordinary edges and where the spacing of layers changes; and a kink of
///   at most 10 degrees at an extraordinary edge, as the rules with single knots leave it (Continuity ExactG1 does
///   not).
/// - Expected: C0, but something at the join is bound to kink: it is a crease or ends at one, at a reentrant edge of
///   the outer boundary (three or more blocks meet there), or at a singular node (extraordinary edges of both
///   directions end at a corner of the interface); or it kinks by more than 10 degrees only within two spans from a
///   corner where a crease or reentrant edge ends.
/// - Defect: the sides have a gap, or layers kink without such a reason.
#pragma once

#include "Quality/Smoothness.h"

#include <string>
#include <vector>

namespace bsv
{

/// The codes that outputs hold.
enum class JoinClass
{
  Defect,
  Expected,
  Deliberate,
  Smooth
};
constexpr int JoinClasses = 4;

/// "defect", "expected", "deliberate", "smooth".
const char* joinClassName(JoinClass of);

struct ClassifiedJoin
{
  JoinClass of = JoinClass::Smooth;
  /// Why, in a few words: "crease", "at a reentrant edge", "kink", ..
  std::string reason;
};

ClassifiedJoin classifyJoin(const Join& join);

/// What it joins: "wing / tip", or inside a block "wing at u = 12". @param names of the blocks
std::string blocksText(const Join& join, const std::vector<std::string>& names);

/// Joins in the order of a list, what asks for a look first: defects, deliberate ones, expected ones, smooth ones;
/// within a class as in `result.ranking`, creases last within theirs.
std::vector<int> rankedByClass(const SmoothnessResult& result);

} // namespace bsv

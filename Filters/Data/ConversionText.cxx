// SPDX-License-Identifier: BSD-3-Clause
// What the report says of a conversion.
#include "Data/ConversionResult.h"

#include "Volume/ControlPointRule.h"

#include <algorithm>
#include <sstream>

namespace bsv
{

namespace
{

std::string pointText(const Vec3& x)
{
  std::ostringstream text;
  text << '(' << x[0] << ", " << x[1] << ", " << x[2] << ')';
  return text.str();
}

/// The boundaries with their roles, and what holds at walls and planar sides.
std::string boundaryText(const BlockComplex& complex, const ConversionOptions& options, const ConversionReport& counts)
{
  std::ostringstream text;
  std::vector<int> faces(complex.boundaryNames.size(), 0);
  int unnamed = 0;
  for (const ComplexFace& face : complex.faces)
  {
    if (face.boundary())
    {
      ++(face.tag < 0 ? unnamed : faces[face.tag]);
    }
  }
  bool body = false;
  for (std::size_t tag = 0; tag < faces.size(); ++tag)
  {
    static const char* const roles[] = { "far field or other boundary", "body", "symmetry plane" };
    const BoundaryRole role = options.roles[tag];
    body = body || (role == BoundaryRole::Body && faces[tag] > 0);
    text << complex.boundaryNames[tag] << ": " << roles[static_cast<int>(role)] << ", " << faces[tag] << " faces\n";
  }
  if (unnamed > 0)
  {
    text << unnamed << " boundary faces without a name\n";
  }
  if (!body)
  {
    text << "no body\n";
  }

  if (body && counts.wallSpacing[0] != counts.wallSpacing[1])
  {
    text << "wall spacing c from " << counts.wallSpacing[0] << " to " << counts.wallSpacing[1] << '\n';
  }
  if (!counts.extensionDistances.empty())
  {
    text << "planar sides with a far-field extension: " << counts.extensionDistances.size()
         << ", its first layer at the distance";
    for (const double distance : counts.extensionDistances)
    {
      text << ' ' << distance;
    }
    if (counts.limitedDistances > 0)
    {
      text << "; cut to 2/3 of a thinner first cell at " << counts.limitedDistances << " points";
    }
    text << '\n';
  }
  return text.str();
}

} // namespace

std::string triple(const char* separator, int a, int b, int c)
{
  return std::to_string(a) + separator + std::to_string(b) + separator + std::to_string(c);
}

std::string motionText(const WallMotion& motion, bool onBody)
{
  std::ostringstream text;
  if (motion.wallPoints > 0)
  {
    text << "converted wall off its " << motion.wallPoints << " mesh points by at most " << motion.largest << ", at "
         << pointText(motion.where) << ", median " << motion.median << "; in first cells at most "
         << motion.largestInCells << ", median " << motion.medianInCells;
    text << (!onBody && motion.largestInCells > 1.0 ? "; if these are points of the wall, take Input Points OnBody\n"
                                                    : "\n");
  }
  return text.str();
}

std::string shareText(const std::vector<double>& shares)
{
  std::ostringstream text;
  const auto held = std::count_if(shares.begin(), shares.end(), [](double share) { return share < 1.0; });
  if (held > 0)
  {
    text << "wall fitted in part only for valid spans at " << held << " of " << shares.size()
         << " points, the least share of a displacement " << *std::min_element(shares.begin(), shares.end()) << '\n';
  }
  return text.str();
}

std::string reportText(const BlockComplex& complex, const EntityClasses& classes, const ConversionOptions& options,
  const WallPoints& wallPoints, const ConversionReport& counts,
  const std::vector<std::array<std::vector<double>, 3>>& knots)
{
  std::ostringstream text;
  Index total = 0;
  for (const Index count : counts.controlPoints)
  {
    total += count;
  }
  text << complex.blocks.size() << " blocks, " << total << " control points, " << classes.extraordinaryEdges
       << " extraordinary edges, " << counts.singularNodes << " singular nodes, " << counts.planarFaces
       << " planar sides\n";
  for (const std::vector<std::string>* notes : { &complex.notes, &counts.notes })
  {
    for (const std::string& note : *notes)
    {
      text << note << '\n';
    }
  }
  text << complex.creaseNote << (complex.creaseNote.empty() ? "" : "\n");
  text << wallPoints.report;
  for (const auto& [valence, count] : classes.extraordinaryCurves)
  {
    text << count << " extraordinary curves of valence " << valence << '\n';
  }

  text << boundaryText(complex, options, counts);
  for (std::size_t rule = 0; rule < counts.controlPoints.size(); ++rule)
  {
    if (counts.controlPoints[rule] > 0)
    {
      text << controlPointRuleNames()[rule] << ": " << counts.controlPoints[rule] << " control points\n";
    }
  }
  if (options.continuity == Continuity::ExactG1)
  {
    const G1Report& g1 = counts.g1;
    text << (g1.givenUpLayers > 0
                ? std::to_string(g1.givenUpLayers) + " layers keep their kinks: spans next to them would not be valid\n"
                : std::string())
         << "exact G1 at " << g1.edges << " extraordinary edges in " << g1.layers << " layers of control points, "
         << g1.skippedLayers << " layers near singular nodes and creases stay as they are; "
         << g1.fittedVertices + g1.linearVertices << " extraordinary vertices of the wall, " << g1.fittedVertices
         << " of them fitted to the body\n";
  }
  for (std::size_t b = 0; b < complex.blocks.size(); ++b)
  {
    const ComplexBlock& block = complex.blocks[b];
    const auto points = [&](int d) { return static_cast<int>(knots[b][d].size()) - 4; };
    text << block.name << ": " << triple(" x ", block.cells(0), block.cells(1), block.cells(2)) << " cells, "
         << triple(" x ", points(0), points(1), points(2)) << " control points, from block " << block.parent
         << " at point " << triple(", ", block.offset[0], block.offset[1], block.offset[2]) << '\n';
  }
  return text.str();
}

std::string spanText(const BlockComplex& complex, const ConversionOptions& options, const SpanReport& spans)
{
  const bool all = options.checkSpans == CheckSpans::All || options.untangle;
  if (options.checkSpans == CheckSpans::None && !all)
  {
    return "no spans were checked\n";
  }
  std::ostringstream text;
  text << spans.checked << (all ? " spans" : " spans near special rules") << " checked, " << spans.failed
       << " not proven valid, " << spans.repaired << " of them repaired, " << spans.invalid << " spans left invalid, "
       << spans.undecided << " undecided\n";
  if (spans.movedPoints > 0)
  {
    text << "span repair: " << spans.movedPoints << " mesh points moved by up to " << spans.largestMove << " ("
         << spans.largestMoveInCells << " cells), " << spans.sweeps << " sweeps\n";
  }
  if (spans.invalidCells > 0)
  {
    text << spans.invalidCells << " more spans are not proven valid, nor are their mesh cells valid: "
         << spans.invalidCells - spans.undecidedCells << " invalid, " << spans.undecidedCells << " undecided\n";
  }
  constexpr std::size_t Listed = 20;
  for (std::size_t i = 0; i < std::min(Listed, spans.left.size()); ++i)
  {
    const SpanReport::Place& place = spans.left[i];
    text << "span not valid: " << complex.blocks[place.block].name << ", cell "
         << triple(", ", place.cell[0], place.cell[1], place.cell[2]) << '\n';
  }
  if (spans.left.size() > Listed)
  {
    text << "and " << spans.left.size() - Listed << " more\n";
  }
  return text.str();
}

std::string rankText(const BlockComplex& complex, const std::vector<Index>& received)
{
  std::ostringstream text;
  for (std::size_t r = 0; received.size() > 1 && r < received.size(); ++r)
  {
    Index blocks = 0, points = 0;
    for (const ComplexBlock& block : complex.blocks)
    {
      if (block.rank == static_cast<int>(r))
      {
        ++blocks;
        points += block.points.size();
      }
    }
    text << "rank " << r << ": " << blocks << " blocks, " << points << " mesh points, received " << received[r]
         << " bytes from other ranks\n";
  }
  return text.str();
}

} // namespace bsv

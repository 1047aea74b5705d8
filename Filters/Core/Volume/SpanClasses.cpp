// SPDX-License-Identifier: BSD-3-Clause
#include "Volume/SpanClasses.h"

#include "Base/UnionFind.h"
#include "Ranks/OwnedValues.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace bsv
{

namespace
{

/// Numbers of the spans (block, direction, span).
class SpanNumbers
{
public:
  explicit SpanNumbers(const std::vector<BSplineVolume>& volumes)
  {
    for (const BSplineVolume& volume : volumes)
    {
      for (int d = 0; d < 3; ++d)
      {
        this->Start.push_back(this->Count);
        this->Count += static_cast<Index>(nonEmptySpans(volume.degree[d], volume.knots[d]).size());
      }
    }
    this->Start.push_back(this->Count);
  }

  Index count() const { return this->Count; }
  Index first(int block, int direction) const { return this->Start[3 * std::size_t(block) + direction]; }
  int spans(int block, int direction) const
  {
    return static_cast<int>(this->Start[3 * std::size_t(block) + direction + 1] - this->first(block, direction));
  }

private:
  std::vector<Index> Start;
  Index Count = 0;
};

/// All spans that an interface joins, in both directions along the faces.
void unite(UnionFind& classes, const SpanNumbers& numbers, const Interface& contact,
  const std::function<std::string(int)>& blockName)
{
  for (int axis = 0; axis < 2; ++axis)
  {
    const int axisB = swapsAxes(contact.orientation) ? 1 - axis : axis;
    const bool turned = (contact.orientation & (axisB == 0 ? 2 : 4)) != 0;
    const int a = faceAxis(contact.faceA, axis);
    const int b = faceAxis(contact.faceB, axisB);
    const int spans = numbers.spans(contact.blockA, a);
    const int spansB = numbers.spans(contact.blockB, b);
    if (spans != spansB)
    {
      throw Error(blockName(contact.blockA) + ", face " + std::to_string(contact.faceA) + " has " +
        std::to_string(spans) + " spans along " + "uvw"[a] + ", but " + blockName(contact.blockB) + ", face " +
        std::to_string(contact.faceB) + " that it meets has " + std::to_string(spansB) +
        ": samples of unequal levels would not match");
    }
    for (int n = 0; n < spans; ++n)
    {
      classes.unite(
        numbers.first(contact.blockA, a) + n, numbers.first(contact.blockB, b) + (turned ? spans - 1 - n : n));
    }
  }
}

/// Non-empty span number n, counted from the side of a face.
int spanFrom(int side, int n, int spans)
{
  return side ? spans - 1 - n : n;
}

/// Begin and end of a span in a direction.
std::array<double, 2> spanEnds(const BSplineVolume& volume, int direction, int span)
{
  const std::vector<double>& knots = volume.knots[direction];
  const int s = nonEmptySpans(volume.degree[direction], knots)[span];
  return { knots[s], knots[s + 1] };
}

/// Largest height of the first cell of 2^-level of the first span off a face, at the given parameters on the face.
std::array<double, 2> heights(const BSplineVolume& volume, int face, int level,
  const std::array<std::vector<double>, 2>& parameters, const Execution& run)
{
  const int d = faceDirection(face);
  const int spans = static_cast<int>(nonEmptySpans(volume.degree[d], volume.knots[d]).size());
  const std::array<double, 2> ends = spanEnds(volume, d, spanFrom(faceSide(face), 0, spans));
  const double wall = ends[faceSide(face)];
  const double part = (ends[1] - ends[0]) / (1 << level);
  const double first = faceSide(face) ? wall - part : wall + part;
  std::vector<double> found(parameters[0].size() * parameters[1].size());
  run.parallelFor(static_cast<Index>(found.size()), 64, [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      Vec3 uvw;
      uvw[faceAxis(face, 0)] = parameters[0][n % parameters[0].size()];
      uvw[faceAxis(face, 1)] = parameters[1][n / parameters[0].size()];
      uvw[d] = wall;
      const Vec3 x = evaluate(volume, uvw);
      uvw[d] = first;
      found[n] = (evaluate(volume, uvw) - x).norm();
    }
  });
  return { *std::min_element(found.begin(), found.end()), *std::max_element(found.begin(), found.end()) };
}

/// Largest distance of the middle of a chord from the wall, over all chords along `axis` in one span of a face.
double chordDistance(const BSplineVolume& volume, int face, int axis, int span, int level)
{
  const int along = faceAxis(face, axis);
  const int across = faceAxis(face, 1 - axis);
  const std::array<double, 2> ends = spanEnds(volume, along, span);
  const int parts = 1 << level;
  const std::vector<double>& normal = volume.knots[faceDirection(face)];
  Vec3 uvw;
  uvw[faceDirection(face)] = faceSide(face) ? normal.back() : normal.front();
  double largest = 0.0;
  for (const double line : sampleParameters(volume, across, 0))
  {
    uvw[across] = line;
    const auto at = [&](double part) {
      uvw[along] = ends[0] + (ends[1] - ends[0]) * (part / parts);
      return evaluate(volume, uvw);
    };
    Vec3 begin = at(0);
    for (int j = 0; j < parts; ++j)
    {
      const Vec3 end = at(j + 1);
      const Vec3 middle = at(j + 0.5);
      // From the chord, not from its middle: samples need not be equally spaced.
      const Vec3 chord = end - begin;
      const double length = chord.squaredNorm();
      const double t = length > 0.0 ? std::clamp((middle - begin).dot(chord) / length, 0.0, 1.0) : 0.0;
      largest = std::max(largest, (middle - begin - t * chord).norm());
      begin = end;
    }
  }
  return largest;
}

std::string shortNumber(double value)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", value);
  return text;
}

void checkLevel(int level, const std::string& what)
{
  if (level > MaxSamplingLevel || level < 0)
  {
    throw Error(what + " " + std::to_string(level) + " is not in 0.." + std::to_string(MaxSamplingLevel));
  }
}

/// What a target of one face, or of one sheet at a face, needs.
struct Need
{
  int level = 0;
  /// Value at that level.
  double reached = 0.0;
};

} // namespace

ChosenLevels chooseLevels(const std::vector<BSplineVolume>& volumes, const std::vector<Interface>& interfaces,
  const LevelRequest& request, const std::function<std::string(int block)>& blockName, const Execution& run)
{
  checkLevel(request.level, "Level");
  const SpanNumbers numbers(volumes);
  UnionFind classes(numbers.count());
  for (const Interface& contact : interfaces)
  {
    unite(classes, numbers, contact, blockName);
  }
  std::vector<int> levels(static_cast<std::size_t>(numbers.count()), request.level);
  const auto ask = [&](int block, int direction, int span, int level) {
    int& current = levels[classes.find(numbers.first(block, direction) + span)];
    current = std::max(current, level);
  };
  ChosenLevels result;

  const std::size_t walls = request.walls.size();
  const auto wallOwner = [&](std::size_t n) { return volumes[request.walls[n][0]].rank; };
  std::vector<Need> off(walls, { std::max(request.wallLevel, 0), 0.0 });
  if (request.firstCellHeight > 0.0)
  {
    off = gatherFromOwners<Need>(*run.ranks, walls, wallOwner, [&](std::size_t n) {
      const auto [block, face] = request.walls[n];
      const BSplineVolume& volume = volumes[block];
      const std::array<std::vector<double>, 2> parameters{ sampleParameters(volume, faceAxis(face, 0), 0),
        sampleParameters(volume, faceAxis(face, 1), 0) };
      Need need{ request.level, 0.0 };
      for (need.reached = heights(volume, face, need.level, parameters, run)[1];
           need.reached > request.firstCellHeight && need.level < MaxSamplingLevel;)
      {
        ++need.level;
        need.reached = heights(volume, face, need.level, parameters, run)[1];
      }
      return need;
    });
    int lowest = MaxSamplingLevel;
    int highest = 0;
    int missed = 0;
    double worst = 0.0;
    for (const Need& need : off)
    {
      lowest = std::min(lowest, need.level);
      highest = std::max(highest, need.level);
      missed += need.reached > request.firstCellHeight;
      worst = std::max(worst, need.reached);
    }
    if (walls > 0)
    {
      result.notes.push_back("First cells of at most " + shortNumber(request.firstCellHeight) + ": levels " +
        std::to_string(lowest) + " to " + std::to_string(highest) + " off the wall");
    }
    if (missed > 0)
    {
      result.notes.push_back(std::to_string(missed) + " of " + std::to_string(walls) +
        " wall faces have higher first cells even at level " + std::to_string(MaxSamplingLevel) + ", up to " +
        shortNumber(worst) + "; a smaller wall spacing of the conversion would reach it");
    }
  }
  else if (request.wallLevel >= 0)
  {
    checkLevel(request.wallLevel, "Wall Level");
  }
  if (request.tangentialLevel >= 0)
  {
    checkLevel(request.tangentialLevel, "Tangential Level");
  }

  std::vector<std::vector<Need>> chords(walls);
  if (request.chordError > 0.0)
  {
    chords = gatherListsFromOwners<Need>(*run.ranks, walls, wallOwner, [&](std::size_t n) {
      const int block = request.walls[n][0];
      const int face = request.walls[n][1];
      const int first = numbers.spans(block, faceAxis(face, 0));
      std::vector<Need> needs(static_cast<std::size_t>(first + numbers.spans(block, faceAxis(face, 1))));
      run.parallelFor(static_cast<Index>(needs.size()), 1, [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i)
        {
          const int axis = i < first ? 0 : 1;
          const int span = static_cast<int>(axis == 0 ? i : i - first);
          Need& need = needs[i];
          need.level = request.level;
          need.reached = chordDistance(volumes[block], face, axis, span, need.level);
          while (need.reached > request.chordError && need.level < MaxSamplingLevel)
          {
            ++need.level;
            need.reached = chordDistance(volumes[block], face, axis, span, need.level);
          }
        }
      });
      return needs;
    });
    int highest = 0;
    int missed = 0;
    for (const std::vector<Need>& needs : chords)
    {
      for (const Need& need : needs)
      {
        highest = std::max(highest, need.level);
        missed += need.reached > request.chordError;
      }
    }
    if (walls > 0)
    {
      result.notes.push_back("Chord errors of at most " + shortNumber(request.chordError) + ": levels up to " +
        std::to_string(highest) + " along the wall");
    }
    if (missed > 0)
    {
      result.notes.push_back(std::to_string(missed) + " sheets at the wall have larger chord errors even at level " +
        std::to_string(MaxSamplingLevel));
    }
  }

  for (std::size_t n = 0; n < walls; ++n)
  {
    const auto [block, face] = request.walls[n];
    const int d = faceDirection(face);
    const int spans = numbers.spans(block, d);
    for (int layer = 0; layer < std::min(request.wallLayers, spans); ++layer)
    {
      ask(block, d, spanFrom(faceSide(face), layer, spans), off[n].level);
    }
    int at = 0;
    for (int axis = 0; axis < 2; ++axis)
    {
      const int along = faceAxis(face, axis);
      for (int span = 0; span < numbers.spans(block, along); ++span, ++at)
      {
        ask(block, along, span, chords[n].empty() ? std::max(request.tangentialLevel, 0) : chords[n][at].level);
      }
    }
  }
  for (const LevelRequest::BlockLevel& entry : request.blockLevels)
  {
    if (entry.block < 0 || entry.block >= static_cast<int>(volumes.size()) || entry.direction < 0 ||
      entry.direction > 2)
    {
      throw Error("Block Levels: there is no block " + std::to_string(entry.block) + " with a direction " +
        std::to_string(entry.direction) + "; blocks are 0.." + std::to_string(volumes.size() - 1) +
        ", directions 0..2");
    }
    checkLevel(entry.level, "Block Levels: level");
    for (int span = 0; span < numbers.spans(entry.block, entry.direction); ++span)
    {
      ask(entry.block, entry.direction, span, entry.level);
    }
  }

  result.classesOfLevel.assign(MaxSamplingLevel + 1, 0);
  for (Index n = 0; n < numbers.count(); ++n)
  {
    if (classes.find(n) == n)
    {
      ++result.classes;
      ++result.classesOfLevel[levels[n]];
    }
  }
  for (std::size_t b = 0; b < volumes.size(); ++b)
  {
    result.levels.emplace_back();
    for (int d = 0; d < 3; ++d)
    {
      for (int span = 0; span < numbers.spans(static_cast<int>(b), d); ++span)
      {
        result.levels.back()[d].push_back(levels[classes.find(numbers.first(static_cast<int>(b), d) + span)]);
      }
    }
  }
  return result;
}

std::array<double, 2> firstCellHeights(const std::vector<BSplineVolume>& volumes, const std::vector<SpanLevels>& levels,
  const std::vector<std::array<int, 2>>& walls, const Execution& run)
{
  using Range = std::array<double, 2>;
  const std::vector<Range> all = gatherFromOwners<Range>(
    *run.ranks, walls.size(), [&](std::size_t n) { return volumes[walls[n][0]].rank; },
    [&](std::size_t n) {
      const auto [block, face] = walls[n];
      const int d = faceDirection(face);
      const std::vector<int>& off = levels[block][d];
      return heights(volumes[block], face, off[spanFrom(faceSide(face), 0, static_cast<int>(off.size()))],
        { sampleParameters(volumes[block], faceAxis(face, 0), levels[block][faceAxis(face, 0)]),
          sampleParameters(volumes[block], faceAxis(face, 1), levels[block][faceAxis(face, 1)]) },
        run);
    });
  if (all.empty())
  {
    return { 0.0, 0.0 };
  }
  Range result = all.front();
  for (const Range& range : all)
  {
    result = { std::min(result[0], range[0]), std::max(result[1], range[1]) };
  }
  return result;
}

} // namespace bsv

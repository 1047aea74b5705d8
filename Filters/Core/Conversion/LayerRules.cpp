// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/LayerRules.h"

#include "Base/CanonicalOrder.h"
#include "Base/Numbers.h"
#include "Base/OrderFreeSum.h"
#include "Base/OrderFreeSums.h"
#include "Complex/Limits.h"
#include "Conversion/LimitMasks.h"

#include <Eigen/Geometry>
#include <Eigen/QR>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <string>

namespace bsv
{
namespace
{

/// Weights of one control point, over a common denominator.
struct FanStencil
{
  FanMask weights;
  double denominator = 1.0;
};

/// Stencils of a whole fan. Closed fans hold those of spoke 0 and sector 0; the others are rotated.
struct FanStencils
{
  FanStencil center;
  std::vector<FanStencil> spokes;
  std::vector<FanStencil> sectors;
};

/// Shape of the affine regular fan: where spokes and sectors lie in the tangent plane.
struct RegularFan
{
  std::vector<Eigen::Vector2d> spokes;
  std::vector<Eigen::Vector2d> sectors;
  double cosine = 0.0; ///< of the angle between neighbouring spokes
};

RegularFan regularFan(bool closed, int sectors)
{
  const double angle = (closed ? 2.0 : 1.0) * Pi / sectors;
  RegularFan fan;
  fan.cosine = std::cos(angle);
  const int spokes = closed ? sectors : sectors + 1;
  for (int i = 0; i < spokes; ++i)
  {
    fan.spokes.emplace_back(std::cos(i * angle), std::sin(i * angle));
  }
  for (int i = 0; i < sectors; ++i)
  {
    fan.sectors.push_back(fan.spokes[i] + fan.spokes[(i + 1) % spokes]);
  }
  return fan;
}

FanMask zeroMask(const RegularFan& fan)
{
  FanMask mask;
  mask.spokes.assign(fan.spokes.size(), 0.0);
  mask.sectors.assign(fan.sectors.size(), 0.0);
  return mask;
}

void addScaled(FanMask& sum, double scale, const FanMask& mask)
{
  sum.center += scale * mask.center;
  for (std::size_t i = 0; i < sum.spokes.size(); ++i)
  {
    sum.spokes[i] += scale * mask.spokes[i];
  }
  for (std::size_t i = 0; i < sum.sectors.size(); ++i)
  {
    sum.sectors[i] += scale * mask.sectors[i];
  }
}

/// Spoke i and sector i of a closed fan take the weights of spoke i - first and sector i - first.
FanMask rotated(const FanMask& mask, int first)
{
  const int n = static_cast<int>(mask.spokes.size());
  FanMask result = mask;
  for (int i = 0; i < n; ++i)
  {
    result.spokes[(i + first) % n] = mask.spokes[i];
    result.sectors[(i + first) % n] = mask.sectors[i];
  }
  return result;
}

/// The value that a differential mask has on the affine regular fan.
Eigen::Vector2d applyTo(const FanMask& mask, const RegularFan& fan)
{
  Eigen::Vector2d value = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < fan.spokes.size(); ++i)
  {
    value += mask.spokes[i] * fan.spokes[i];
  }
  for (std::size_t i = 0; i < fan.sectors.size(); ++i)
  {
    value += mask.sectors[i] * fan.sectors[i];
  }
  return value;
}

Vec3 combination(const FanMask& mask, const Fan& fan)
{
  Vec3 value = mask.center * fan.center;
  for (int i = 0; i < fan.spokeCount(); ++i)
  {
    value += mask.spokes[i] * fan.spokes[i];
  }
  for (int i = 0; i < fan.sectorCount(); ++i)
  {
    value += mask.sectors[i] * fan.sectors[i];
  }
  return value;
}

/// Masks of the second derivatives xx, xy, yy (as vectors) of the quadratic without constant term, about the centre,
/// that fits spokes and sectors best over the affine regular fan.
std::array<FanMask, 3> quadraticFit(const RegularFan& fan)
{
  const int spokes = static_cast<int>(fan.spokes.size());
  const int rows = spokes + static_cast<int>(fan.sectors.size());
  Eigen::MatrixXd matrix(rows, 5);
  for (int i = 0; i < rows; ++i)
  {
    const Eigen::Vector2d& x = i < spokes ? fan.spokes[i] : fan.sectors[i - spokes];
    matrix.row(i) << x[0], x[1], 0.5 * x[0] * x[0], x[0] * x[1], 0.5 * x[1] * x[1];
  }
  const Eigen::MatrixXd inverse = matrix.colPivHouseholderQr().solve(Eigen::MatrixXd::Identity(rows, rows));
  std::array<FanMask, 3> masks{ zeroMask(fan), zeroMask(fan), zeroMask(fan) };
  for (int m = 0; m < 3; ++m)
  {
    for (int i = 0; i < rows; ++i)
    {
      const double weight = inverse(2 + m, i);
      (i < spokes ? masks[m].spokes[i] : masks[m].sectors[i - spokes]) = weight;
      masks[m].center -= weight;
    }
  }
  return masks;
}

/// Makes a mask that reflection maps to itself do so bit for bit.
/// `mirrorSpoke(i)` and `mirrorSector(i)` are the images of spoke and sector i.
template <typename MirrorSpoke, typename MirrorSector>
FanMask mirrored(const FanMask& mask, MirrorSpoke mirrorSpoke, MirrorSector mirrorSector)
{
  FanMask result = mask;
  for (std::size_t i = 0; i < mask.spokes.size(); ++i)
  {
    const std::size_t j = mirrorSpoke(static_cast<int>(i));
    result.spokes[i] = 0.5 * (mask.spokes[i] + mask.spokes[j]);
  }
  for (std::size_t i = 0; i < mask.sectors.size(); ++i)
  {
    const std::size_t j = mirrorSector(static_cast<int>(i));
    result.sectors[i] = 0.5 * (mask.sectors[i] + mask.sectors[j]);
  }
  return result;
}

/// The tensor products of [1 4 1]/6 and [2 1]/3, with integer weights so that products are exact.
FanStencils regularClosedStencils()
{
  FanStencils stencils;
  stencils.center = { { 16.0, { 4, 4, 4, 4 }, { 1, 1, 1, 1 } }, 36.0 };
  stencils.spokes = { { { 8.0, { 4, 2, 0, 2 }, { 1, 0, 0, 1 } }, 18.0 } };
  stencils.sectors = { { { 4.0, { 2, 2, 0, 0 }, { 1, 0, 0, 0 } }, 9.0 } };
  return stencils;
}

FanStencils regularOpenStencils()
{
  FanStencils stencils;
  stencils.center = { { 4.0, { 1, 0, 1 }, { 0, 0 } }, 6.0 };
  stencils.spokes = { { { 2.0, { 1, 0, 0 }, { 0, 0 } }, 3.0 }, { { 8.0, { 2, 4, 2 }, { 1, 1 } }, 18.0 },
    { { 2.0, { 0, 0, 1 }, { 0, 0 } }, 3.0 } };
  stencils.sectors = { { { 4.0, { 2, 2, 0 }, { 1, 0 } }, 9.0 }, { { 4.0, { 0, 2, 2 }, { 0, 1 } }, 9.0 } };
  return stencils;
}

FanStencils extraordinaryStencils(bool closed, int sectors, Twist twist)
{
  const RegularFan shape = regularFan(closed, sectors);
  const LimitMasks limit = closed ? closedFanLimitMasks(sectors) : openFanLimitMasks(sectors);
  const int spokes = static_cast<int>(shape.spokes.size());
  const double mu = (1.0 + shape.cosine / 3.0) / 3.0;
  const double g = 2.0 * shape.cosine;
  const double x = (6.0 + g) / (3.0 * (2.0 + g));

  // Offsets a_i from the centre, as differential masks.
  std::vector<FanMask> offsets;
  if (closed)
  {
    const double scale = mu / applyTo(limit.tangent1, shape)[0];
    FanMask along = zeroMask(shape);
    addScaled(along, scale, limit.tangent1);
    along = mirrored(
      along, [&](int i) { return (sectors - i) % sectors; }, [&](int i) { return sectors - 1 - i; });
    for (int i = 0; i < spokes; ++i)
    {
      offsets.push_back(rotated(along, i));
    }
  }
  else
  {
    const double scaleAlong = 1.0 / applyTo(limit.tangent1, shape)[0];
    const double scaleAcross = 1.0 / applyTo(limit.tangent2, shape)[1];
    for (int i = 0; i < spokes; ++i)
    {
      FanMask offset = zeroMask(shape);
      if (i == 0 || i == spokes - 1)
      {
        // (2 p + e) / 3 - (e_first + 4 p + e_last) / 6
        offset.spokes[i] = 1.0 / 6.0;
        offset.spokes[spokes - 1 - i] = -1.0 / 6.0;
      }
      else
      {
        addScaled(offset, mu * shape.spokes[i][0] * scaleAlong, limit.tangent1);
        addScaled(offset, mu * shape.spokes[i][1] * scaleAcross, limit.tangent2);
      }
      offsets.push_back(offset);
    }
  }

  FanStencils stencils;
  stencils.center.weights = limit.position;
  const int ownSpokes = closed ? 1 : spokes;
  const int ownSectors = closed ? 1 : sectors;
  for (int i = 0; i < ownSpokes; ++i)
  {
    FanStencil stencil{ limit.position, 1.0 };
    addScaled(stencil.weights, 1.0, offsets[i]);
    stencils.spokes.push_back(stencil);
  }
  const std::array<FanMask, 3> second = quadraticFit(shape);
  for (int i = 0; i < ownSectors; ++i)
  {
    const int next = (i + 1) % spokes;
    FanStencil stencil{ limit.position, 1.0 };
    if (twist == Twist::Mask)
    {
      stencil = { zeroMask(shape), 9.0 };
      stencil.weights.center = 4.0;
      stencil.weights.spokes[i] = stencil.weights.spokes[next] = 2.0;
      stencil.weights.sectors[i] = 1.0;
    }
    else
    {
      const double blend = twist == Twist::SecondFundamentalForm ? x : 1.0;
      addScaled(stencil.weights, blend, offsets[i]);
      addScaled(stencil.weights, blend, offsets[next]);
      if (twist == Twist::SecondFundamentalForm)
      {
        const Eigen::Vector2d a = mu * shape.spokes[i];
        const Eigen::Vector2d b = mu * shape.spokes[next];
        addScaled(stencil.weights, a[0] * b[0], second[0]);
        addScaled(stencil.weights, a[0] * b[1] + a[1] * b[0], second[1]);
        addScaled(stencil.weights, a[1] * b[1], second[2]);
      }
    }
    if (closed)
    {
      stencil.weights = mirrored(
        stencil.weights, [&](int k) { return (sectors + 1 - k) % sectors; },
        [&](int k) { return (sectors - k) % sectors; });
    }
    stencils.sectors.push_back(stencil);
  }
  if (!closed)
  {
    // An open fan read from its other end must give the same bits.
    const auto reflect = [&](const FanMask& mask) {
      FanMask result = mask;
      std::reverse(result.spokes.begin(), result.spokes.end());
      std::reverse(result.sectors.begin(), result.sectors.end());
      return result;
    };
    const auto symmetrize = [&](std::vector<FanStencil>& list) {
      const std::size_t count = list.size();
      for (std::size_t i = 0; i <= (count - 1) / 2; ++i)
      {
        FanMask mean = zeroMask(shape);
        addScaled(mean, 0.5, list[i].weights);
        addScaled(mean, 0.5, reflect(list[count - 1 - i].weights));
        list[i].weights = mean;
        list[count - 1 - i].weights = reflect(mean);
      }
    };
    symmetrize(stencils.spokes);
    symmetrize(stencils.sectors);
  }
  return stencils;
}

/// Blocks that meet at an edge are no more (MostBlocksAtEdge), nor quadrilaterals at a vertex of the boundary.
constexpr int MostSectors = MostBlocksAtEdge;
constexpr int TwistCount = static_cast<int>(Twist::Literal) + 1;

FanStencils stencilsFor(bool closed, int sectors, Twist twist)
{
  if (closed && sectors == 4)
  {
    return regularClosedStencils();
  }
  if (!closed && sectors == 2)
  {
    return regularOpenStencils();
  }
  return extraordinaryStencils(closed, sectors, twist);
}

/// Those of each kind of fan are computed once, by the first that asks; the others wait for that kind alone.
const FanStencils& stencilsOf(bool closed, int sectors, Twist twist)
{
  struct Kind
  {
    std::once_flag once;
    FanStencils stencils;
  };
  static std::array<Kind, 2 * TwistCount*(MostSectors + 1)> kinds;
  if (sectors < 1 || sectors > MostSectors)
  {
    throw Error(
      "a fan of " + std::to_string(sectors) + " sectors; there are rules for 1 to " + std::to_string(MostSectors));
  }
  Kind& kind = kinds[(TwistCount * (closed ? 1 : 0) + static_cast<int>(twist)) * (MostSectors + 1) + sectors];
  std::call_once(kind.once, [&] { kind.stencils = stencilsFor(closed, sectors, twist); });
  return kind.stencils;
}

/// Applies a stencil, turned by `rotation` spokes.
Vec3 apply(const FanStencil& stencil, const Fan& fan, int rotation, OrderFreeSum& sum)
{
  sum.clear();
  sum.add(stencil.weights.center, fan.center);
  const int spokes = fan.spokeCount();
  const int sectors = fan.sectorCount();
  for (int i = 0; i < spokes; ++i)
  {
    sum.add(stencil.weights.spokes[i], fan.spokes[(i + rotation) % spokes]);
  }
  for (int i = 0; i < sectors; ++i)
  {
    sum.add(stencil.weights.sectors[i], fan.sectors[(i + rotation) % sectors]);
  }
  return sum.result(stencil.denominator);
}

} // namespace

namespace
{

/// Wall spacing stretches the offsets a_i of a converted fan, and the twist with them; the knot-insertion weight leaves
/// all as it is.
Fan stretchedFan(Fan result, const std::vector<double>& nearWeight, const Fan& fan)
{
  if (std::all_of(nearWeight.begin(), nearWeight.end(), [](double weight) { return weight == KnotInsertion; }))
  {
    return result;
  }
  const double cosine = regularFan(fan.closed, fan.sectorCount()).cosine;
  const double blend = (6.0 + 2.0 * cosine) / (3.0 * (2.0 + 2.0 * cosine));
  const std::vector<Vec3> spokes = result.spokes;
  const auto stretch = [&](int i) { return nearWeight[i] == KnotInsertion ? 1.0 : 3.0 * (1.0 - nearWeight[i]); };
  for (int i = 0; i < fan.sectorCount(); ++i)
  {
    const int next = fan.nextSpoke(i);
    if (stretch(i) != 1.0 || stretch(next) != 1.0)
    {
      const Vec3 a = spokes[i] - result.center;
      const Vec3 b = spokes[next] - result.center;
      const Vec3 bend = result.sectors[i] - result.center - blend * (a + b);
      result.sectors[i] =
        result.center + blend * (stretch(i) * a + stretch(next) * b) + (stretch(i) * stretch(next)) * bend;
    }
  }
  for (int i = 0; i < fan.spokeCount(); ++i)
  {
    if (stretch(i) != 1.0)
    {
      result.spokes[i] = result.center + stretch(i) * (spokes[i] - result.center);
    }
  }
  return result;
}

/// Closed fans from the smallest spoke on, towards the smaller of its neighbours.
class FanOrder
{
public:
  explicit FanOrder(const Fan& fan)
    : N(fan.sectorCount())
    , Order(fan.sectorCount(), [&fan](int a, int b) { return comesBefore(fan.spokes[a], fan.spokes[b]); })
  {
  }

  Fan sorted(const Fan& fan) const
  {
    Fan result = fan;
    for (int i = 0; i < this->N; ++i)
    {
      result.spokes[i] = fan.spokes[this->Order.item(i)];
      result.sectors[i] = fan.sectors[this->Order.gap(i)];
    }
    return result;
  }
  Fan restored(const Fan& fan) const
  {
    Fan result = fan;
    for (int i = 0; i < this->N; ++i)
    {
      result.spokes[this->Order.item(i)] = fan.spokes[i];
      result.sectors[this->Order.gap(i)] = fan.sectors[i];
    }
    return result;
  }

private:
  int N;
  CycleOrder Order;
};

/// The layer rule of the source: neighbours projected onto the tangent plane (5.42), parallelograms (5.43).
Fan thesisFan(const Fan& input)
{
  const FanOrder order(input);
  const Fan fan = order.sorted(input);
  Fan result = fan;
  result.center = smoothFan(fan, Twist::Parallelogram, std::vector<double>(fan.spokeCount(), KnotInsertion)).center;
  const Vec3 normal = limitNormal(fan);
  const int n = fan.sectorCount();
  std::vector<Vec3> offsets;
  for (int i = 0; i < n; ++i)
  {
    const Vec3 border = smoothMask(fan.sectors[(i + n - 1) % n], fan.spokes[i], fan.sectors[i]) - result.center;
    offsets.push_back((border - normal.dot(border) * normal) / 3.0);
    result.spokes[i] = result.center + offsets[i];
  }
  for (int i = 0; i < n; ++i)
  {
    result.sectors[i] = result.center + (offsets[i] + offsets[(i + 1) % n]);
  }
  return order.restored(result);
}

/// Loop and Schaefer 2008.
Fan accFan(const Fan& fan)
{
  Fan result = fan;
  const int n = fan.sectorCount();
  result.center = smoothFan(fan, Twist::Mask, std::vector<double>(n, KnotInsertion)).center;
  OrderFreeSum sum;
  for (int i = 0; i < n; ++i)
  {
    sum.clear();
    sum.add(n, fan.center);
    sum.add(2.0, fan.spokes[i]);
    sum.add(2.0, fan.spokes[(i + 1) % n]);
    sum.add(1.0, fan.sectors[i]);
    result.sectors[i] = sum.result(n + 5.0);
  }
  for (int i = 0; i < n; ++i)
  {
    result.spokes[i] = 0.5 * (result.sectors[(i + n - 1) % n] + result.sectors[i]);
  }
  return result;
}

} // namespace

Fan smoothFan(const Fan& fan, Twist twist, const std::vector<double>& nearWeight)
{
  const bool extraordinary = fan.closed && fan.sectorCount() != 4;
  if (extraordinary && twist == Twist::Literal && limitNormal(fan) != Vec3::Zero())
  {
    return stretchedFan(thesisFan(fan), nearWeight, fan);
  }
  if (extraordinary && twist == Twist::ACC)
  {
    return stretchedFan(accFan(fan), nearWeight, fan);
  }
  // Those two rules are for closed fans, or for the net with double knots.
  const bool other = twist == Twist::ACC || twist == Twist::PCCM;
  const FanStencils& stencils = stencilsOf(fan.closed, fan.sectorCount(), other ? Twist::SecondFundamentalForm : twist);
  OrderFreeSum sum;
  Fan result = fan;
  result.center = apply(stencils.center, fan, 0, sum);
  for (int i = 0; i < fan.spokeCount(); ++i)
  {
    result.spokes[i] = fan.closed ? apply(stencils.spokes[0], fan, i, sum) : apply(stencils.spokes[i], fan, 0, sum);
  }
  for (int i = 0; i < fan.sectorCount(); ++i)
  {
    result.sectors[i] = fan.closed ? apply(stencils.sectors[0], fan, i, sum) : apply(stencils.sectors[i], fan, 0, sum);
  }

  return stretchedFan(result, nearWeight, fan);
}

void smoothRegularFans(
  bool closed, const std::vector<const Vec3*>& points, Index count, const std::vector<Vec3*>& values)
{
  const int sectors = closed ? 4 : 2;
  const int spokes = closed ? 4 : 3;
  const FanStencils& stencils = stencilsOf(closed, sectors, Twist::Mask);
  const auto applyToAll = [&](const FanStencil& stencil, int rotation, Vec3* results) {
    std::array<double, 9> weights;
    std::array<const double*, 9> terms;
    int termCount = 0;
    const auto add = [&](double weight, const Vec3* term) {
      if (weight != 0.0)
      {
        weights[termCount] = weight;
        terms[termCount++] = term->data();
      }
    };
    add(stencil.weights.center, points[0]);
    for (int i = 0; i < spokes; ++i)
    {
      add(stencil.weights.spokes[i], points[1 + (i + rotation) % spokes]);
    }
    for (int i = 0; i < sectors; ++i)
    {
      add(stencil.weights.sectors[i], points[1 + spokes + (i + rotation) % sectors]);
    }
    orderFreeSums(weights.data(), terms.data(), termCount, stencil.denominator, 3 * count, results->data());
  };
  applyToAll(stencils.center, 0, values[0]);
  for (int i = 0; i < spokes; ++i)
  {
    applyToAll(stencils.spokes[closed ? 0 : i], closed ? i : 0, values[1 + i]);
  }
  for (int i = 0; i < sectors; ++i)
  {
    applyToAll(stencils.sectors[closed ? 0 : i], closed ? i : 0, values[1 + spokes + i]);
  }
}

CreasedFan creasedFan(const Fan& fan, const std::vector<int>& features, const std::vector<bool>& keptSpokes,
  const std::vector<bool>& planarSectors, Twist twist, const std::vector<double>& nearWeight,
  const std::vector<SpokeKeep>& keeps)
{
  const int n = fan.sectorCount();
  const int cuts = static_cast<int>(features.size());
  const auto groupSize = [&](int c) { return cuts < 2 ? n : (features[(c + 1) % cuts] - features[c] + n) % n; };
  CreasedFan result{ fan, cuts == 2 && groupSize(0) != 1 && groupSize(1) != 1 };
  if (result.crease)
  {
    result.points.center = smoothMask(fan.spokes[features[0]], fan.center, fan.spokes[features[1]]);
  }
  for (int c = 0; c < std::max(1, cuts); ++c)
  {
    const int first = cuts > 0 ? features[c] : 0;
    const int size = groupSize(c);
    Fan group;
    group.closed = cuts < 2;
    group.center = fan.center;
    std::vector<double> near;
    std::vector<SpokeKeep> inner;
    std::vector<Vec3> along;
    bool planar = false;
    for (int i = 0; i < size + (group.closed ? 0 : 1); ++i)
    {
      const int at = (first + i) % n;
      group.spokes.push_back(fan.spokes[at]);
      near.push_back(nearWeight[at]);
      const bool border = !group.closed && (i == 0 || i == size);
      inner.push_back(border ? SpokeKeep{} : keeps[at]);
      along.push_back(keptSpokes[at] || border
          ? fan.spokes[at]
          : fadedMask(fan.sectors[(at + n - 1) % n], fan.spokes[at], fan.sectors[at], keeps[at].step));
      if (i < size)
      {
        group.sectors.push_back(fan.sectors[at]);
        planar = planar || planarSectors[at];
      }
    }
    const Fan values = result.crease && !planar ? fadedFan(group, twist, near, inner)
                                                : anchoredFan(group, result.points.center, along, near);
    for (int i = 0; i < group.spokeCount(); ++i)
    {
      // Both groups at a feature see the same one-dimensional rule.
      const int at = (first + i) % n;
      const bool feature = !group.closed && (i == 0 || i == size);
      result.points.spokes[at] = feature ? insertMask(fan.center, fan.spokes[at], nearWeight[at]) : values.spokes[i];
    }
    for (int i = 0; i < size; ++i)
    {
      result.points.sectors[(first + i) % n] = values.sectors[i];
    }
  }
  return result;
}

bool keptLinesMeet(bool closed, const std::vector<bool>& kept)
{
  const auto lines = std::count(kept.begin(), kept.end(), true);
  const bool inLine = kept.size() == 4 && lines == 2 && kept[0] == kept[2];
  return closed && lines > 1 && !inLine;
}

Fan fadedFan(const Fan& fan, Twist twist, const std::vector<double>& nearWeight, const std::vector<SpokeKeep>& keeps)
{
  Fan result = smoothFan(fan, twist, nearWeight);
  const int n = fan.sectorCount();
  std::vector<int> sharp;
  std::vector<bool> kept(fan.spokeCount(), false);
  double keep = 0.0;
  for (int i = 0; i < fan.spokeCount(); ++i)
  {
    if (keeps[i].any())
    {
      sharp.push_back(i);
      kept[i] = true;
      keep = std::max(keep, keeps[i].center);
    }
  }
  if (sharp.empty())
  {
    return result;
  }
  const bool meet = keptLinesMeet(fan.closed, kept);
  if (fan.closed && n == 4 && !meet)
  {
    const int i = sharp[0];
    const int j = (i + 2) % 4;
    // A line that ends here leaves the centre smooth.
    const Vec3 middle =
      fadedMask(fan.spokes[(i + 1) % 4], fan.center, fan.spokes[(i + 3) % 4], sharp.size() == 2 ? keep : 0.0);
    const Vec3 ahead = fadedMask(fan.sectors[(i + 3) % 4], fan.spokes[i], fan.sectors[i], keeps[i].step);
    const Vec3 behind = fadedMask(fan.sectors[(j + 3) % 4], fan.spokes[j], fan.sectors[j], keeps[j].step);
    result.center = smoothMask(ahead, middle, behind);
    result.spokes[i] = insertMask(middle, ahead, nearWeight[i]);
    result.spokes[j] = insertMask(middle, behind, nearWeight[j]);
  }
  else if (!fan.closed && n == 2 && sharp[0] == 1 && sharp.size() == 1)
  {
    result.center = fadedMask(fan.spokes[0], fan.center, fan.spokes[2], keep);
    result.spokes[1] =
      insertMask(result.center, fadedMask(fan.sectors[0], fan.spokes[1], fan.sectors[1], keeps[1].step), nearWeight[1]);
  }
  else if (meet)
  {
    const Fan creased = creasedFan(fan, sharp, kept, std::vector<bool>(n, false), twist, nearWeight, keeps).points;
    const auto blend = [&](Vec3& smooth, const Vec3& target) { smooth += keep * (target - smooth); };
    blend(result.center, creased.center);
    for (int i = 0; i < n; ++i)
    {
      blend(result.spokes[i], creased.spokes[i]);
      blend(result.sectors[i], creased.sectors[i]);
    }
  }
  return result;
}

Vec3 limitNormal(const Fan& fan)
{
  const LimitMasks limit = closedFanLimitMasks(fan.sectorCount());
  const Vec3 cross = combination(limit.tangent1, fan).cross(combination(limit.tangent2, fan));
  const double length = cross.norm();
  return length > 0.0 ? Vec3(cross / length) : Vec3(Vec3::Zero());
}

namespace
{

/// x^_uv / 9 (5.40), (5.41).
Vec3 thesisTwist(const Vec3& diagonal, const Vec3& center, const BodyFoot& foot)
{
  const Vec3 offset = diagonal - center;
  const double length = (offset - foot.normal.dot(offset) * foot.normal).norm() / 3.0;
  return length / 9.0 * foot.mixedDirection;
}

} // namespace

Fan projectedFan(const Fan& input, const BodyFoot& foot, Twist twist)
{
  const Vec3& projection = foot.point;
  const Vec3& normal = foot.normal;
  const int n = input.sectorCount();
  // Nothing below may depend on where the fan starts and in which sense it runs.
  const FanOrder order(input);
  const Fan fan = order.sorted(input);

  Fan points = fan;
  points.center = projection;
  std::vector<Vec3> offsets(n);
  const Fan smooth = foot.regularOffsets ? smoothFan(fan, twist, std::vector<double>(n, KnotInsertion)) : Fan();
  for (int i = 0; i < n; ++i)
  {
    const Vec3 border = foot.regularOffsets
      ? Vec3(3.0 * (smooth.spokes[i] - smooth.center))
      : Vec3(smoothMask(fan.sectors[(i + n - 1) % n], fan.spokes[i], fan.sectors[i]) - projection);
    offsets[i] = (border - normal.dot(border) * normal) / 3.0;
    points.spokes[i] = projection + offsets[i];
  }

  const RegularFan shape = regularFan(true, n);
  const double g = 2.0 * shape.cosine;
  const double blend = twist == Twist::SecondFundamentalForm ? (6.0 + g) / (3.0 * (2.0 + g)) : 1.0;
  // The fitted quadratic lives in the coordinates of the regular fan; the limit tangents along its axes carry the
  // offsets there.
  const LimitMasks limit = closedFanLimitMasks(n);
  const Vec3 alongFirst = combination(limit.tangent1, fan) / applyTo(limit.tangent1, shape)[0];
  const Vec3 alongSecond = combination(rotated(limit.tangent1, 1), fan) / applyTo(limit.tangent1, shape)[0];
  Eigen::Matrix<double, 3, 2> axes;
  axes.col(0) = alongFirst;
  axes.col(1) = (alongSecond - shape.cosine * alongFirst) / shape.spokes[1][1];
  axes -= normal * (normal.transpose() * axes);
  // Of sizes that the compiler does not know: GCC 16 warns of the known ones inside Eigen 5.
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(axes);
  const std::array<FanMask, 3> second = quadraticFit(shape);
  const double xx = normal.dot(combination(second[0], fan));
  const double xy = normal.dot(combination(second[1], fan));
  const double yy = normal.dot(combination(second[2], fan));
  for (int i = 0; i < n; ++i)
  {
    const int next = (i + 1) % n;
    if (twist == Twist::Mask)
    {
      const Vec3 corners[4] = { fan.center, fan.spokes[i], fan.spokes[next], fan.sectors[i] };
      const double weights[2] = { KnotInsertion, KnotInsertion };
      points.sectors[i] = multilinear(corners, weights, 2);
      continue;
    }
    points.sectors[i] = projection + blend * (offsets[i] + offsets[next]);
    if (foot.regularOffsets && twist == Twist::SecondFundamentalForm)
    {
      // What the layer's own quadratic has in the tangent plane.
      const Vec3 bend = smooth.sectors[i] - smooth.center -
        blend * ((smooth.spokes[i] - smooth.center) + (smooth.spokes[next] - smooth.center));
      points.sectors[i] += bend - normal.dot(bend) * normal;
    }
    if (twist == Twist::Literal)
    {
      points.sectors[i] += thesisTwist(fan.sectors[i], projection, foot);
    }
    else if (twist == Twist::SecondFundamentalForm && foot.hasCurvature)
    {
      points.sectors[i] += offsets[i].dot(foot.curvature * offsets[next]) * normal;
    }
    else if (twist == Twist::SecondFundamentalForm)
    {
      const Eigen::Vector2d a = solver.solve(Eigen::VectorXd(offsets[i]));
      const Eigen::Vector2d b = solver.solve(Eigen::VectorXd(offsets[next]));
      points.sectors[i] += (xx * a[0] * b[0] + xy * (a[0] * b[1] + a[1] * b[0]) + yy * a[1] * b[1]) * normal;
    }
  }

  return order.restored(points);
}

void projectGroup(Fan& points, const Fan& mesh, int first, int size, const BodyFoot& foot, Twist twist)
{
  const int n = points.sectorCount();
  const auto offset = [&](int i) { return Vec3(points.spokes[(first + i) % n] - points.center); };
  for (int i = 1; i < size; ++i)
  {
    const Vec3 a = offset(i);
    points.spokes[(first + i) % n] = points.center + (a - foot.normal.dot(a) * foot.normal);
  }
  const double g = 2.0 * regularFan(false, size).cosine;
  const double blend = twist == Twist::SecondFundamentalForm ? (6.0 + g) / (3.0 * (2.0 + g)) : 1.0;
  for (int i = 0; i < size && twist != Twist::Mask; ++i)
  {
    const Vec3 a = offset(i), b = offset(i + 1);
    Vec3& sector = points.sectors[(first + i) % n];
    sector = points.center + blend * (a + b);
    if (twist == Twist::Literal)
    {
      sector += thesisTwist(mesh.sectors[(first + i) % n], points.center, foot);
    }
    else if (twist == Twist::SecondFundamentalForm)
    {
      // Both orders of the product: the group may be read from either end.
      sector += 0.5 * (a.dot(foot.curvature * b) + b.dot(foot.curvature * a)) * foot.normal;
    }
  }
}

Vec3 multilinear(const Vec3* corners, const double* nearWeight, int n)
{
  bool regular = true;
  for (int d = 0; d < n; ++d)
  {
    regular = regular && nearWeight[d] == KnotInsertion;
  }
  OrderFreeSum sum;
  for (int corner = 0; corner < 1 << n; ++corner)
  {
    // Integer weights are exact; others are multiplied in ascending order.
    std::array<double, 3> factors{ 1.0, 1.0, 1.0 };
    for (int d = 0; d < n; ++d)
    {
      const bool far = (corner >> d & 1) != 0;
      factors[d] = regular ? (far ? 1.0 : 2.0) : (far ? 1.0 - nearWeight[d] : nearWeight[d]);
    }
    std::sort(factors.begin(), factors.end());
    sum.add(factors[0] * factors[1] * factors[2], corners[corner]);
  }
  return sum.result(regular ? std::pow(3.0, n) : 1.0);
}

Fan anchoredFan(
  const Fan& fan, const Vec3& center, const std::vector<Vec3>& along, const std::vector<double>& nearWeight)
{
  Fan result = fan;
  result.center = center;
  for (int i = 0; i < fan.spokeCount(); ++i)
  {
    result.spokes[i] = insertMask(center, along[i], nearWeight[i]);
  }
  for (int i = 0; i < fan.sectorCount(); ++i)
  {
    const int next = fan.nextSpoke(i);
    const Vec3 corners[4] = { fan.center, fan.spokes[i], fan.spokes[next], fan.sectors[i] };
    const double weights[2] = { nearWeight[i], nearWeight[next] };
    result.sectors[i] = multilinear(corners, weights, 2);
  }
  return result;
}

} // namespace bsv

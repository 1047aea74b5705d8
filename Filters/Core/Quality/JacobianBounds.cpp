// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/JacobianBounds.h"

#include "Quality/SignBySubdivision.h"
#include "Quality/SpanOrientation.h"
#include "Volume/BezierSegments.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>

// Rounding errors. Notation of N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., SIAM 2002,
// chapter 3: u = 2^-53; a product of n factors (1 + d)^+-1, |d| <= u, is 1 + t with |t| <= gamma(n) = n u / (1 - n u).
//
// 1. Control points enter relative to one of them, o. Let P_c be the largest |component c| of what enters, which is w
//    and w (x - o) for rational spans. Difference, product with w, and P_c taken from rounded values: 4 roundings.
// 2. The exact weights of a Bezier point are not negative and sum to 1. Every step of the recurrence of bezierWeights()
//    adds at most 9 u to the sum of their absolute errors (3 u for s, 3 u for 1 - s, the rest for products and sum),
//    the mean at its end 2 u: (9 p + 2) u in all. A pass multiplies and adds p + 1 terms: p + 1 roundings. With all
//    three passes a computed Bezier point differs from the exact one by at most
//        b_c = gamma(n) P_c,  n = 4 + sum over the directions of (9 p + 2) + (p + 1);
//    4 more are added for the evaluation of r_c below.
// 3. Let h' be the derivatives' Bezier points p (b(i+1) - b(i)), exact but for the b, which are the computed ones. They
//    differ from those of the volume by at most r_c = 2 p b_c (for H itself r_c = b_c).
// 4. A coefficient of D is a convex combination of products of Bezier points of the factors. What is computed has at
//    most m = JacobianBatch::roundings() factors (1 + d) on every such product of the h'. With U_c >= |h'_c| it is
//    within gamma(m) perm(U) of D(h'), where perm is the permanent of the matrix of the U of all rows and components.
//    D is linear in every row, so |D(h') - D| <= perm(U + r) - perm(U).
//    Together, with 80 roundings more for the evaluation of this bound and its sum with the coefficients:
//        E = perm(U + r) - perm(U) + gamma(m + 80) perm(U + r).
// 5. An underflow is an error of 2^-1075, multiplied by at most three factors P_c and by 2^40 from binomials and
//    numbers of terms. The largest P_c are brought into 2^-60..2^60: less than 2^-800 in all.
// 6. If all points have the same x, y or z, D is computed as zero exactly, and is.
// 7. Halving takes n = degree of D means one after the other, each with one rounding of a number below 1.1 perm(U + r).

namespace bsv
{

namespace
{

constexpr double Unit = 0.5 * std::numeric_limits<double>::epsilon();
constexpr double Infinity = std::numeric_limits<double>::infinity();

double gamma(double n)
{
  return n * Unit / (1.0 - n * Unit);
}

/// What underflow adds.
constexpr double Tiny = 0x1p-800;

/// Spans of a direction and their Bezier weights.
struct Direction
{
  int degree;
  std::vector<int> spans;
  std::vector<double> weights;

  const double* at(int span) const { return this->weights.data() + span * (this->degree + 1) * (this->degree + 1); }
};

Direction direction(const BSplineVolume& volume, int d, const std::string& name)
{
  Direction result;
  result.degree = volume.degree[d];
  result.spans = nonEmptySpans(result.degree, volume.knots[d]);
  const std::size_t size = static_cast<std::size_t>(result.degree + 1) * (result.degree + 1);
  result.weights.resize(size * result.spans.size());
  for (std::size_t s = 0; s < result.spans.size(); ++s)
  {
    bezierWeights(result.degree, volume.knots[d], result.spans[s], result.weights.data() + s * size);
  }
  if (!std::all_of(result.weights.begin(), result.weights.end(), [](double w) { return std::isfinite(w); }))
  {
    throw Error(name + ": differences of the knots in direction " + "uvw"[d] + " overflow");
  }
  return result;
}

/// Permanent of a matrix of 3 or 4 rows of numbers >= 0.
template <int N>
double permanent(const double (&m)[4][4], int row = 4 - N, int used = 0)
{
  double sum = 0.0;
  for (int c = 0; c < N; ++c)
  {
    if (!(used >> c & 1))
    {
      sum += m[row][c] * (row == 3 ? 1.0 : permanent<N>(m, row + 1, used | 1 << c));
    }
  }
  return sum;
}

/// Results of one chunk of spans.
struct Chunk
{
  const BSplineVolume& volume;
  const std::array<Direction, 3>& directions;
  const JacobianOptions& options;
  const JacobianArrays& arrays;
  JacobianReport report;

  /// The span of an entry of the arrays.
  Index span(Index entry) const { return this->options.spans ? (*this->options.spans)[entry] : entry; }
  Ijk ijk(Index span) const
  {
    const Index n0 = static_cast<Index>(this->directions[0].spans.size());
    const Index n1 = static_cast<Index>(this->directions[1].spans.size());
    return { static_cast<int>(span % n0), static_cast<int>(span / n0 % n1), static_cast<int>(span / n0 / n1) };
  }
};

/// Fills the lanes of a batch and judges what it computed.
class ChunkWorker
{
public:
  explicit ChunkWorker(Chunk& chunk)
    : Work(chunk)
    , Orient(chunk.volume)
    , Batch(sortedDegree(chunk.volume), chunk.volume.weights != nullptr, chunk.options.instructions,
        chunk.options.specialised)
    , Halving(Batch.coefficientCounts, chunk.options.maxDepth)
    , Lanes(Batch.lanes)
  {
    double n = 4.0 + 4.0;
    for (const int p : this->Batch.degree)
    {
      n += (9.0 * p + 2.0) + (p + 1.0);
    }
    this->BezierError = gamma(n);
    this->ProductError = gamma(this->Batch.roundings() + 80.0);
  }

  void operator()(Index begin, Index end)
  {
    for (Index entry = begin; entry < end; entry += this->Batch.lanes)
    {
      const int used = static_cast<int>(std::min<Index>(this->Batch.lanes, end - entry));
      for (int l = 0; l < this->Batch.lanes; ++l)
      {
        this->fill(l, this->Work.span(entry + std::min(l, used - 1))); // spare lanes repeat the last span
      }
      this->Batch.compute();
      for (int l = 0; l < used; ++l)
      {
        this->judge(l, entry + l);
      }
    }
  }

private:
  struct Lane
  {
    SpanOrientation orientation;
    /// P_c of the derivation above, w first if the span is rational, and the exponent of the power of two by which
    /// points are divided.
    std::array<double, 4> extent;
    int exponent;
    /// All points have the same x, y or z.
    bool flat;
    bool overflow;
  };

  static std::array<int, 3> sortedDegree(const BSplineVolume& volume)
  {
    std::array<int, 3> degree = volume.degree;
    std::sort(degree.begin(), degree.end());
    return degree;
  }

  static int exponentOf(double largest)
  {
    return largest == 0.0 || (largest > 0x1p-60 && largest < 0x1p60) ? 0 : std::max(std::ilogb(largest), -1000);
  }

  void fill(int l, Index span)
  {
    Lane& lane = this->Lanes[l];
    const BSplineVolume& volume = this->Work.volume;
    const int lanes = this->Batch.lanes;
    const Ijk ijk = this->Work.ijk(span);
    Index first = 0;
    Index stride = 1;
    for (int d = 0; d < 3; ++d)
    {
      first += (this->Work.directions[d].spans[ijk[d]] - volume.degree[d]) * stride;
      stride *= volume.count(d);
    }
    lane.orientation = this->Orient(first);
    const SpanOrientation& o = lane.orientation;
    const std::array<int, 3>& degree = this->Batch.degree;

    const Vec3 origin = Eigen::Map<const Vec3>(volume.points + 3 * o.start);
    const Index points = Index(degree[0] + 1) * (degree[1] + 1) * (degree[2] + 1);
    Vec3 extent = Vec3::Zero();
    double largestWeight = 0.0;
    double* const last = this->Batch.control + (this->Batch.components - 3) * points * lanes + l;
    double* to = last;
    for (int k = 0; k <= degree[2]; ++k)
    {
      for (int j = 0; j <= degree[1]; ++j)
      {
        for (int i = 0; i <= degree[0]; ++i, to += lanes)
        {
          const Index at = o.start + i * o.strides[0] + j * o.strides[1] + k * o.strides[2];
          Vec3 x = Eigen::Map<const Vec3>(volume.points + 3 * at) - origin;
          if (volume.weights)
          {
            const double w = volume.weights[at];
            this->Batch.control[to - last + l] = w;
            largestWeight = std::max(largestWeight, w);
          }
          extent = extent.cwiseMax(x.cwiseAbs());
          for (int c = 0; c < 3; ++c)
          {
            to[c * points * lanes] = x[c];
          }
        }
      }
    }
    lane.overflow = !extent.allFinite();
    if (lane.overflow)
    {
      extent.setZero();
      for (int c = 0; c < 3; ++c)
      {
        for (Index n = 0; n < points; ++n)
        {
          last[(c * points + n) * lanes] = 0.0;
        }
      }
    }
    lane.flat = extent.minCoeff() == 0.0;
    lane.exponent = exponentOf(extent.maxCoeff());
    const int weightExponent = exponentOf(largestWeight);
    if (lane.exponent != 0)
    {
      extent *= std::ldexp(1.0, -lane.exponent);
    }
    if (volume.weights || lane.exponent != 0)
    {
      this->scale(l, lane, points, weightExponent, extent);
    }
    lane.extent = { extent[0], extent[1], extent[2], 0.0 };
    if (volume.weights)
    {
      lane.extent = { std::ldexp(largestWeight, -weightExponent), extent[0], extent[1], extent[2] };
    }

    for (int d = 0; d < 3; ++d)
    {
      const int n = degree[d] + 1;
      const double* weights = this->Work.directions[o.order[d]].at(ijk[o.order[d]]);
      for (int q = 0; q < n * n; ++q)
      {
        this->Batch.weights[d][q * lanes + l] = weights[o.flip[d] ? n * n - 1 - q : q];
      }
    }
    this->Batch.sign[l] = this->Work.options.leftHanded ? -o.sign() : o.sign();
  }

  /// Powers of two, and products with the weights.
  void scale(int l, const Lane& lane, Index points, int weightExponent, Vec3& extent)
  {
    const int lanes = this->Batch.lanes;
    const bool rational = this->Batch.components == 4;
    extent = rational ? Vec3::Zero() : extent;
    for (Index n = 0; n < points; ++n)
    {
      double w = 1.0;
      if (rational)
      {
        w = std::ldexp(this->Batch.control[n * lanes + l], -weightExponent);
        this->Batch.control[n * lanes + l] = w;
      }
      for (int c = 0; c < 3; ++c)
      {
        double& x = this->Batch.control[((c + this->Batch.components - 3) * points + n) * lanes + l];
        x = w * std::ldexp(x, -lane.exponent);
        if (rational)
        {
          extent[c] = std::max(extent[c], std::abs(x));
        }
      }
    }
  }

  void judge(int l, Index entry)
  {
    const Lane& lane = this->Lanes[l];
    const int lanes = this->Batch.lanes;
    const int components = this->Batch.components;

    // U and U + r of the derivation above.
    double computed[4][4] = {};
    double exact[4][4] = {};
    for (int row = 4 - components; row < 4; ++row)
    {
      const double factor = row == 0 ? 1.0 : 2.0 * this->Batch.degree[row - 1];
      for (int c = 0; c < components; ++c)
      {
        computed[row][c] = this->Batch.magnitudes[(4 * row + c) * lanes + l] * (1.0 + 8.0 * Unit);
        exact[row][c] = computed[row][c] + factor * this->BezierError * lane.extent[c];
      }
    }
    const double size = components == 4 ? permanent<4>(exact) : permanent<3>(exact);
    const double change = size - (components == 4 ? permanent<4>(computed) : permanent<3>(computed));
    const double error = lane.flat ? 0.0 : change + this->ProductError * size + Tiny;

    SignVerdict verdict;
    verdict.lower = this->Batch.lowest[l] - error;
    verdict.upper = this->Batch.highest[l] + error;
    if (lane.overflow)
    {
      verdict.lower = -Infinity;
      verdict.upper = Infinity;
    }
    else if (verdict.lower > 0.0)
    {
      verdict.validity = Validity::Valid;
    }
    else
    {
      std::vector<double>& root = this->Halving.root();
      for (std::size_t n = 0; n < root.size(); ++n)
      {
        root[n] = this->Batch.coefficients[n * lanes + l];
      }
      verdict = this->Halving(error, 1.1 * Unit * size + Tiny);
    }
    this->rescale(verdict, l);
    this->store(verdict, l, entry);
  }

  /// From D to det J.
  void rescale(SignVerdict& verdict, int l) const
  {
    const Lane& lane = this->Lanes[l];
    if (this->Batch.components == 4)
    {
      constexpr double Out = 1.0 + 16.0 * Unit;
      const double error = this->BezierError * lane.extent[0];
      const double low = std::pow(std::max(0.0, this->Batch.lowestWeight[l] - error), 4) / Out;
      const double high = std::pow(this->Batch.highestWeight[l] + error, 4) * Out;
      // Infinite where rounding leaves no weight.
      const auto divide = [](double x, double w) { return x == 0.0 ? 0.0 : x / w; };
      verdict.lower = divide(verdict.lower, verdict.lower > 0.0 ? high : low);
      verdict.upper = divide(verdict.upper, verdict.upper > 0.0 ? low : high);
      verdict.value = divide(verdict.value, high);
      verdict.lower -= 16.0 * Unit * std::abs(verdict.lower);
      verdict.upper += 16.0 * Unit * std::abs(verdict.upper);
      verdict.value += 16.0 * Unit * std::abs(verdict.value);
    }
    if (lane.exponent != 0)
    {
      verdict.lower = std::ldexp(verdict.lower, 3 * lane.exponent);
      verdict.upper = std::ldexp(verdict.upper, 3 * lane.exponent);
      verdict.value = std::ldexp(verdict.value, 3 * lane.exponent);
    }
    // Rounded to nearest, or overflown.
    const auto small = [](double x) { return std::abs(x) < std::numeric_limits<double>::min(); };
    if (small(verdict.lower) || verdict.lower == Infinity)
    {
      verdict.lower = std::nextafter(verdict.lower, -Infinity);
    }
    if (small(verdict.upper) || verdict.upper == -Infinity)
    {
      verdict.upper = std::nextafter(verdict.upper, Infinity);
    }
  }

  void store(const SignVerdict& verdict, int l, Index entry)
  {
    const Index span = this->Work.span(entry);
    JacobianReport& report = this->Work.report;
    report.valid += verdict.validity == Validity::Valid ? 1 : 0;
    report.undecided += verdict.validity == Validity::Undecided ? 1 : 0;
    report.negative += verdict.upper < 0.0 ? 1 : 0;
    if (report.lowestSpan < 0 || verdict.lower < report.lowest)
    {
      report.lowest = verdict.lower;
      report.lowestSpan = span;
    }
    if (verdict.validity == Validity::Invalid)
    {
      ++report.invalid;
      JacobianWitness witness;
      witness.span = span;
      witness.ijk = this->Work.ijk(span);
      witness.value = verdict.value;
      const SpanOrientation& o = this->Lanes[l].orientation;
      for (int d = 0; d < 3; ++d)
      {
        const int to = o.order[d];
        const double f = o.flip[d] ? 1.0 - verdict.at[d] : verdict.at[d];
        const std::vector<double>& knots = this->Work.volume.knots[to];
        const int s = this->Work.directions[to].spans[witness.ijk[to]];
        witness.fraction[to] = f;
        witness.uvw[to] = f == 1.0 ? knots[s + 1] : knots[s] + f * (knots[s + 1] - knots[s]);
      }
      report.witnesses.push_back(witness);
    }
    const JacobianArrays& arrays = this->Work.arrays;
    const auto set = [entry](auto* array, auto value) {
      if (array)
      {
        array[entry] = value;
      }
    };
    set(arrays.validity, static_cast<unsigned char>(verdict.validity));
    set(arrays.lower, verdict.lower);
    set(arrays.upper, verdict.upper);
    set(arrays.scaledJacobian, std::max(-1.0, std::min(1.0, this->Batch.scaledJacobian[l])));
    if (arrays.skewness)
    {
      constexpr double HalfPi = 1.57079632679489661923;
      arrays.skewness[entry] = std::asin(std::min(1.0, this->Batch.cosine[l])) / HalfPi;
    }
  }

  Chunk& Work;
  CanonicalOrientation Orient;
  JacobianBatch Batch;
  SignBySubdivision Halving;
  std::vector<Lane> Lanes;
  double BezierError;
  double ProductError;
};

void checkPoints(const BSplineVolume& volume, const std::string& name, const Execution& run)
{
  const Index points = Index(volume.count(0)) * volume.count(1) * volume.count(2);
  run.parallelFor(points, 1 << 16, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
    {
      if (!Eigen::Map<const Vec3>(volume.points + 3 * i).allFinite())
      {
        throw Error(name + ": control point (" + std::to_string(i % volume.count(0)) + ", " +
          std::to_string(i / volume.count(0) % volume.count(1)) + ", " +
          std::to_string(i / volume.count(0) / volume.count(1)) + ") is not finite");
      }
    }
  });
}

} // namespace

const std::vector<std::string>& validityNames()
{
  static const std::vector<std::string> names{ "valid", "invalid", "undecided" };
  return names;
}

JacobianReport jacobianBounds(const BSplineVolume& volume, const std::string& name, const JacobianOptions& options,
  const JacobianArrays& arrays, const Execution& run)
{
  if (options.maxDepth < 0 || options.maxDepth > MaxJacobianDepth)
  {
    throw Error(
      name + ": depth " + std::to_string(options.maxDepth) + " is not in 0.." + std::to_string(MaxJacobianDepth));
  }
  if (!options.spans)
  {
    checkPoints(volume, name, run);
  }
  const std::array<Direction, 3> directions{ direction(volume, 0, name), direction(volume, 1, name),
    direction(volume, 2, name) };
  const Index total = options.spans ? static_cast<Index>(options.spans->size())
                                    : static_cast<Index>(directions[0].spans.size()) *
      static_cast<Index>(directions[1].spans.size()) * static_cast<Index>(directions[2].spans.size());

  JacobianReport report;
  std::mutex guard;
  // Progress can be told, and an abort noticed, only between parallel loops.
  const Index piece = 1 << 15;
  for (Index start = 0; start < total; start += piece)
  {
    run.report(static_cast<double>(start) / static_cast<double>(total));
    const std::ptrdiff_t kept = static_cast<std::ptrdiff_t>(report.witnesses.size());
    run.parallelFor(std::min(piece, total - start), 512, [&](Index begin, Index end) {
      Chunk chunk{ volume, directions, options, arrays, {} };
      ChunkWorker worker(chunk);
      worker(start + begin, start + end);
      const JacobianReport& part = chunk.report;
      const std::lock_guard<std::mutex> lock(guard);
      report.valid += part.valid;
      report.invalid += part.invalid;
      report.undecided += part.undecided;
      report.negative += part.negative;
      report.witnesses.insert(report.witnesses.end(), part.witnesses.begin(), part.witnesses.end());
      if (report.lowestSpan < 0 || part.lowest < report.lowest ||
        (part.lowest == report.lowest && part.lowestSpan < report.lowestSpan))
      {
        report.lowest = part.lowest;
        report.lowestSpan = part.lowestSpan;
      }
    });
    std::sort(report.witnesses.begin() + kept, report.witnesses.end(),
      [](const JacobianWitness& a, const JacobianWitness& b) { return a.span < b.span; });
    if (static_cast<Index>(report.witnesses.size()) > options.maxWitnesses)
    {
      report.witnesses.resize(std::max<Index>(0, options.maxWitnesses));
    }
  }
  run.report(1.0);
  return report;
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/JacobianKernel.h"

#include <algorithm>
#include <cmath>

// Vector types of GCC and Clang: arithmetic on them is element by element by definition. Functions are inlined into one
// entry per instruction set, so that each is compiled for it.
#if defined(__GNUC__)
#define BSV_INLINE inline __attribute__((always_inline))
#define BSV_UNROLL _Pragma("GCC unroll 16")
#else
#define BSV_INLINE inline
#define BSV_UNROLL
#endif
#if defined(__GNUC__) && defined(__x86_64__)
#define BSV_X86 1
#else
#define BSV_X86 0
#endif

namespace bsv
{

namespace
{

#if defined(__GNUC__)
template <int W>
struct LanesOf
{
  typedef double Type __attribute__((vector_size(W * sizeof(double)), may_alias));
};
#else
template <int W>
struct LanesOf;
template <>
struct LanesOf<1>
{
  using Type = double;
};
#endif

constexpr int PortableLanes =
#if defined(__GNUC__)
  2;
#else
  1;
#endif

int lanesOf(InstructionSet instructions)
{
  switch (instructions)
  {
    case InstructionSet::Avx512:
      return 8;
    case InstructionSet::Avx2:
      return 4;
    default:
      return PortableLanes;
  }
}

using Counts = std::array<int, 3>;

std::size_t product(const Counts& n)
{
  return static_cast<std::size_t>(n[0]) * n[1] * n[2];
}

/// Terms of a convolution that meet in one coefficient, at most.
int overlap(const Counts& a, const Counts& b)
{
  return std::min(a[0], b[0]) * std::min(a[1], b[1]) * std::min(a[2], b[2]);
}

Counts productCounts(const Counts& a, const Counts& b)
{
  return { a[0] + b[0] - 1, a[1] + b[1] - 1, a[2] + b[2] - 1 };
}

/// Binomial coefficients of the degrees counts - 1, multiplied.
std::vector<double> binomials(const Counts& counts)
{
  std::array<std::vector<double>, 3> rows;
  for (int d = 0; d < 3; ++d)
  {
    double value = 1.0;
    for (int i = 0; i < counts[d]; ++i)
    {
      rows[d].push_back(value);
      value = value * (counts[d] - 1 - i) / (i + 1); // exact: up to C(31, 15)
    }
  }
  std::vector<double> result;
  result.reserve(product(counts));
  for (const double c : rows[2])
  {
    for (const double b : rows[1])
    {
      for (const double a : rows[0])
      {
        result.push_back(a * b * c);
      }
    }
  }
  return result;
}

/// sums += or -= the convolution of a row of na and a row of nb numbers.
template <typename L, bool Minus>
BSV_INLINE void addRow(int na, const L* a, int nb, const L* b, L* sums)
{
  for (int i = 0; i < na; ++i)
  {
    const L x = a[i];
    for (int j = 0; j < nb; ++j)
    {
      sums[i + j] = Minus ? sums[i + j] - x * b[j] : sums[i + j] + x * b[j];
    }
  }
}

template <typename L, bool Minus, int NA, int NB>
BSV_INLINE void addFixedRow(const L* a, const L* b, L* sums)
{
  BSV_UNROLL
  for (int i = 0; i < NA; ++i)
  {
    const L x = a[i];
    BSV_UNROLL
    for (int j = 0; j < NB; ++j)
    {
      sums[i + j] = Minus ? sums[i + j] - x * b[j] : sums[i + j] + x * b[j];
    }
  }
}

/// Operands of a[0] b[0] - a[1] b[1] + a[2] b[2] - ..
struct Sum
{
  int terms;
  Counts countsA;
  Counts countsB;
  std::array<const double*, 4> a;
  std::array<const double*, 4> b;
};

/// row += or -= what term t contributes to row (j, k) of the result.
template <typename L, int NA, int NB, bool Minus>
BSV_INLINE void addTerm(const Sum& sum, int t, int j, int k, L* row)
{
  const Counts na = sum.countsA;
  const Counts nb = sum.countsB;
  const L* a = reinterpret_cast<const L*>(sum.a[t]);
  const L* b = reinterpret_cast<const L*>(sum.b[t]);
  for (int ka = std::max(0, k - nb[2] + 1); ka <= std::min(k, na[2] - 1); ++ka)
  {
    for (int ja = std::max(0, j - nb[1] + 1); ja <= std::min(j, na[1] - 1); ++ja)
    {
      const L* rowA = a + (ka * na[1] + ja) * na[0];
      const L* rowB = b + ((k - ka) * nb[1] + (j - ja)) * nb[0];
      if (NA > 0)
      {
        addFixedRow<L, Minus, NA, NB>(rowA, rowB, row);
      }
      else
      {
        addRow<L, Minus>(na[0], rowA, nb[0], rowB, row);
      }
    }
  }
}

/// The sum of products of polynomials in scaled Bernstein form. Rows of NA and NB numbers, or of any size if NA = 0.
template <typename L, int NA, int NB>
BSV_INLINE void sumOfRows(const Sum& sum, L* out)
{
  constexpr int Fixed = NA > 0 ? NA + NB - 1 : 4 * (MaxDegree + 1);
  const int length = NA > 0 ? Fixed : sum.countsA[0] + sum.countsB[0] - 1;
  for (int k = 0; k < sum.countsA[2] + sum.countsB[2] - 1; ++k)
  {
    for (int j = 0; j < sum.countsA[1] + sum.countsB[1] - 1; ++j, out += length)
    {
      L row[Fixed];
      BSV_UNROLL
      for (int i = 0; i < length; ++i)
      {
        row[i] = L{};
      }
      // Loops of their own for both signs: products that they had in common would fill the registers.
      for (int t = 0; t < sum.terms; ++t)
      {
        t % 2 ? addTerm<L, NA, NB, true>(sum, t, j, k, row) : addTerm<L, NA, NB, false>(sum, t, j, k, row);
      }
      BSV_UNROLL
      for (int i = 0; i < length; ++i)
      {
        out[i] = row[i];
      }
    }
  }
}

template <typename L>
BSV_INLINE void sumOfProducts(const Sum& sum, bool specialised, double* out)
{
  L* to = reinterpret_cast<L*>(out);
  const int na = sum.countsA[0];
  const int nb = sum.countsB[0];
  if (specialised && na == 3 && nb == 4) // cubic: minors
  {
    sumOfRows<L, 3, 4>(sum, to);
  }
  else if (specialised && na == 6 && nb == 4) // cubic: determinant
  {
    sumOfRows<L, 6, 4>(sum, to);
  }
  else if (specialised && na == 2 && nb == 3) // quadratic
  {
    sumOfRows<L, 2, 3>(sum, to);
  }
  else if (specialised && na == 4 && nb == 3)
  {
    sumOfRows<L, 4, 3>(sum, to);
  }
  else
  {
    sumOfRows<L, 0, 0>(sum, to);
  }
}

template <typename L>
BSV_INLINE void keepLarger(L& largest, const L& value)
{
  largest = largest < value ? value : largest;
}

template <typename L>
BSV_INLINE void keepSmaller(L& smallest, const L& value)
{
  smallest = value < smallest ? value : smallest;
}

} // namespace

struct JacobianKernel
{
  /// One direction of the extraction: control points to Bezier points.
  template <typename L>
  static BSV_INLINE void extract(const JacobianBatch& batch, int d, const double* from, double* to)
  {
    const int n = batch.degree[d] + 1;
    const int inner = d == 0 ? 1 : d == 1 ? batch.degree[0] + 1 : (batch.degree[0] + 1) * (batch.degree[1] + 1);
    const int outer = static_cast<int>(product(batch.DerivativeCounts[0])) / (n * inner);
    const L* weights = reinterpret_cast<const L*>(batch.weights[d]);
    const L* in = reinterpret_cast<const L*>(from);
    L* out = reinterpret_cast<L*>(to);
    for (int o = 0; o < outer; ++o, in += n * inner, out += n * inner)
    {
      for (int j = 0; j < n; ++j)
      {
        for (int i = 0; i < inner; ++i)
        {
          L sum = weights[j * n] * in[i];
          for (int q = 1; q < n; ++q)
          {
            sum += weights[j * n + q] * in[q * inner + i];
          }
          out[j * inner + i] = sum;
        }
      }
    }
  }

  /// Scaled coefficients of component c of H and its derivatives, and their magnitudes without the scale.
  template <typename L>
  static BSV_INLINE void derivatives(JacobianBatch& batch, int c, const double* bezier)
  {
    const L* b = reinterpret_cast<const L*>(bezier);
    const Counts n = batch.DerivativeCounts[0];
    const std::array<int, 3> stride{ 1, n[0], n[0] * n[1] };
    for (int row = batch.components == 4 ? 0 : 1; row < 4; ++row)
    {
      const Counts m = batch.DerivativeCounts[row];
      const int step = row == 0 ? 0 : stride[row - 1];
      const double degree = row == 0 ? 1.0 : batch.degree[row - 1];
      const double* scale = batch.DerivativeScales[row].data();
      L* out = reinterpret_cast<L*>(batch.Derivatives[row][c]);
      L largest = L{};
      for (int k = 0; k < m[2]; ++k)
      {
        for (int j = 0; j < m[1]; ++j)
        {
          const L* from = b + j * stride[1] + k * stride[2];
          for (int i = 0; i < m[0]; ++i)
          {
            const L value = row == 0 ? from[i] : from[i + step] - from[i];
            *out++ = value * *scale++;
            keepLarger(largest, value);
            keepLarger<L>(largest, -value);
          }
        }
      }
      reinterpret_cast<L*>(batch.magnitudes)[4 * row + c] = largest * degree;
    }
  }

  /// What a derivative has by rounding where it vanishes, as at poles, is less than this part of the longest one.
  static constexpr double NoLength = 1e-12;

  /// One point of the shape measures, from the values of H and its derivatives there.
  template <typename L>
  static BSV_INLINE void shapeAt(JacobianBatch& batch, const L (&h)[4][4])
  {
    L x[3][3];
    for (int row = 0; row < 3; ++row)
    {
      for (int c = 0; c < 3; ++c)
      {
        // The direction of x_u is that of (w x)_u w - (w x) w_u.
        x[row][c] = batch.components == 4 ? h[row + 1][c + 1] * h[0][0] - h[0][c + 1] * h[row + 1][0] : h[row + 1][c];
      }
    }
    L length[3];
    for (int row = 0; row < 3; ++row)
    {
      const L square = x[row][0] * x[row][0] + x[row][1] * x[row][1] + x[row][2] * x[row][2];
      for (std::size_t l = 0; l < sizeof(L) / sizeof(double); ++l)
      {
        reinterpret_cast<double*>(&length[row])[l] = std::sqrt(reinterpret_cast<const double*>(&square)[l]);
      }
    }
    const L zero = L{};
    L longest = zero;
    for (const L& one : length)
    {
      longest = one > longest ? one : longest;
    }
    for (L& one : length)
    {
      one = one > NoLength * longest ? one : zero;
    }
    const L determinant = x[0][0] * (x[1][1] * x[2][2] - x[1][2] * x[2][1]) -
      x[0][1] * (x[1][0] * x[2][2] - x[1][2] * x[2][0]) + x[0][2] * (x[1][0] * x[2][1] - x[1][1] * x[2][0]);
    const L volume = length[0] * length[1] * length[2];
    const L scaled = volume > zero ? determinant / volume * *reinterpret_cast<const L*>(batch.sign) : zero;
    keepSmaller(*reinterpret_cast<L*>(batch.scaledJacobian), scaled);
    for (int a = 0; a < 3; ++a)
    {
      const int b = a == 2 ? 0 : a + 1;
      const L dot = x[a][0] * x[b][0] + x[a][1] * x[b][1] + x[a][2] * x[b][2];
      const L area = length[a] * length[b];
      // A direction of no length: as skew as it can be.
      const L cosine = area > zero ? dot / area : zero + 1.0;
      keepLarger<L>(*reinterpret_cast<L*>(batch.cosine), cosine);
      keepLarger<L>(*reinterpret_cast<L*>(batch.cosine), -cosine);
    }
  }

  template <typename L>
  static BSV_INLINE void shape(JacobianBatch& batch)
  {
    const int first = batch.components == 4 ? 0 : 1;
    const L zero = L{};
    *reinterpret_cast<L*>(batch.scaledJacobian) = zero + 1.0;
    *reinterpret_cast<L*>(batch.cosine) = zero;
    L h[4][4];
    for (int corner = 0; corner < 8; ++corner)
    {
      for (int row = first; row < 4; ++row)
      {
        const Counts n = batch.DerivativeCounts[row];
        const int at =
          (corner & 1 ? n[0] - 1 : 0) + n[0] * ((corner & 2 ? n[1] - 1 : 0) + n[1] * (corner & 4 ? n[2] - 1 : 0));
        for (int c = 0; c < batch.components; ++c)
        {
          h[row][c] = reinterpret_cast<const L*>(batch.Derivatives[row][c])[at];
        }
      }
      shapeAt<L>(batch, h);
    }
    // In the middle all Bernstein polynomials of degree n are binomials / 2^n.
    for (int row = first; row < 4; ++row)
    {
      const Counts n = batch.DerivativeCounts[row];
      for (int c = 0; c < batch.components; ++c)
      {
        const L* from = reinterpret_cast<const L*>(batch.Derivatives[row][c]);
        L sum = L{};
        for (std::size_t i = 0; i < product(n); ++i)
        {
          sum += from[i];
        }
        h[row][c] = sum * std::ldexp(1.0, 3 - n[0] - n[1] - n[2]);
      }
    }
    shapeAt<L>(batch, h);
  }

  template <int W>
  static BSV_INLINE void compute(JacobianBatch& batch)
  {
    using L = typename LanesOf<W>::Type;
    const int components = batch.components;
    const std::size_t points = product(batch.DerivativeCounts[0]);
    for (int c = 0; c < components; ++c)
    {
      extract<L>(batch, 0, batch.control + c * points * W, batch.Bezier[0]);
      extract<L>(batch, 1, batch.Bezier[0], batch.Bezier[1]);
      extract<L>(batch, 2, batch.Bezier[1], batch.Bezier[0]);
      derivatives<L>(batch, c, batch.Bezier[0]);
      if (components == 4 && c == 0)
      {
        const L* weight = reinterpret_cast<const L*>(batch.Bezier[0]);
        L low = weight[0];
        L high = weight[0];
        for (std::size_t i = 1; i < points; ++i)
        {
          keepSmaller(low, weight[i]);
          keepLarger(high, weight[i]);
        }
        *reinterpret_cast<L*>(batch.lowestWeight) = low;
        *reinterpret_cast<L*>(batch.highestWeight) = high;
      }
    }
    shape<L>(batch);

    const auto& h = batch.Derivatives;
    for (int a = 0; a < components; ++a)
    {
      for (int b = a + 1; b < components; ++b)
      {
        sumOfProducts<L>(
          { 2, batch.DerivativeCounts[1], batch.DerivativeCounts[2], { h[1][a], h[1][b] }, { h[2][b], h[2][a] } },
          batch.Specialised, batch.Minors[a][b]);
      }
    }
    for (int left = 0; left < (components == 4 ? 4 : 1); ++left)
    {
      // The columns but `left`, or all three.
      const int p = components == 4 && left == 0 ? 1 : 0;
      const int q = components == 4 && left <= 1 ? 2 : 1;
      const int r = components == 4 && left <= 2 ? 3 : 2;
      const auto& m = batch.Minors;
      sumOfProducts<L>({ 3, batch.MinorCounts, batch.DerivativeCounts[3], { m[q][r], m[p][r], m[p][q] },
                         { h[3][p], h[3][q], h[3][r] } },
        batch.Specialised, components == 4 ? batch.Determinants[left] : batch.coefficients);
    }
    if (components == 4)
    {
      const auto& m = batch.Determinants;
      sumOfProducts<L>({ 4, batch.DeterminantCounts, batch.DerivativeCounts[0], { m[0], m[1], m[2], m[3] },
                         { h[0][0], h[0][1], h[0][2], h[0][3] } },
        batch.Specialised, batch.coefficients);
    }

    L* coefficients = reinterpret_cast<L*>(batch.coefficients);
    const L sign = *reinterpret_cast<const L*>(batch.sign);
    L low = coefficients[0] * sign; // a corner: its scale is 1
    L high = low;
    for (std::size_t i = 0; i < batch.CoefficientScales.size(); ++i)
    {
      const L value = coefficients[i] * batch.CoefficientScales[i] * sign;
      coefficients[i] = value;
      keepSmaller(low, value);
      keepLarger(high, value);
    }
    *reinterpret_cast<L*>(batch.lowest) = low;
    *reinterpret_cast<L*>(batch.highest) = high;
  }

  static void computePortable(JacobianBatch& batch) { compute<PortableLanes>(batch); }
#if BSV_X86
  __attribute__((target("avx2"))) static void computeAvx2(JacobianBatch& batch)
  {
    compute<4>(batch);
  }
  __attribute__((target("avx512f"))) static void computeAvx512(JacobianBatch& batch)
  {
    compute<8>(batch);
  }
#endif
};

const std::vector<InstructionSet>& instructionSets()
{
  static const std::vector<InstructionSet> sets = [] {
    std::vector<InstructionSet> found{ InstructionSet::Portable };
#if BSV_X86
    if (__builtin_cpu_supports("avx2"))
    {
      found.push_back(InstructionSet::Avx2);
    }
    if (__builtin_cpu_supports("avx512f"))
    {
      found.push_back(InstructionSet::Avx512);
    }
#endif
    return found;
  }();
  return sets;
}

JacobianBatch::JacobianBatch(
  const std::array<int, 3>& degrees, bool rational, InstructionSet instructions, bool specialised)
  : degree(degrees)
  , components(rational ? 4 : 3)
  , lanes(lanesOf(instructions))
  , Instructions(instructions)
  , Specialised(specialised)
{
  for (int row = 0; row < 4; ++row)
  {
    Counts& n = this->DerivativeCounts[row];
    for (int d = 0; d < 3; ++d)
    {
      n[d] = degrees[d] + (row == d + 1 ? 0 : 1);
    }
    this->DerivativeScales[row] = binomials(n);
    for (double& scale : this->DerivativeScales[row])
    {
      scale *= row == 0 ? 1 : degrees[row - 1];
    }
  }
  this->MinorCounts = productCounts(this->DerivativeCounts[1], this->DerivativeCounts[2]);
  this->DeterminantCounts = productCounts(this->MinorCounts, this->DerivativeCounts[3]);
  this->coefficientCounts =
    rational ? productCounts(this->DeterminantCounts, this->DerivativeCounts[0]) : this->DeterminantCounts;
  this->CoefficientScales = binomials(this->coefficientCounts);
  for (double& scale : this->CoefficientScales)
  {
    scale = 1.0 / scale;
  }

  // First the sizes, then the places.
  std::vector<std::pair<double**, std::size_t>> parts;
  const auto add = [&](double*& part, std::size_t size) { parts.emplace_back(&part, size); };
  const std::size_t points = product(this->DerivativeCounts[0]);
  add(this->control, this->components * points);
  for (int d = 0; d < 3; ++d)
  {
    add(this->weights[d], static_cast<std::size_t>(degrees[d] + 1) * (degrees[d] + 1));
  }
  for (double** part : { &this->sign, &this->lowest, &this->highest, &this->lowestWeight, &this->highestWeight,
         &this->scaledJacobian, &this->cosine })
  {
    add(*part, 1);
  }
  add(this->magnitudes, 16);
  add(this->coefficients, product(this->coefficientCounts));
  add(this->Bezier[0], points);
  add(this->Bezier[1], points);
  for (int c = 0; c < this->components; ++c)
  {
    for (int row = 0; row < 4; ++row)
    {
      add(this->Derivatives[row][c], product(this->DerivativeCounts[row]));
    }
    for (int b = c + 1; b < this->components; ++b)
    {
      add(this->Minors[c][b], product(this->MinorCounts));
    }
    if (rational)
    {
      add(this->Determinants[c], product(this->DeterminantCounts));
    }
  }
  const auto lines = [this](std::size_t size) { return (size * this->lanes + 7) / 8; };
  std::size_t total = 0;
  for (const auto& part : parts)
  {
    total += lines(part.second);
  }
  this->Memory.resize(total);
  Line* at = this->Memory.data();
  for (const auto& part : parts)
  {
    *part.first = at->values;
    at += lines(part.second);
  }
}

void JacobianBatch::compute()
{
  switch (this->Instructions)
  {
#if BSV_X86
    case InstructionSet::Avx2:
      JacobianKernel::computeAvx2(*this);
      break;
    case InstructionSet::Avx512:
      JacobianKernel::computeAvx512(*this);
      break;
#endif
    default:
      JacobianKernel::computePortable(*this);
  }
}

int JacobianBatch::roundings() const
{
  // Difference and scale of every derivative; one rounding of each product, and one of every sum.
  const int derivative = 2;
  const int minor = 2 * derivative + 1 + 2 * overlap(this->DerivativeCounts[1], this->DerivativeCounts[2]);
  int determinant = minor + derivative + 1 + 3 * overlap(this->MinorCounts, this->DerivativeCounts[3]);
  if (this->components == 4)
  {
    determinant += 1 + 1 + 4 * overlap(this->DeterminantCounts, this->DerivativeCounts[0]);
  }
  return determinant + 2; // the reciprocal of the binomials, and the product with it
}

} // namespace bsv

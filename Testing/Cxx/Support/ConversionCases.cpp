// SPDX-License-Identifier: BSD-3-Clause
#include "Support/ConversionCases.h"

#include "Quality/JacobianBounds.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>

namespace conversioncases
{

using bsv::Ijk;
using bsv::Index;
using bsv::Vec3;

std::size_t Converted::index(int block, const Ijk& p) const
{
  const bsv::BSplineVolume& v = this->volumes[block];
  return p[0] + std::size_t(v.count(0)) * (p[1] + std::size_t(v.count(1)) * p[2]);
}

Vec3 Converted::controlPoint(int block, const Ijk& p) const
{
  return Vec3(this->points[block].data() + 3 * this->index(block, p));
}

bsv::ControlPointRule Converted::rule(int block, const Ijk& p) const
{
  return static_cast<bsv::ControlPointRule>(this->rules[block][this->index(block, p)]);
}

Converted convert(const bsv::BlockMesh& mesh, const bsv::ConversionOptions& options,
  const bsv::BlockComplexOptions& complexOptions, const bsv::Execution& run)
{
  Converted result;
  result.complex = bsv::buildBlockComplex(mesh, complexOptions, run);
  convertComplex(result, options, run);
  return result;
}

void convertComplex(Converted& result, const bsv::ConversionOptions& options, const bsv::Execution& run)
{
  result.points.clear();
  result.rules.clear();
  result.volumes.clear();
  std::vector<bsv::ControlNetStorage> nets;
  for (const auto& knots : bsv::conversionKnots(result.complex, options))
  {
    bsv::BSplineVolume volume;
    volume.knots = knots;
    std::size_t count = 1;
    for (int d = 0; d < 3; ++d)
    {
      count *= volume.count(d);
    }
    // Points that nobody writes would stay NaN, rules out of range.
    result.points.emplace_back(3 * count, std::numeric_limits<double>::quiet_NaN());
    result.rules.emplace_back(count, std::uint8_t(255));
    result.volumes.push_back(volume);
  }
  for (std::size_t b = 0; b < result.volumes.size(); ++b)
  {
    result.volumes[b].points = result.points[b].data();
    nets.push_back({ result.points[b].data(), result.rules[b].data() });
  }
  result.report = bsv::convertToBSplineVolume(result.complex, options, nets, run);
}

bsv::Execution twoThreads()
{
  bsv::Execution run;
  run.parallelFor = [](Index count, Index, const bsv::Execution::Body& body) {
    const Index grain = std::max<Index>(1, count / 7);
    const auto work = [&](Index first) {
      for (Index begin = first * grain; begin < count; begin += 2 * grain)
      {
        body(begin, std::min(begin + grain, count));
      }
    };
    std::thread other(work, 1);
    work(0);
    other.join();
  };
  return run;
}

namespace
{

bool isSmoothRule(bsv::ControlPointRule rule)
{
  switch (rule)
  {
    case bsv::ControlPointRule::Copied:
    case bsv::ControlPointRule::Regular:
    case bsv::ControlPointRule::Boundary:
    case bsv::ControlPointRule::Symmetry:
    case bsv::ControlPointRule::Body:
    case bsv::ControlPointRule::WallLayer:
      return true;
    default:
      return false;
  }
}

} // namespace

Jumps interfaceJumps(const Converted& converted)
{
  Jumps jumps;
  const double eps = std::numeric_limits<double>::epsilon();
  for (const bsv::ComplexFace& face : converted.complex.faces)
  {
    if (face.boundary())
    {
      continue;
    }
    const bsv::FaceUse a = face.uses[0];
    const bsv::FaceUse b = face.uses[1];
    const bsv::BSplineVolume& va = converted.volumes[a.block];
    const bsv::BSplineVolume& vb = converted.volumes[b.block];
    const int sa = bsv::faceAxis(a.face, 0), ta = bsv::faceAxis(a.face, 1), na = bsv::faceDirection(a.face);
    const int sb = bsv::faceAxis(b.face, 0), tb = bsv::faceAxis(b.face, 1), nb = bsv::faceDirection(b.face);
    const int ns = va.count(sa), nt = va.count(ta);
    const std::array<int, 3> transform = bsv::cgnsTransform(a.face, b.face, face.orientation);

    const auto netPoint = [&](const bsv::BSplineVolume& v, int blockFace, int s, int t, int depth) {
      Ijk p;
      p[bsv::faceAxis(blockFace, 0)] = s;
      p[bsv::faceAxis(blockFace, 1)] = t;
      const int n = bsv::faceDirection(blockFace);
      p[n] = bsv::faceSide(blockFace) ? v.count(n) - 1 - depth : depth;
      return p;
    };
    for (int t = 0; t < nt; ++t)
    {
      for (int s = 0; s < ns; ++s)
      {
        const auto st = bsv::mapFacePoint(face.orientation, s, t, ns - 1, nt - 1);
        const Vec3 x = converted.controlPoint(a.block, netPoint(va, a.face, s, t, 0));
        const Vec3 y = converted.controlPoint(b.block, netPoint(vb, b.face, st[0], st[1], 0));
        jumps.openControlPoints += std::memcmp(x.data(), y.data(), sizeof(double) * 3) != 0 ? 1 : 0;
      }
    }

    for (const int knotT : bsv::nonEmptySpans(3, va.knots[ta]))
    {
      for (const int knotS : bsv::nonEmptySpans(3, va.knots[sa]))
      {
        const int spanS = knotS - 3, spanT = knotT - 3;
        bool regular = true;
        double size = 0.0;
        for (int t = spanT; t < spanT + 4; ++t)
        {
          for (int s = spanS; s < spanS + 4; ++s)
          {
            const auto st = bsv::mapFacePoint(face.orientation, s, t, ns - 1, nt - 1);
            for (int depth = 0; depth < 3; ++depth)
            {
              const Ijk pa = netPoint(va, a.face, s, t, depth);
              const Ijk pb = netPoint(vb, b.face, st[0], st[1], depth);
              regular =
                regular && isSmoothRule(converted.rule(a.block, pa)) && isSmoothRule(converted.rule(b.block, pb));
              size = std::max({ size, converted.controlPoint(a.block, pa).cwiseAbs().maxCoeff(),
                converted.controlPoint(b.block, pb).cwiseAbs().maxCoeff() });
            }
          }
        }
        for (const double ft : { 0.0, 0.375 })
        {
          for (const double fs : { 0.0, 0.625 })
          {
            ++jumps.points;
            if (!regular)
            {
              continue;
            }
            ++jumps.regular;
            const auto within = [](const std::vector<double>& knots, int span, double part) {
              return knots[span] + part * (knots[span + 1] - knots[span]);
            };
            const double s = within(va.knots[sa], knotS, fs), t = within(va.knots[ta], knotT, ft);
            Vec3 ua, ub;
            ua[sa] = s;
            ua[ta] = t;
            ua[na] = bsv::faceSide(a.face) ? va.knots[na].back() : 0;
            double u = bsv::swapsAxes(face.orientation) ? t : s;
            double v = bsv::swapsAxes(face.orientation) ? s : t;
            u = (face.orientation & 2) ? vb.knots[sb].back() - u : u;
            v = (face.orientation & 4) ? vb.knots[tb].back() - v : v;
            ub[sb] = u;
            ub[tb] = v;
            ub[nb] = bsv::faceSide(b.face) ? vb.knots[nb].back() : 0;
            for (int dk = 0; dk <= 2; ++dk)
            {
              for (int dj = 0; dj + dk <= 2; ++dj)
              {
                for (int di = 0; di + dj + dk <= 2; ++di)
                {
                  const std::array<int, 3> da{ di, dj, dk };
                  std::array<int, 3> db{};
                  double sign = 1.0;
                  for (int d = 0; d < 3; ++d)
                  {
                    db[std::abs(transform[d]) - 1] = da[d];
                    sign *= transform[d] < 0 && da[d] % 2 == 1 ? -1.0 : 1.0;
                  }
                  const Vec3 x = bsv::evaluate(va, ua, da);
                  const Vec3 y = bsv::evaluate(vb, ub, db);
                  const double jump = (x - sign * y).norm();
                  const double allowed = 1e-12 * std::max(x.norm(), y.norm()) + 64.0 * eps * size;
                  double& worst = jumps.worst[di + dj + dk];
                  if (jump > 0.0)
                  {
                    worst = std::max(worst, jump / allowed);
                  }
                }
              }
            }
          }
        }
      }
    }
  }
  return jumps;
}

ProvenSpans provenValid(const Converted& converted, const std::function<bool(int, const Ijk&)>& consider)
{
  ProvenSpans result;
  for (int b = 0; b < static_cast<int>(converted.volumes.size()); ++b)
  {
    bsv::BSplineVolume volume = converted.volumes[b];
    std::vector<double> points = converted.points[b];
    if (converted.complex.blocks[b].leftHanded)
    {
      for (std::size_t i = 0; i < points.size(); i += 3)
      {
        points[i] = -points[i];
      }
    }
    volume.points = points.data();
    Ijk n;
    for (int d = 0; d < 3; ++d)
    {
      n[d] = static_cast<int>(bsv::nonEmptySpans(3, volume.knots[d]).size());
    }
    std::vector<unsigned char> validity(std::size_t(n[0]) * n[1] * n[2]);
    bsv::JacobianArrays arrays;
    arrays.validity = validity.data();
    bsv::jacobianBounds(volume, "block " + std::to_string(b), {}, arrays);
    for (int s = 0; s < static_cast<int>(validity.size()); ++s)
    {
      if (consider(b, { s % n[0], s / n[0] % n[1], s / n[0] / n[1] }))
      {
        const bool valid = validity[s] == static_cast<unsigned char>(bsv::Validity::Valid);
        (valid ? result.valid : result.others) += 1;
      }
    }
  }
  return result;
}

std::vector<std::array<double, 4>> canonicalNet(const Converted& converted)
{
  std::vector<std::array<double, 4>> net;
  for (std::size_t b = 0; b < converted.points.size(); ++b)
  {
    for (std::size_t i = 0; i < converted.rules[b].size(); ++i)
    {
      const double* x = converted.points[b].data() + 3 * i;
      net.push_back({ x[0], x[1], x[2], static_cast<double>(converted.rules[b][i]) });
    }
  }
  std::sort(net.begin(), net.end());
  return net;
}

} // namespace conversioncases

// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/Gluing.h"

#include "Complex/CoverCheck.h"
#include "Complex/DeclaredContacts.h"
#include "Complex/PointClasses.h"
#include "Complex/WholeFaces.h"

namespace bsv
{

namespace
{

/// Runs the passes in their order.
class Gluer : public GluingPass
{
public:
  using GluingPass::GluingPass;

  void glue()
  {
    DeclaredContacts{ *this }();
    this->Run.report(0.2);
    if (this->Options.findInterfaces)
    {
      WholeFaces{ *this }();
    }
    this->Run.report(0.4);
    if (this->Options.findInterfaces)
    {
      this->search();
    }
    this->Result.close();
    this->Run.report(1.0);
  }

private:
  /// Finds what the undecided quadrilaterals meet; those that meet nothing stay undecided.
  void search()
  {
    const std::vector<Index> known = this->alone()
      ? this->undecided()
      : fetchNearQuads(this->Part, this->Surface, this->Result, this->Options.matchTolerance, this->Run);
    if (!this->Ranks.any(!known.empty()))
    {
      return;
    }
    PointClasses classes(*this);
    const Contacts before = this->Result;
    std::vector<Index> single;
    const auto pair = [&] {
      classes.pairQuads(known);
      shareContacts(this->Result, before, known, this->Surface, this->Part, this->Ranks);
      single = this->undecided(known);
    };
    classes.mergeEqualPoints(known);
    this->Ranks.nextStep();
    pair();
    this->Run.report(0.6);
    const bool merged = classes.mergeNearPoints(known, single);
    if (this->Ranks.any(merged))
    {
      this->Result = before;
      pair();
    }
    this->Run.report(0.8);
    CoverCheck{ *this, classes }(single);
  }

  std::vector<Index> undecided() const
  {
    std::vector<Index> quads;
    for (int block = 0; block < this->Surface.blockCount(); ++block)
    {
      for (int face = 0; face < 6; ++face)
      {
        appendUndecided(this->Surface, this->Result, block, face, nullptr, quads);
      }
    }
    return quads;
  }

  /// Those of a list.
  std::vector<Index> undecided(const std::vector<Index>& quads) const
  {
    std::vector<Index> result;
    QuadAt at;
    for (Index quad : quads)
    {
      at = this->Surface.quadAt(quad, at.block);
      if (this->Result.undecided(at))
      {
        result.push_back(quad);
      }
    }
    return result;
  }
};

} // namespace

Contacts glue(PartialMesh& mesh, const SurfaceNumbering& surface, const std::vector<bool>& leftHanded,
  const BlockComplexOptions& options, const Execution& run)
{
  Contacts result(surface);
  Gluer(mesh, surface, leftHanded, options, run, result).glue();
  return result;
}

} // namespace bsv

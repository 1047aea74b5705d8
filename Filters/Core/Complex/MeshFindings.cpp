// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/MeshFindings.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace bsv
{

const std::vector<std::string>& meshFindingNames()
{
  static const std::vector<std::string> names{ "None", "NearMiss", "LoosePoint", "Overlap", "NarrowGap",
    "InnerBoundary", "Component" };
  return names;
}

MeshFindings::MeshFindings(const OuterSurface& surface)
  : Surface(surface)
{
  this->Diagnosis.findingOfQuad.resize(surface.complex().faces.size());
}

int MeshFindings::add(const MeshFinding& finding)
{
  this->Diagnosis.findings.push_back(finding);
  return static_cast<int>(this->Diagnosis.findings.size()) - 1;
}

void MeshFindings::mark(Index quad, int number)
{
  const OuterQuad at = this->Surface.quadAt(quad);
  std::vector<int>& findings = this->Diagnosis.findingOfQuad[at.face];
  findings.resize(this->Surface.firstQuad(at.face + 1) - this->Surface.firstQuad(at.face), -1);
  int& known = findings[quad - this->Surface.firstQuad(at.face)];
  if (known < 0 || this->Diagnosis.findings[number].kind < this->Diagnosis.findings[known].kind)
  {
    known = number;
  }
}

bool MeshFindings::isSuspicious(Index quad) const
{
  const int face = this->Surface.quadAt(quad).face;
  const std::vector<int>& findings = this->Diagnosis.findingOfQuad[face];
  const int number = findings.empty() ? -1 : findings[quad - this->Surface.firstQuad(face)];
  return number >= 0 && this->Diagnosis.findings[number].suspicious();
}

MeshDiagnosis MeshFindings::sorted()
{
  std::vector<MeshFinding>& findings = this->Diagnosis.findings;
  std::vector<int> order(findings.size());
  for (std::size_t n = 0; n < order.size(); ++n)
  {
    order[n] = static_cast<int>(n);
  }
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const MeshFinding &x = findings[a], &y = findings[b];
    return std::tie(x.kind, x.blocks, x.faces, a) < std::tie(y.kind, y.blocks, y.faces, b);
  });
  std::vector<MeshFinding> sorted;
  std::vector<int> place(findings.size());
  for (const int n : order)
  {
    place[n] = static_cast<int>(sorted.size());
    sorted.push_back(findings[n]);
  }
  findings = std::move(sorted);
  for (std::vector<int>& face : this->Diagnosis.findingOfQuad)
  {
    for (int& number : face)
    {
      number = number < 0 ? number : place[number];
    }
  }
  return std::move(this->Diagnosis);
}

} // namespace bsv

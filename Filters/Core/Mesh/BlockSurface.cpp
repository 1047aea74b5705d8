// SPDX-License-Identifier: BSD-3-Clause
#include "Mesh/BlockSurface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <charconv>

namespace bsv
{

namespace
{

/// Points around one layer of a block between its faces k = 0 and k = K.
Index ringPoints(const Ijk& cells)
{
  return 2 * (Index(cells[0]) + cells[1]);
}

Index layerPoints(const Ijk& cells)
{
  return (Index(cells[0]) + 1) * (cells[1] + 1);
}

} // namespace

SurfaceNumbering::SurfaceNumbering(const BlockMesh& mesh, const std::vector<char>* numbered)
{
  Index quads = 0;
  Index points = 0;
  for (const MeshBlock& block : mesh.blocks)
  {
    const Ijk& n = block.points.counts();
    const Ijk cells{ n[0] - 1, n[1] - 1, n[2] - 1 };
    this->Cells.push_back(cells);
    this->QuadStart.push_back(quads);
    this->PointStart.push_back(points);
    const bool counts = !numbered || (*numbered)[this->Cells.size() - 1];
    for (int face = 0; face < 6; ++face)
    {
      this->FaceStart.push_back(quads);
      quads += counts ? Index(cells[faceAxis(face, 0)]) * cells[faceAxis(face, 1)] : 0;
    }
    points += !counts ? 0 : 2 * layerPoints(cells) + (cells[2] - 1) * ringPoints(cells);
  }
  this->QuadStart.push_back(quads);
  this->PointStart.push_back(points);
}

QuadAt SurfaceNumbering::quadAt(Index quad, int hint) const
{
  if (quad < this->QuadStart[hint] || quad >= this->QuadStart[hint + 1])
  {
    hint = static_cast<int>(
      std::upper_bound(this->QuadStart.begin(), this->QuadStart.end(), quad) - this->QuadStart.begin() - 1);
  }
  int face = 5;
  while (quad < this->FaceStart[6 * hint + face])
  {
    --face;
  }
  const Index local = quad - this->FaceStart[6 * hint + face];
  const int n = this->faceCells(hint, face, 0);
  return { hint, face, static_cast<int>(local % n), static_cast<int>(local / n) };
}

Index SurfaceNumbering::point(int block, const Ijk& p) const
{
  const Ijk& n = this->Cells[block];
  const Index start = this->PointStart[block];
  const Index inLayer = p[0] + Index(n[0] + 1) * p[1];
  if (p[2] == 0)
  {
    return start + inLayer;
  }
  const Index ring = start + layerPoints(n) + (p[2] - 1) * ringPoints(n);
  if (p[2] == n[2])
  {
    return ring + inLayer;
  }
  if (p[1] == 0)
  {
    return ring + p[0];
  }
  if (p[1] == n[1])
  {
    return ring + n[0] + 1 + 2 * Index(n[1] - 1) + p[0];
  }
  return ring + n[0] + 1 + 2 * Index(p[1] - 1) + (p[0] == 0 ? 0 : 1);
}

int SurfaceNumbering::blockOfPoint(Index point) const
{
  return static_cast<int>(
    std::upper_bound(this->PointStart.begin(), this->PointStart.end(), point) - this->PointStart.begin() - 1);
}

Ijk SurfaceNumbering::pointAt(int block, Index point) const
{
  const Ijk& n = this->Cells[block];
  const int row = n[0] + 1;
  Index local = point - this->PointStart[block];
  int k = 0;
  if (local >= layerPoints(n))
  {
    local -= layerPoints(n);
    k = static_cast<int>(std::min<Index>(local / ringPoints(n), n[2] - 1));
    local -= k * ringPoints(n);
    ++k;
  }
  if (k == 0 || k == n[2])
  {
    return { static_cast<int>(local % row), static_cast<int>(local / row), k };
  }
  if (local < row)
  {
    return { static_cast<int>(local), 0, k };
  }
  local -= row;
  if (local < 2 * Index(n[1] - 1))
  {
    return { local % 2 == 0 ? 0 : n[0], static_cast<int>(local / 2) + 1, k };
  }
  return { static_cast<int>(local - 2 * Index(n[1] - 1)), n[1], k };
}

Ijk SurfaceNumbering::corner(const QuadAt& at, int cs, int ct) const
{
  Ijk p{};
  p[faceDirection(at.face)] = faceSide(at.face) ? this->Cells[at.block][faceDirection(at.face)] : 0;
  p[faceAxis(at.face, 0)] = at.s + cs;
  p[faceAxis(at.face, 1)] = at.t + ct;
  return p;
}

std::array<Index, 4> SurfaceNumbering::corners(const QuadAt& at) const
{
  return { this->point(at.block, this->corner(at, 0, 0)), this->point(at.block, this->corner(at, 1, 0)),
    this->point(at.block, this->corner(at, 0, 1)), this->point(at.block, this->corner(at, 1, 1)) };
}

QuadEdge SurfaceNumbering::across(const QuadEdge& edge) const
{
  const QuadAt& quad = edge.quad;
  const int alongDirection = faceAxis(quad.face, edge.axis);
  const int otherDirection = faceAxis(quad.face, 1 - edge.axis);
  const int along = edge.axis == 0 ? quad.s : quad.t;
  const int other = edge.axis == 0 ? quad.t : quad.s;
  const int line = other + edge.side;
  QuadEdge result = edge;
  if (line > 0 && line < this->Cells[quad.block][otherDirection])
  {
    (edge.axis == 0 ? result.quad.t : result.quad.s) = edge.side ? line : line - 1;
    result.side = 1 - edge.side;
    return result;
  }
  const int face = 2 * otherDirection + (line == 0 ? 0 : 1);
  const int normal = faceDirection(quad.face);
  result.axis = faceAxis(face, 0) == alongDirection ? 0 : 1;
  result.side = faceSide(quad.face);
  const int atNormal = faceSide(quad.face) ? this->Cells[quad.block][normal] - 1 : 0;
  result.quad = { quad.block, face, result.axis == 0 ? along : atNormal, result.axis == 0 ? atNormal : along };
  return result;
}

Contacts::Contacts(const SurfaceNumbering& surface)
  : Surface(&surface)
  , Faces(6 * static_cast<std::size_t>(surface.blockCount()))
{
}

void Contacts::set(const QuadAt& at, Index link)
{
  if (this->link(at) == link)
  {
    return;
  }
  Face& face = this->Faces[6 * std::size_t(at.block) + at.face];
  if (face.each.empty())
  {
    const int ns = this->Surface->faceCells(at.block, at.face, 0);
    const int nt = this->Surface->faceCells(at.block, at.face, 1);
    std::vector<Index> each;
    each.reserve(Index(ns) * nt);
    for (int t = 0; t < nt; ++t)
    {
      for (int s = 0; s < ns; ++s)
      {
        each.push_back(this->link({ at.block, at.face, s, t }));
      }
    }
    face.each = std::move(each);
  }
  face.each[at.s + this->width(at) * at.t] = link;
}

void Contacts::setWhole(int block, int face, Index first, Index stepS, Index stepT)
{
  Face& whole = this->Faces[6 * std::size_t(block) + face];
  std::vector<Index>().swap(whole.each);
  whole.first = first;
  whole.stepS = stepS;
  whole.stepT = stepT;
}

bool Contacts::undecided(int block, int face) const
{
  const Face& whole = this->Faces[6 * std::size_t(block) + face];
  return whole.each.empty()
    ? whole.first == Undecided
    : std::all_of(whole.each.begin(), whole.each.end(), [](Index link) { return link == Undecided; });
}

std::array<Index, 2> Contacts::steps(int orientation, int blockB, int b) const
{
  // Along the axes of B, in numbers of quadrilaterals; the orientation code is in the lowest three bits of a link.
  const Index alongS = Index(8) * (orientation & 2 ? -1 : 1);
  const Index alongT = Index(8) * (orientation & 4 ? -1 : 1) * this->Surface->faceCells(blockB, b, 0);
  return swapsAxes(orientation) ? std::array<Index, 2>{ alongT, alongS } : std::array<Index, 2>{ alongS, alongT };
}

void Contacts::setContact(const Interface& contact)
{
  const int ns = this->Surface->faceCells(contact.blockA, contact.faceA, 0);
  const int nt = this->Surface->faceCells(contact.blockA, contact.faceA, 1);
  const auto onB = mapFacePoint(contact.orientation, 0, 0, ns - 1, nt - 1);
  const std::array<Index, 2> stepsA = this->steps(contact.orientation, contact.blockB, contact.faceB);
  this->setWhole(contact.blockA, contact.faceA,
    this->Surface->quad({ contact.blockB, contact.faceB, onB[0], onB[1] }) << 3 | contact.orientation, stepsA[0],
    stepsA[1]);
  const int inverse = inverseOrientation(contact.orientation);
  const bool swap = swapsAxes(contact.orientation);
  const auto onA = mapFacePoint(inverse, 0, 0, (swap ? nt : ns) - 1, (swap ? ns : nt) - 1);
  const std::array<Index, 2> stepsB = this->steps(inverse, contact.blockA, contact.faceA);
  this->setWhole(contact.blockB, contact.faceB,
    this->Surface->quad({ contact.blockA, contact.faceA, onA[0], onA[1] }) << 3 | inverse, stepsB[0], stepsB[1]);
}

void Contacts::close()
{
  for (int block = 0; block < this->Surface->blockCount(); ++block)
  {
    for (int face = 0; face < 6; ++face)
    {
      Face& whole = this->Faces[6 * std::size_t(block) + face];
      whole.first = whole.first == Undecided ? Untagged : whole.first;
      std::replace(whole.each.begin(), whole.each.end(), Undecided, Untagged);
      std::array<Index, 2> steps{ 0, 0 };
      if (!whole.each.empty() && this->linear(block, face, steps))
      {
        this->setWhole(block, face, whole.each.front(), steps[0], steps[1]);
      }
    }
  }
}

bool Contacts::linear(int block, int face, std::array<Index, 2>& steps) const
{
  const int ns = this->Surface->faceCells(block, face, 0);
  const int nt = this->Surface->faceCells(block, face, 1);
  const std::vector<Index>& each = this->Faces[6 * std::size_t(block) + face].each;
  if (each.front() >= 0)
  {
    // All of one face, which the last in each direction shows.
    const int orientation = static_cast<int>(each.front() & 7);
    const QuadAt first = this->Surface->quadAt(each.front() >> 3, block);
    const auto start = mapFacePoint(orientation, 0, 0, ns - 1, nt - 1);
    const auto end = mapFacePoint(orientation, ns - 1, nt - 1, ns - 1, nt - 1);
    const int lastS = first.s + end[0] - start[0];
    const int lastT = first.t + end[1] - start[1];
    if (lastS < 0 || lastS >= this->Surface->faceCells(first.block, first.face, 0) || lastT < 0 ||
      lastT >= this->Surface->faceCells(first.block, first.face, 1))
    {
      return false;
    }
    steps = this->steps(orientation, first.block, first.face);
  }
  for (int t = 0; t < nt; ++t)
  {
    for (int s = 0; s < ns; ++s)
    {
      if (each[s + Index(ns) * t] != each.front() + s * steps[0] + t * steps[1])
      {
        return false;
      }
    }
  }
  return true;
}

QuadEdge throughContact(const SurfaceNumbering& surface, const Contacts& contacts, const QuadEdge& edge)
{
  const int orientation = contacts.orientation(edge.quad);
  const auto corner = [&](int end) {
    return edge.axis == 0 ? mapFacePoint(orientation, end, edge.side, 1, 1)
                          : mapFacePoint(orientation, edge.side, end, 1, 1);
  };
  const auto first = corner(0);
  QuadEdge result;
  result.quad = surface.quadAt(contacts.partner(edge.quad), edge.quad.block);
  result.axis = first[0] != corner(1)[0] ? 0 : 1;
  result.side = first[1 - result.axis];
  return result;
}

Vec3 outwardNormal(const BlockMesh& mesh, const SurfaceNumbering& surface, const QuadAt& quad, bool leftHanded)
{
  const GridView& points = mesh.blocks[quad.block].points;
  const Vec3 a = points(surface.corner(quad, 1, 1)) - points(surface.corner(quad, 0, 0));
  const Vec3 b = points(surface.corner(quad, 0, 1)) - points(surface.corner(quad, 1, 0));
  const Vec3 normal = a.cross(b);
  // In a right-handed block the face axes of directions 0 and 2 span the positive normal, those of direction 1 the
  // negative one.
  const bool inwards = (faceSide(quad.face) == 0) != (faceDirection(quad.face) == 1);
  return inwards != leftHanded ? Vec3(-normal) : normal;
}

std::string blockLabel(const BlockMesh& mesh, int block)
{
  const std::string& name = mesh.blocks[block].name;
  return "block " + std::to_string(block) + (name.empty() ? "" : " \"" + name + "\"");
}

std::string faceLabel(int face)
{
  const char* const labels[6] = { "i=0", "i=I", "j=0", "j=J", "k=0", "k=K" };
  return std::string("face ") + std::to_string(face) + " (" + labels[face] + ")";
}

std::string text(double value)
{
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 9).ptr;
  return std::string(buffer, end);
}

std::string text(const Vec3& x)
{
  return "(" + text(x[0]) + ", " + text(x[1]) + ", " + text(x[2]) + ")";
}

std::string text(const Ijk& p)
{
  return "(" + std::to_string(p[0]) + ", " + std::to_string(p[1]) + ", " + std::to_string(p[2]) + ")";
}

} // namespace bsv

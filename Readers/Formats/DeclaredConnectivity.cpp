// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/DeclaredConnectivity.h"

#include "Base/UTF8.h"

#include <algorithm>
#include <cctype>

namespace bsv
{

namespace
{

/// Items that a sentence names.
constexpr std::size_t MaxItems = 5;

/// Marks of a quadrilateral that belongs to no boundary.
constexpr int Free = -1;
constexpr int InContact = -2;

/// The quadrilaterals of one block face: a tag, Free or InContact.
class FaceMarks
{
public:
  explicit FaceMarks(const std::array<int, 2>& cells)
    : Cells(cells)
    , Marks(static_cast<std::size_t>(cells[0]) * cells[1], Free)
  {
  }

  int& at(int s, int t) { return this->Marks[static_cast<std::size_t>(t) * this->Cells[0] + s]; }

  template <typename Visit>
  void forEach(const FaceRange& range, const Visit& visit)
  {
    for (int t = range.lo[1]; t < range.hi[1]; ++t)
    {
      for (int s = range.lo[0]; s < range.hi[0]; ++s)
      {
        visit(s, t, this->at(s, t));
      }
    }
  }

private:
  std::array<int, 2> Cells;
  std::vector<int> Marks;
};

std::string faceText(const BlockMesh& mesh, int block, int face)
{
  return "block '" + mesh.blocks[block].name + "', face " + "ijk"[faceDirection(face)] +
    (faceSide(face) ? " max" : " min");
}

bool isKnown(const std::string& type)
{
  return type != UnknownBoundaryType;
}

} // namespace

void Leftovers::add(const std::string& reason, const std::string& item)
{
  const auto found = std::find(this->Reasons.begin(), this->Reasons.end(), reason);
  const std::size_t at = static_cast<std::size_t>(found - this->Reasons.begin());
  if (found == this->Reasons.end())
  {
    this->Reasons.push_back(reason);
    this->Items.emplace_back();
  }
  this->Items[at].push_back(validUTF8(item));
}

std::vector<std::string> Leftovers::sentences() const
{
  std::vector<std::string> sentences = this->Sentences;
  for (std::size_t r = 0; r < this->Reasons.size(); ++r)
  {
    const std::vector<std::string>& items = this->Items[r];
    std::string text = this->Reasons[r] + ": ";
    for (std::size_t i = 0; i < std::min(items.size(), MaxItems); ++i)
    {
      text += (i == 0 ? "" : "; ") + items[i];
    }
    sentences.push_back(
      items.size() > MaxItems ? text + "; and " + std::to_string(items.size() - MaxItems) + " more" : text);
  }
  return sentences;
}

std::string boundaryTypeOfName(const std::string& name)
{
  std::string word;
  for (const char c : name)
  {
    word += c == ' ' || c == '-' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  const auto starts = [&](const char* text) { return word.rfind(text, 0) == 0; };
  static const std::pair<const char*, const char*> types[] = { { "viscous", "BCWallViscous" },
    { "no_slip", "BCWallViscous" }, { "noslip", "BCWallViscous" }, { "tangency", "BCWallInviscid" },
    { "inviscid", "BCWallInviscid" }, { "slip_wall", "BCWallInviscid" }, { "wall", "BCWall" },
    { "sym", "BCSymmetryPlane" }, { "farfield", "BCFarfield" }, { "far_field", "BCFarfield" },
    { "freestream", "BCFarfield" }, { "inflow", "BCInflow" }, { "inlet", "BCInflow" }, { "outflow", "BCOutflow" },
    { "outlet", "BCOutflow" }, { "extrapolat", "BCExtrapolate" }, { "pole_dir", "BCDegenerateLine" },
    { "collapsed", "BCDegenerateLine" },
    // Numbers of FUN3D.
    { "3000", "BCWallInviscid" }, { "4000", "BCWallViscous" }, { "41", "BCWallViscous" }, { "5000", "BCFarfield" },
    { "5025", "BCFarfield" }, { "5050", "BCFarfield" }, { "666", "BCSymmetryPlane" } };
  for (const auto& [start, type] : types)
  {
    if (starts(start))
    {
      return type;
    }
  }
  return UnknownBoundaryType;
}

void DeclaredConnectivity::addContact(const Interface& contact, const std::string& where)
{
  if (this->Known.insert(orderedContact(contact)).second)
  {
    this->Contacts.push_back({ contact, where });
  }
}

int DeclaredConnectivity::tagOf(const std::string& name, const std::string& type)
{
  std::vector<int>& tags = this->TagsOfName[name];
  for (const int tag : tags)
  {
    if (!isKnown(type) || !isKnown(this->Types[tag]) || type == this->Types[tag])
    {
      this->Types[tag] = isKnown(type) ? type : this->Types[tag];
      return tag;
    }
  }
  tags.push_back(static_cast<int>(this->Names.size()));
  this->Names.push_back(tags.size() == 1 ? name : name + " (" + type + ")");
  this->Types.push_back(type);
  return tags.back();
}

void DeclaredConnectivity::addBoundary(
  const DirectedRange& range, const std::string& name, const std::string& type, const std::string& where)
{
  const int tag = this->tagOf(validUTF8(name), type);
  this->Boundaries.push_back({ range, tag, where });
}

void DeclaredConnectivity::finish(BlockMesh& mesh, Leftovers& left) const
{
  mesh.boundaryNames = this->Names;
  mesh.boundaryTypes =
    std::any_of(this->Types.begin(), this->Types.end(), isKnown) ? this->Types : std::vector<std::string>();

  // Faces with more than one item, on which they may contradict each other.
  std::map<std::pair<int, int>, int> items;
  for (const DeclaredContact& declared : this->Contacts)
  {
    mesh.interfaces.push_back(declared.contact);
    ++items[{ declared.contact.blockA, declared.contact.faceA }];
    ++items[{ declared.contact.blockB, declared.contact.faceB }];
  }
  for (const Boundary& boundary : this->Boundaries)
  {
    ++items[{ boundary.range.block, boundary.range.face }];
  }
  std::map<std::pair<int, int>, FaceMarks> marks;
  const auto cells = [&](int block, int face) {
    const Ijk& counts = mesh.blocks[block].points.counts();
    return std::array<int, 2>{ counts[faceAxis(face, 0)] - 1, counts[faceAxis(face, 1)] - 1 };
  };
  const auto marksOf = [&](int block, int face) -> FaceMarks* {
    const std::pair<int, int> at{ block, face };
    return items[at] < 2 ? nullptr : &marks.try_emplace(at, cells(block, face)).first->second;
  };
  const auto takeContact = [&](int block, int face, const FaceRange& range) {
    if (FaceMarks* face_ = marksOf(block, face))
    {
      face_->forEach(range, [](int, int, int& mark) { mark = InContact; });
    }
  };
  for (const Interface& contact : mesh.interfaces)
  {
    takeContact(contact.blockA, contact.faceA, contact.rangeA);
    takeContact(contact.blockB, contact.faceB, contact.rangeB());
  }

  for (const Boundary& boundary : this->Boundaries)
  {
    const int block = boundary.range.block;
    const int face = boundary.range.face;
    const FaceRange range = boundary.range.range();
    FaceMarks* taken = marksOf(block, face);
    Index inContact = 0;
    Index inOther = 0;
    Index again = 0;
    int other = Free;
    const std::array<int, 2> size = cells(block, face);
    std::vector<char> open;
    if (taken)
    {
      open.assign(static_cast<std::size_t>(size[0]) * size[1], 0);
      taken->forEach(range, [&](int s, int t, int& mark) {
        inContact += mark == InContact;
        again += mark == boundary.tag;
        if (mark >= 0 && mark != boundary.tag)
        {
          ++inOther;
          other = mark;
        }
        if (mark == Free)
        {
          mark = boundary.tag;
          open[static_cast<std::size_t>(t) * size[0] + s] = 1;
        }
      });
    }
    const Index all = Index(range.hi[0] - range.lo[0]) * (range.hi[1] - range.lo[1]);
    const auto item = [&](Index count) {
      return boundary.where + ": '" + this->Names[boundary.tag] + "' on " + faceText(mesh, block, face) +
        (count == all ? "" : ", " + std::to_string(count) + " of its " + std::to_string(all) + " quadrilaterals");
    };
    if (inContact > 0)
    {
      left.add("boundaries left out where the mesh goes on across an interface", item(inContact));
    }
    if (inOther > 0)
    {
      left.add("boundaries left out where another one is given already",
        item(inOther) + " ('" + this->Names[other] + "' is there)");
    }
    if (inContact + inOther + again == 0)
    {
      mesh.boundaries.push_back({ block, face, range, boundary.tag });
      continue;
    }
    for (const FaceRange& part : cutIntoRectangles(open, size[0], size[1]))
    {
      mesh.boundaries.push_back({ block, face, part, boundary.tag });
    }
  }
}

std::vector<FaceRange> cutIntoRectangles(std::vector<char>& marked, int ns, int nt)
{
  std::vector<FaceRange> rectangles;
  const auto row = [&](int s, int t) { return marked.begin() + static_cast<std::ptrdiff_t>(t) * ns + s; };
  for (int t = 0; t < nt; ++t)
  {
    for (int s = 0; s < ns; ++s)
    {
      if (!*row(s, t))
      {
        continue;
      }
      const auto length = std::find(row(s, t), row(ns, t), 0) - row(s, t);
      int end = t;
      while (end < nt && std::all_of(row(s, end), row(s, end) + length, [](char c) { return c != 0; }))
      {
        std::fill(row(s, end), row(s, end) + length, 0);
        ++end;
      }
      rectangles.push_back({ { s, t }, { s + static_cast<int>(length), end } });
    }
  }
  return rectangles;
}

} // namespace bsv

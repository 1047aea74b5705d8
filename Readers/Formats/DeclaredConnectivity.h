// SPDX-License-Identifier: BSD-3-Clause
/// @file DeclaredConnectivity.h
/// Contacts and boundaries as files declare them, of which a mesh needs none: what contradicts the rest is left out
/// with a warning. Contacts win over boundaries, and the boundary that comes first over later ones.
#pragma once

#include "Formats/FaceContact.h"
#include "Mesh/BlockMesh.h"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace bsv
{

/// Says of many items of one kind what happened to them, in one sentence that names the first ones.
class Leftovers
{
public:
  /// @param reason what is the matter, the same text for all items of the kind.
  void add(const std::string& reason, const std::string& item);
  /// Things that happened once.
  void say(const std::string& sentence) { this->Sentences.push_back(sentence); }
  /// One sentence per reason.
  std::vector<std::string> sentences() const;

private:
  std::vector<std::string> Reasons;
  std::vector<std::vector<std::string>> Items;
  std::vector<std::string> Sentences;
};

/// The type that says nothing.
constexpr const char* UnknownBoundaryType = "BCTypeUserDefined";

/// What solvers and mesh generators call a boundary, as a type of CGNS; UnknownBoundaryType if the name is none of
/// theirs. Case, blanks and the sort of dash do not matter.
std::string boundaryTypeOfName(const std::string& name);

class DeclaredConnectivity
{
public:
  /// A contact, which may be declared from both sides. @param where for messages: "mesh.nmf, line 7".
  void addContact(const Interface& contact, const std::string& where);

  /// A rectangle of a face. Boundaries of one name and different types get names of their own.
  void addBoundary(
    const DirectedRange& range, const std::string& name, const std::string& type, const std::string& where);

  /// Those to be checked with checkContacts(), each once.
  const std::vector<DeclaredContact>& contacts() const { return this->Contacts; }

  /// Puts all into `mesh`, whose blocks are known; says what is left out.
  void finish(BlockMesh& mesh, Leftovers& left) const;

private:
  struct Boundary
  {
    DirectedRange range;
    int tag;
    std::string where;
  };
  int tagOf(const std::string& name, const std::string& type);

  std::vector<DeclaredContact> Contacts;
  std::set<Interface> Known;
  std::vector<Boundary> Boundaries;
  std::vector<std::string> Names;
  std::vector<std::string> Types;
  /// Tags of a name as it stands in the file.
  std::map<std::string, std::vector<int>> TagsOfName;
};

/// Cuts the marked quadrilaterals of a face, `ns` x `nt` of them, into rectangles: as long as possible, then as high.
/// Unmarks them. @return ranges of mesh points
std::vector<FaceRange> cutIntoRectangles(std::vector<char>& marked, int ns, int nt);

} // namespace bsv

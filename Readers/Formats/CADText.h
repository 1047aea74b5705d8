// SPDX-License-Identifier: BSD-3-Clause
/// @file CADText.h
/// A look at the text of IGES, STEP and BREP files before OpenCASCADE reads them: it takes what is left of a damaged
/// file without a word, and refuses one whose notes and colours it does not understand.
///
/// Sources: IGES 5.3, section 2.2 (cards); ISO 10303-21 (STEP); OpenCASCADE's description of the BREP format.
#pragma once

#include "Base/Types.h"

#include <map>
#include <string>
#include <unordered_set>

namespace bsv
{

/// "STEP", "IGES" or "BREP", by how the text begins: behind a byte order mark, blank lines and comments, in capitals or
/// not; empty for others. @throws Error without a file name for IGES files in compressed or binary form.
std::string formatOfCADText(const std::string& start);

/// The text as OpenCASCADE reads it: without byte order mark, IGES in lines of cards that begin at once, STEP in
/// capitals and without tabs outside of strings.
std::string plainCADText(const std::string& text, const std::string& format);

/// @throws Error naming file and line if the cards are not complete and in order.
void checkIGESText(const std::string& text, const std::string& fileName);

/// What the text of a STEP file says of its entities.
struct STEPEntities
{
  /// Numbers of the entities that the shape and place of faces depend on.
  std::unordered_set<long> needed;
  /// Keywords of the other entities that refer to an entity that does not exist, with their numbers.
  std::map<std::string, int> broken;
};

/// @throws Error naming file and line if the end is missing, a string does not end, or an entity that faces depend on
/// refers to one that does not exist.
STEPEntities checkSTEPText(const std::string& text, const std::string& fileName);

/// @throws Error naming file and line if a section or the end is missing.
void checkBREPText(const std::string& text, const std::string& fileName);

} // namespace bsv

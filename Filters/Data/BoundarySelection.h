// SPDX-License-Identifier: BSD-3-Clause
/// @file BoundarySelection.h
/// The boundaries of a mesh by their names, each switched on or off: what a panel shows as check boxes. Patterns
/// (BoundaryPatterns.h) say how it begins, and hold for names that are not in the list, unless the list is complete: a
/// script that knows no check boxes lists what is on, and means that nothing else is.
#pragma once

#include "BSplineVolumeFiltersModule.h"

#include "Data/BoundaryPatterns.h"

#include "vtkDataArraySelection.h"
#include "vtkSmartPointer.h"

#include <string>
#include <vector>

class vtkAlgorithm;
class vtkDataObject;

namespace bsv
{

class Ranks;

class BSPLINEVOLUMEFILTERS_EXPORT BoundarySelection
{
public:
  /// @param owner is modified when something is switched
  explicit BoundarySelection(vtkAlgorithm* owner);

  /// Lists the boundaries of `mesh`, if its names are known. New ones are on if the patterns choose them
  /// (selectsBoundary()).
  void offer(vtkDataObject* mesh, const BoundaryPatterns& patterns, const BoundaryPatterns& defaults);

  /// Names that a complete list has, but the mesh has not: one sentence each. @param property for the message
  std::vector<std::string> unknown(const std::string& property, const std::vector<std::string>& names) const;

  /// Forgets what was switched, because the patterns changed.
  void forget();

  /// Whether a boundary is on. @param otherwise if it is not listed
  bool has(const std::string& name, bool otherwise) const;

  vtkDataArraySelection* list() const { return this->List; }

private:
  /// Whether the list was made before any mesh was known, of names that are on.
  bool isComplete() const;

  vtkSmartPointer<vtkDataArraySelection> List;
  bool Offered = false;
};

/// Whether each boundary of a volume is part of the wall: as the conversion took it (field data array `BoundaryRoles`,
/// one bsv::BoundaryRole per name) if `patterns` are the default ones and the array is there, else by isBodyBoundary().
/// Collective.
BSPLINEVOLUMEFILTERS_EXPORT std::vector<bool> wallBoundaries(vtkDataObject* volume,
  const std::vector<std::string>& names, const std::vector<std::string>& types, const BoundaryPatterns& patterns,
  const Ranks& ranks);

/// Warnings about patterns that choose no boundary, one each; none about the default ones.
BSPLINEVOLUMEFILTERS_EXPORT std::vector<std::string> uselessPatterns(const std::string& property,
  const BoundaryPatterns& patterns, const BoundaryPatterns& defaults, const std::vector<std::string>& names,
  const std::vector<std::string>& types);

} // namespace bsv

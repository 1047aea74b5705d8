// SPDX-License-Identifier: BSD-3-Clause
#include "Data/BoundarySelection.h"

#include "Ranks/Ranks.h"

#include <vtkAlgorithm.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkDataArraySelection.h>
#include <vtkDataObject.h>
#include <vtkFieldData.h>
#include <vtkStringArray.h>

#include <algorithm>

namespace bsv
{

//------------------------------------------------------------------------------
BoundarySelection::BoundarySelection(vtkAlgorithm* owner)
  : List(vtkSmartPointer<vtkDataArraySelection>::New())
{
  this->List->AddObserver(vtkCommand::ModifiedEvent, owner, &vtkAlgorithm::Modified);
}

//------------------------------------------------------------------------------
void BoundarySelection::offer(vtkDataObject* mesh, const BoundaryPatterns& patterns, const BoundaryPatterns& defaults)
{
  const auto strings = [mesh](const char* name) {
    std::vector<std::string> values;
    auto* array = mesh ? vtkStringArray::SafeDownCast(mesh->GetFieldData()->GetAbstractArray(name)) : nullptr;
    for (vtkIdType n = 0; array && n < array->GetNumberOfValues(); ++n)
    {
      values.push_back(array->GetValue(n));
    }
    return values;
  };
  const std::vector<std::string> names = strings("BoundaryNames");
  std::vector<std::string> types = strings("BoundaryTypes");
  types.resize(names.size());
  const bool complete = this->isComplete();
  for (std::size_t n = 0; n < names.size(); ++n)
  {
    // Does nothing if it is in the list, and is no modification.
    this->List->AddArray(
      names[n].c_str(), !complete && selectsBoundary(patterns, defaults, names, types, static_cast<int>(n)));
  }
  this->Offered = this->Offered || !names.empty();
}

//------------------------------------------------------------------------------
bool BoundarySelection::isComplete() const
{
  const int count = this->List->GetNumberOfArrays();
  return !this->Offered && count > 0 && this->List->GetNumberOfArraysEnabled() == count;
}

//------------------------------------------------------------------------------
std::vector<std::string> BoundarySelection::unknown(
  const std::string& property, const std::vector<std::string>& names) const
{
  std::vector<std::string> sentences;
  for (int n = 0; n < this->List->GetNumberOfArrays() && this->isComplete(); ++n)
  {
    const std::string name = this->List->GetArrayName(n);
    if (std::find(names.begin(), names.end(), name) == names.end())
    {
      sentences.push_back(property + ": '" + name + "' is no boundary of the mesh; it has " + quotedList(names));
    }
  }
  return sentences;
}

//------------------------------------------------------------------------------
void BoundarySelection::forget()
{
  this->List->RemoveAllArrays();
  this->Offered = false;
}

//------------------------------------------------------------------------------
bool BoundarySelection::has(const std::string& name, bool otherwise) const
{
  return this->List->ArrayExists(name.c_str()) ? this->List->ArrayIsEnabled(name.c_str()) != 0
                                               : otherwise && !this->isComplete();
}

//------------------------------------------------------------------------------
std::vector<bool> wallBoundaries(vtkDataObject* volume, const std::vector<std::string>& names,
  const std::vector<std::string>& types, const BoundaryPatterns& patterns, const Ranks& ranks)
{
  std::vector<int> mine;
  if (volume && patterns == defaultBodyBoundaries())
  {
    auto* roles = vtkDataArray::SafeDownCast(volume->GetFieldData()->GetAbstractArray("BoundaryRoles"));
    for (vtkIdType n = 0; roles && n < roles->GetNumberOfTuples(); ++n)
    {
      mine.push_back(static_cast<int>(roles->GetComponent(n, 0)));
    }
  }
  std::vector<bool> wall;
  for (const std::vector<int>& roles : ranks.gather(mine))
  {
    if (wall.empty() && !names.empty() && roles.size() == names.size())
    {
      std::transform(roles.begin(), roles.end(), std::back_inserter(wall), [](int role) { return role == 1; });
    }
  }
  for (std::size_t n = wall.size(); n < names.size(); ++n)
  {
    wall.push_back(isBodyBoundary(patterns, names, types, static_cast<int>(n)));
  }
  return wall;
}

//------------------------------------------------------------------------------
std::vector<std::string> uselessPatterns(const std::string& property, const BoundaryPatterns& patterns,
  const BoundaryPatterns& defaults, const std::vector<std::string>& names, const std::vector<std::string>& types)
{
  std::vector<std::string> warnings;
  for (const std::string& pattern : patterns)
  {
    bool fits = false;
    for (std::size_t tag = 0; tag < names.size(); ++tag)
    {
      fits = fits || selectsBoundary({ pattern }, defaults, names, types, static_cast<int>(tag));
    }
    if (!fits && std::find(defaults.begin(), defaults.end(), pattern) == defaults.end())
    {
      warnings.push_back(property + ": '" + pattern + "' fits no boundary of the mesh; it has " + quotedList(names));
    }
  }
  return warnings;
}

} // namespace bsv

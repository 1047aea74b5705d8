// SPDX-License-Identifier: BSD-3-Clause
/**
 * Selections in what a display draws are those of the points and cells of its input: its arrays `SourcePoint` and
 * `SourceCell` take the place of the numbers that ParaView's geometry filter gives.
 */
#ifndef sourceIds_h
#define sourceIds_h

#include "vtkCellData.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"

namespace bsv
{

inline void selectBySources(vtkPolyData* drawn)
{
  const auto rename = [](vtkDataSetAttributes* attributes, const char* from, const char* to) {
    if (vtkAbstractArray* array = attributes->GetAbstractArray(from))
    {
      auto named = vtkSmartPointer<vtkAbstractArray>::Take(array->NewInstance());
      named->DeepCopy(array);
      named->SetName(to);
      attributes->RemoveArray(from);
      attributes->AddArray(named);
    }
  };
  rename(drawn->GetPointData(), "SourcePoint", "vtkOriginalPointIds");
  rename(drawn->GetCellData(), "SourceCell", "vtkOriginalCellIds");
}

} // namespace bsv

#endif

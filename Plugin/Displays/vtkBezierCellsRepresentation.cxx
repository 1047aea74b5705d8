// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBezierCellsRepresentation.h"

#include "Execution/FilterExecution.h"

#include "vtkDataSet.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkPVGeometryFilter.h"

#include <algorithm>
#include <numeric>

namespace
{

class LevelledGeometry : public vtkPVGeometryFilter
{
public:
  static LevelledGeometry* New();
  vtkTypeMacro(LevelledGeometry, vtkPVGeometryFilter);

  bool BySize = true;

  void SetNonlinearSubdivisionLevel(int level) override
  {
    if (this->Level != level)
    {
      this->Level = level;
      this->Modified();
    }
  }

protected:
  LevelledGeometry() = default;

  int RequestData(vtkInformation* request, vtkInformationVector** inputs, vtkInformationVector* outputs) override
  {
    auto* input = vtkDataSet::GetData(inputs[0]);
    // All ranks subdivide alike, or cracks would open between their cells.
    std::vector<bsv::Index> counts;
    try
    {
      const std::shared_ptr<const bsv::Ranks> ranks = bsv::globalRanks();
      ranks->together(
        [&] { counts = ranks->gatherAll(std::vector<bsv::Index>{ input ? input->GetNumberOfCells() : 0 }); });
    }
    catch (const bsv::Error& error)
    {
      vtkErrorMacro(<< error.what());
      return 0;
    }
    const bsv::Index cells = std::accumulate(counts.begin(), counts.end(), bsv::Index(0));
    const int most = !this->BySize || cells <= 3000 ? this->Level : cells <= 20000 ? 1 : 0;
    this->Superclass::SetNonlinearSubdivisionLevel(std::min(this->Level, most));
    return this->Superclass::RequestData(request, inputs, outputs);
  }

private:
  int Level = 1;
};
vtkStandardNewMacro(LevelledGeometry);

} // namespace

vtkStandardNewMacro(vtkBezierCellsRepresentation);

//------------------------------------------------------------------------------
vtkBezierCellsRepresentation::vtkBezierCellsRepresentation()
{
  this->GeometryFilter->Delete();
  this->GeometryFilter = LevelledGeometry::New();
  this->SetupDefaults();
}

//------------------------------------------------------------------------------
void vtkBezierCellsRepresentation::SetLevelBySize(bool on)
{
  auto* geometry = static_cast<LevelledGeometry*>(this->GeometryFilter);
  if (geometry->BySize != on)
  {
    geometry->BySize = on;
    geometry->Modified();
    this->MarkModified();
  }
}

//------------------------------------------------------------------------------
void vtkBezierCellsRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  const auto* geometry = static_cast<const LevelledGeometry*>(this->GeometryFilter);
  os << indent << "LevelBySize: " << geometry->BySize << '\n';
}

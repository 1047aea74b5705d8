// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBezierCellsRepresentation.h"

#include "Execution/FilterExecution.h"
#include "bezierQuads.h"
#include "sourceIds.h"

#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkPVGeometryFilter.h"
#include "vtkSmartPointer.h"
#include "vtkUnstructuredGrid.h"

#include <algorithm>
#include <string>

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
    vtkSmartPointer<vtkDataObject> input = vtkDataObject::GetData(inputs[0]);
    auto* grid = vtkUnstructuredGrid::SafeDownCast(input);
    // All ranks subdivide alike, or cracks would open between their cells.
    bsv::Index cells = 0, others = 0;
    int degree = 1;
    vtkSmartPointer<vtkPolyData> drawn;
    try
    {
      const bsv::Execution run = bsv::filterExecution(this);
      run.ranks->together([&] {
        const bsv::Index count = grid ? grid->GetNumberOfCells() : 0;
        const bsv::BezierKinds mine = grid ? bsv::bezierKinds(grid) : bsv::BezierKinds();
        for (const std::vector<bsv::Index>& rank :
          run.ranks->gather(std::vector<bsv::Index>{ count, mine.others, bsv::Index(mine.degree) }))
        {
          cells += rank[0];
          others += rank[1];
          degree = std::max(degree, static_cast<int>(rank[2]));
        }
      });
      const int most = !this->BySize || cells <= 3000 ? this->Level : cells <= 20000 ? 1 : 0;
      const int level = std::min(this->Level, most);
      this->Superclass::SetNonlinearSubdivisionLevel(level);
      if (grid && others == 0 && !this->UseOutline)
      {
        drawn = bsv::bezierQuads(grid, level == 0 ? 1 : degree << (level - 1), run);
      }
    }
    catch (const bsv::Error& error)
    {
      vtkErrorMacro(<< error.what());
      return 0;
    }
    if (!drawn)
    {
      return this->Superclass::RequestData(request, inputs, outputs);
    }
    vtkInformation* info = inputs[0]->GetInformationObject(0);
    info->Set(vtkDataObject::DATA_OBJECT(), drawn);
    const int result = this->Superclass::RequestData(request, inputs, outputs);
    info->Set(vtkDataObject::DATA_OBJECT(), input);
    if (auto* output = vtkPolyData::GetData(outputs))
    {
      bsv::selectBySources(output);
    }
    return result;
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
  this->SetNormalArray(nullptr);
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
void vtkBezierCellsRepresentation::SetNormalArray(const char* name)
{
  // The active normals are lost on the way to the mapper.
  this->Superclass::SetNormalArray(name && *name && std::string(name) != "None" ? name : "Normals");
}

//------------------------------------------------------------------------------
void vtkBezierCellsRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  const auto* geometry = static_cast<const LevelledGeometry*>(this->GeometryFilter);
  os << indent << "LevelBySize: " << geometry->BySize << '\n';
}

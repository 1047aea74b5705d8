// SPDX-License-Identifier: BSD-3-Clause
#include "vtkJoinsRepresentation.h"

#include "Quality/JoinClass.h"
#include "sourceIds.h"

#include "vtkBoundingBox.h"
#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkIdTypeArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPVGeometryFilter.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"

#include <cmath>
#include <vector>

namespace
{

constexpr const char* JumpName = "Layer jump (degrees)";

/// The parts of the list that are drawn. Cell array `SourceCell`: their cells in the list.
class JoinLines
{
public:
  JoinLines(int classes, double leastJump, double reach)
    : Classes(classes)
    , LeastJump(leastJump)
    , Reach(reach)
  {
    this->Points->SetDataTypeToDouble();
    this->Jump->SetName(JumpName);
  }

  vtkSmartPointer<vtkPolyData> build(vtkPolyData* list, bool worst)
  {
    this->limit(list);
    vtkDataArray* jumps = list->GetPointData()->GetArray(JumpName);
    vtkDataArray* classes = list->GetCellData()->GetArray("JoinClass");
    for (vtkIdType cell = 0; cell < list->GetNumberOfCells(); ++cell)
    {
      if (classes && !this->isChosen(static_cast<bsv::JoinClass>(static_cast<int>(classes->GetTuple1(cell)))))
      {
        continue;
      }
      vtkIdType count = 0;
      const vtkIdType* ids = nullptr;
      list->GetCellPoints(cell, count, ids);
      std::vector<vtkIdType> run;
      const auto end = [&] {
        if (run.size() > 1)
        {
          this->Lines->InsertNextCell(static_cast<vtkIdType>(run.size()), run.data());
          this->LineCells.push_back(cell);
        }
        run.clear();
      };
      for (vtkIdType n = 0; n < count; ++n)
      {
        const double jump = jumps ? jumps->GetTuple1(ids[n]) : 0.0;
        double x[3];
        list->GetPoint(ids[n], x);
        if ((jumps && jump < this->LeastJump) || !this->inReach(x))
        {
          end();
          continue;
        }
        run.push_back(this->point(x, jump));
      }
      end();
    }
    if (worst)
    {
      this->addWorst(list);
    }

    auto data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(this->Points);
    data->SetVerts(this->Verts);
    data->SetLines(this->Lines);
    if (jumps)
    {
      data->GetPointData()->SetScalars(this->Jump);
    }
    // Cells of a vtkPolyData: vertices first.
    vtkNew<vtkIdTypeArray> source;
    source->SetName("SourceCell");
    data->GetCellData()->CopyAllocate(list->GetCellData());
    vtkIdType place = 0;
    for (const auto* cells : { &this->VertCells, &this->LineCells })
    {
      for (const vtkIdType cell : *cells)
      {
        data->GetCellData()->CopyData(list->GetCellData(), cell, place++);
        source->InsertNextValue(cell);
      }
    }
    data->GetCellData()->AddArray(source);
    data->GetFieldData()->ShallowCopy(list->GetFieldData());
    return data;
  }

private:
  void limit(vtkPolyData* list)
  {
    vtkDataArray* box = list->GetFieldData()->GetArray("WallBox");
    if (box && box->GetNumberOfTuples() * box->GetNumberOfComponents() == 6 && this->Reach > 0.0)
    {
      double bounds[6];
      for (int n = 0; n < 6; ++n)
      {
        bounds[n] = box->GetVariantValue(n).ToDouble();
      }
      const vtkBoundingBox wall(bounds);
      wall.GetCenter(this->Center);
      this->Radius = (0.5 + this->Reach) * wall.GetDiagonalLength();
    }
  }

  bool isChosen(bsv::JoinClass of) const
  {
    return of == bsv::JoinClass::Defect || this->Classes == vtkJoinsRepresentation::ALL ||
      (of != bsv::JoinClass::Expected && this->Classes == vtkJoinsRepresentation::UNEXPECTED);
  }

  bool inReach(const double x[3]) const
  {
    return this->Radius <= 0.0 || std::sqrt(vtkMath::Distance2BetweenPoints(x, this->Center)) <= this->Radius;
  }

  vtkIdType point(const double x[3], double jump)
  {
    this->Jump->InsertNextValue(jump);
    return this->Points->InsertNextPoint(x);
  }

  void addWorst(vtkPolyData* list)
  {
    vtkDataArray* classes = list->GetCellData()->GetArray("JoinClass");
    vtkDataArray* where = list->GetCellData()->GetArray("Where");
    vtkDataArray* largest = list->GetCellData()->GetArray(JumpName);
    for (vtkIdType cell = 0; classes && where && largest && cell < list->GetNumberOfCells(); ++cell)
    {
      double x[3];
      where->GetTuple(cell, x);
      if (classes->GetTuple1(cell) == static_cast<double>(bsv::JoinClass::Defect) &&
        largest->GetTuple1(cell) >= this->LeastJump && this->inReach(x))
      {
        this->Verts->InsertNextCell({ this->point(x, largest->GetTuple1(cell)) });
        this->VertCells.push_back(cell);
      }
    }
  }

  int Classes;
  double LeastJump, Reach;
  double Center[3] = { 0.0, 0.0, 0.0 };
  double Radius = 0.0;
  vtkNew<vtkPoints> Points;
  vtkNew<vtkDoubleArray> Jump;
  vtkNew<vtkCellArray> Verts, Lines;
  std::vector<vtkIdType> VertCells, LineCells;
};

/// Gives ParaView's own geometry filter the chosen parts in place of the list.
class JoinsGeometry : public vtkPVGeometryFilter
{
public:
  static JoinsGeometry* New();
  vtkTypeMacro(JoinsGeometry, vtkPVGeometryFilter);

  int Classes = vtkJoinsRepresentation::DEFECTS;
  double LeastJump = 0.01;
  double Reach = 0.3;
  bool WorstPlaces = true;

protected:
  JoinsGeometry() = default;

  int RequestData(vtkInformation* request, vtkInformationVector** inputs, vtkInformationVector* outputs) override
  {
    vtkSmartPointer<vtkPolyData> list = vtkPolyData::GetData(inputs[0]);
    if (!list)
    {
      return this->Superclass::RequestData(request, inputs, outputs);
    }
    const auto drawn = JoinLines(this->Classes, this->LeastJump, this->Reach).build(list, this->WorstPlaces);
    vtkInformation* info = inputs[0]->GetInformationObject(0);
    info->Set(vtkDataObject::DATA_OBJECT(), drawn);
    const int result = this->Superclass::RequestData(request, inputs, outputs);
    info->Set(vtkDataObject::DATA_OBJECT(), list);
    if (auto* output = vtkPolyData::GetData(outputs))
    {
      bsv::selectBySources(output);
    }
    return result;
  }
};
vtkStandardNewMacro(JoinsGeometry);

} // namespace

vtkStandardNewMacro(vtkJoinsRepresentation);

//------------------------------------------------------------------------------
vtkJoinsRepresentation::vtkJoinsRepresentation()
{
  this->GeometryFilter->Delete();
  this->GeometryFilter = JoinsGeometry::New();
  this->SetupDefaults();
}

//------------------------------------------------------------------------------
template <typename Value>
void vtkJoinsRepresentation::Set(Value& member, Value value)
{
  if (member != value)
  {
    member = value;
    this->GeometryFilter->Modified();
    this->MarkModified();
  }
}

//------------------------------------------------------------------------------
void vtkJoinsRepresentation::SetClasses(int classes)
{
  this->Set(static_cast<JoinsGeometry*>(this->GeometryFilter)->Classes, classes);
}

//------------------------------------------------------------------------------
void vtkJoinsRepresentation::SetLeastJump(double jump)
{
  this->Set(static_cast<JoinsGeometry*>(this->GeometryFilter)->LeastJump, jump);
}

//------------------------------------------------------------------------------
void vtkJoinsRepresentation::SetReach(double reach)
{
  this->Set(static_cast<JoinsGeometry*>(this->GeometryFilter)->Reach, reach);
}

//------------------------------------------------------------------------------
void vtkJoinsRepresentation::SetShowWorstPlaces(bool on)
{
  this->Set(static_cast<JoinsGeometry*>(this->GeometryFilter)->WorstPlaces, on);
}

//------------------------------------------------------------------------------
void vtkJoinsRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  const auto* geometry = static_cast<const JoinsGeometry*>(this->GeometryFilter);
  os << indent << "Classes: " << geometry->Classes << '\n';
  os << indent << "LeastJump: " << geometry->LeastJump << '\n';
  os << indent << "Reach: " << geometry->Reach << '\n';
  os << indent << "ShowWorstPlaces: " << geometry->WorstPlaces << '\n';
}

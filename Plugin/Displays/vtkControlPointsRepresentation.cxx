// SPDX-License-Identifier: BSD-3-Clause
#include "vtkControlPointsRepresentation.h"

#include "Data/BoundarySelection.h"
#include "Data/FaceBounds.h"
#include "Execution/FilterExecution.h"
#include "Volume/ControlPointRule.h"
#include "blockParts.h"

#include "vtkCellArray.h"
#include "vtkDataObjectTree.h"
#include "vtkIdList.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPVGeometryFilter.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"
#include "vtkStructuredGrid.h"
#include "vtkUnsignedCharArray.h"

namespace
{

/// Gives ParaView's own geometry filter the chosen points in place of the blocks.
class PointsGeometry : public vtkPVGeometryFilter
{
public:
  static PointsGeometry* New();
  vtkTypeMacro(PointsGeometry, vtkPVGeometryFilter);

  bool Ordinary = false;
  double Reach = 0.05;

protected:
  PointsGeometry() = default;

  int RequestData(vtkInformation* request, vtkInformationVector** inputs, vtkInformationVector* outputs) override
  {
    vtkSmartPointer<vtkDataObject> input = vtkDataObject::GetData(inputs[0]);
    if (!input)
    {
      return 1;
    }
    this->Box.setEmpty();
    try
    {
      const std::shared_ptr<const bsv::Ranks> ranks = bsv::globalRanks();
      ranks->together([&] {
        const bsv::BSplineVolumeBlocks volume = bsv::bsplineVolumeBlocks(input, *ranks);
        this->Box = bsv::faceBounds(volume,
          bsv::facesOf(volume,
            bsv::wallBoundaries(
              input, volume.boundaryNames, volume.boundaryTypes, bsv::defaultBodyBoundaries(), *ranks)),
          *ranks);
      });
    }
    catch (const bsv::Error&)
    {
      // Said by those who read or convert it.
    }
    vtkSmartPointer<vtkDataObject> chosen;
    if (auto* tree = vtkDataObjectTree::SafeDownCast(input))
    {
      chosen = bsv::withLeaves(tree, [&](vtkDataObject* leaf) {
        auto* grid = vtkPointSet::SafeDownCast(leaf);
        return grid ? this->Choose(grid) : nullptr;
      });
    }
    else if (auto* grid = vtkPointSet::SafeDownCast(input))
    {
      chosen = this->Choose(grid);
    }
    vtkInformation* info = inputs[0]->GetInformationObject(0);
    info->Set(vtkDataObject::DATA_OBJECT(), chosen);
    const int result = this->Superclass::RequestData(request, inputs, outputs);
    info->Set(vtkDataObject::DATA_OBJECT(), input);
    vtkDataObject* output = vtkDataObject::GetData(outputs);
    if (auto* tree = vtkCompositeDataSet::SafeDownCast(output))
    {
      auto leaves = vtkSmartPointer<vtkCompositeDataIterator>::Take(tree->NewIterator());
      for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem())
      {
        Finish(leaves->GetCurrentDataObject());
      }
    }
    else
    {
      Finish(output);
    }
    return result;
  }

private:
  vtkSmartPointer<vtkPolyData> Choose(vtkPointSet* grid) const
  {
    auto data = vtkSmartPointer<vtkPolyData>::New();
    auto* rules = vtkUnsignedCharArray::SafeDownCast(grid->GetPointData()->GetArray("ControlPointRule"));
    const double reach = this->Box.isEmpty() ? 0.0 : this->Reach * this->Box.diagonal().norm();
    vtkNew<vtkIdList> from;
    for (vtkIdType n = 0; n < grid->GetNumberOfPoints(); ++n)
    {
      bsv::Vec3 x;
      grid->GetPoint(n, x.data());
      const auto rule = rules ? static_cast<bsv::ControlPointRule>(rules->GetValue(n)) : bsv::ControlPointRule::Corner;
      const bool ordinary = rule == bsv::ControlPointRule::Copied || rule == bsv::ControlPointRule::Regular;
      if ((this->Ordinary || !ordinary) && (reach <= 0.0 || this->Box.exteriorDistance(x) <= reach))
      {
        from->InsertNextId(n);
      }
    }
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    points->SetNumberOfPoints(from->GetNumberOfIds());
    vtkNew<vtkIdTypeArray> source;
    source->SetName("SourcePoint");
    source->SetNumberOfValues(from->GetNumberOfIds());
    vtkNew<vtkCellArray> verts;
    data->GetPointData()->CopyAllocate(grid->GetPointData(), from->GetNumberOfIds());
    for (vtkIdType n = 0; n < from->GetNumberOfIds(); ++n)
    {
      points->SetPoint(n, grid->GetPoint(from->GetId(n)));
      source->SetValue(n, from->GetId(n));
      verts->InsertNextCell({ n });
      data->GetPointData()->CopyData(grid->GetPointData(), from->GetId(n), n);
    }
    data->SetPoints(points);
    data->SetVerts(verts);
    data->GetPointData()->AddArray(source);
    return data;
  }

  /// Selections are those of the volume's points, and ParaView chooses no colours of blocks.
  static void Finish(vtkDataObject* leaf)
  {
    auto* data = vtkPolyData::SafeDownCast(leaf);
    vtkAbstractArray* source = data ? data->GetPointData()->GetAbstractArray("SourcePoint") : nullptr;
    if (source)
    {
      vtkNew<vtkIdTypeArray> named;
      named->DeepCopy(source);
      named->SetName("vtkOriginalPointIds");
      data->GetPointData()->RemoveArray("SourcePoint");
      data->GetPointData()->AddArray(named);
      data->GetFieldData()->RemoveArray("vtkBlockColors");
    }
  }

  Eigen::AlignedBox3d Box;
};
vtkStandardNewMacro(PointsGeometry);

} // namespace

vtkStandardNewMacro(vtkControlPointsRepresentation);

//------------------------------------------------------------------------------
vtkControlPointsRepresentation::vtkControlPointsRepresentation()
{
  this->GeometryFilter->Delete();
  this->GeometryFilter = PointsGeometry::New();
  this->SetupDefaults();
}

//------------------------------------------------------------------------------
void vtkControlPointsRepresentation::SetOrdinaryPoints(bool on)
{
  auto* geometry = static_cast<PointsGeometry*>(this->GeometryFilter);
  if (geometry->Ordinary != on)
  {
    geometry->Ordinary = on;
    geometry->Modified();
    this->MarkModified();
  }
}

//------------------------------------------------------------------------------
void vtkControlPointsRepresentation::SetReach(double reach)
{
  auto* geometry = static_cast<PointsGeometry*>(this->GeometryFilter);
  if (geometry->Reach != reach)
  {
    geometry->Reach = reach;
    geometry->Modified();
    this->MarkModified();
  }
}

//------------------------------------------------------------------------------
void vtkControlPointsRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  const auto* geometry = static_cast<const PointsGeometry*>(this->GeometryFilter);
  os << indent << "OrdinaryPoints: " << geometry->Ordinary << '\n';
  os << indent << "Reach: " << geometry->Reach << '\n';
}

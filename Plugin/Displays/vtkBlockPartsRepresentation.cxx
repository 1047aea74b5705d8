// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBlockPartsRepresentation.h"

#include "Execution/FilterExecution.h"
#include "blockParts.h"
#include "sourceIds.h"

#include "vtkActor.h"
#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCompositeDataIterator.h"
#include "vtkCompositeDataSet.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkLegendBoxActor.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPVGeometryFilter.h"
#include "vtkPVLODActor.h"
#include "vtkPVRenderView.h"
#include "vtkPVView.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkPolyDataMapper.h"
#include "vtkProperty.h"
#include "vtkRenderer.h"
#include "vtkShaderProperty.h"
#include "vtkSmartPointer.h"
#include "vtkStringArray.h"
#include "vtkTextProperty.h"
#include "vtkUnsignedCharArray.h"
#include "vtkWeakPointer.h"

#include <algorithm>
#include <array>
#include <string>

namespace
{

constexpr int NetsPort = 1;
constexpr int CurvesPort = 2;
constexpr int LegendPort = 3;

/// Gives ParaView's own geometry filter the chosen parts in place of the input.
class PartsGeometry : public vtkPVGeometryFilter
{
public:
  static PartsGeometry* New();
  vtkTypeMacro(PartsGeometry, vtkPVGeometryFilter);

  bsv::BlockPartsOptions Options;
  bsv::BlockParts Parts;

protected:
  PartsGeometry() = default;

  int RequestData(vtkInformation* request, vtkInformationVector** inputs, vtkInformationVector* outputs) override
  {
    vtkSmartPointer<vtkDataObject> input = vtkDataObject::GetData(inputs[0]);
    if (!input)
    {
      return 1;
    }
    try
    {
      this->Parts = bsv::blockParts(input, this->Options, bsv::filterExecution(this));
    }
    catch (const bsv::Error& error)
    {
      vtkErrorMacro(<< error.what());
      return 0;
    }
    vtkInformation* info = inputs[0]->GetInformationObject(0);
    info->Set(vtkDataObject::DATA_OBJECT(), this->Parts.surfaces);
    const int result = this->Superclass::RequestData(request, inputs, outputs);
    info->Set(vtkDataObject::DATA_OBJECT(), input);
    this->Parts.surfaces = nullptr;

    vtkDataObject* output = vtkDataObject::GetData(outputs);
    if (auto* tree = vtkCompositeDataSet::SafeDownCast(output))
    {
      auto leaves = vtkSmartPointer<vtkCompositeDataIterator>::Take(tree->NewIterator());
      for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem())
      {
        this->Finish(leaves->GetCurrentDataObject());
      }
    }
    else
    {
      this->Finish(output);
    }
    return result;
  }

private:
  /// Selections are those of the input's points and cells, and ParaView chooses no colours of blocks.
  void Finish(vtkDataObject* leaf)
  {
    auto* data = vtkPolyData::SafeDownCast(leaf);
    if (!data)
    {
      return;
    }
    data->GetFieldData()->RemoveArray("vtkBlockColors");
    bsv::selectBySources(data);
  }
};
vtkStandardNewMacro(PartsGeometry);

/// A filled rectangle: the legend would draw its texts in the colour of a symbol that has none of its own.
vtkSmartPointer<vtkPolyData> symbol(const double* color)
{
  vtkNew<vtkPoints> points;
  points->InsertNextPoint(0.0, 0.15, 0.0);
  points->InsertNextPoint(1.0, 0.15, 0.0);
  points->InsertNextPoint(1.0, 0.85, 0.0);
  points->InsertNextPoint(0.0, 0.85, 0.0);
  vtkNew<vtkCellArray> cells;
  cells->InsertNextCell({ 0, 1, 2, 3 });
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(3);
  colors->InsertNextTuple3(255 * color[0], 255 * color[1], 255 * color[2]);
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetPolys(cells);
  data->GetCellData()->SetScalars(colors);
  return data;
}

} // namespace

struct vtkBlockPartsRepresentation::Internals
{
  PartsGeometry* Geometry = nullptr;
  vtkNew<vtkPolyDataMapper> NetsMapper, CurvesMapper;
  vtkNew<vtkActor> NetsActor, CurvesActor;
  vtkNew<vtkLegendBoxActor> Legend;
  /// The legend's entries as field data, as they travel to the client.
  vtkNew<vtkPolyData> Entries;
  bool ShowLegend = true;
  bool ShowWallNet = false;
  bool ReflectionLines = false;
  int NumberOfReflectionLines = 24;
  /// Of the data that is drawn.
  bool IsVolume = true;
  bool HasEntries = false;
  /// Pixels.
  std::array<double, 2> LegendSize{ 0.0, 0.0 };
  vtkWeakPointer<vtkPVRenderView> View;
};

vtkStandardNewMacro(vtkBlockPartsRepresentation);

//------------------------------------------------------------------------------
vtkBlockPartsRepresentation::vtkBlockPartsRepresentation()
  : Internal(std::make_unique<Internals>())
{
  this->GeometryFilter->Delete();
  this->Internal->Geometry = PartsGeometry::New();
  this->GeometryFilter = this->Internal->Geometry;
  this->SetupDefaults();
  this->SetNormalArray(nullptr);

  Internals& internal = *this->Internal;
  internal.NetsMapper->ScalarVisibilityOff();
  // In front of the wall, behind the curves.
  internal.NetsMapper->SetRelativeCoincidentTopologyLineOffsetParameters(-2.0, -20.0);
  internal.NetsActor->SetMapper(internal.NetsMapper);
  vtkProperty* nets = internal.NetsActor->GetProperty();
  // Faint on light and on dark backgrounds.
  nets->SetColor(0.52, 0.55, 0.62);
  nets->LightingOff();

  internal.CurvesMapper->SetScalarModeToUseCellFieldData();
  internal.CurvesMapper->SelectColorArray("Colors");
  internal.CurvesMapper->SetColorModeToDirectScalars();
  // In front of the surface on which they lie.
  internal.CurvesMapper->SetRelativeCoincidentTopologyLineOffsetParameters(-4.0, -40.0);
  internal.CurvesMapper->SetRelativeCoincidentTopologyPointOffsetParameter(-40.0);
  internal.CurvesActor->SetMapper(internal.CurvesMapper);
  vtkProperty* curves = internal.CurvesActor->GetProperty();
  curves->SetRenderLinesAsTubes(true);
  curves->SetRenderPointsAsSpheres(true);
  curves->SetLineWidth(5.0f);
  curves->SetPointSize(11.0f);
  for (vtkActor* actor : { internal.NetsActor.Get(), internal.CurvesActor.Get() })
  {
    actor->PickableOff();
    // The wall alone sets the camera.
    actor->UseBoundsOff();
  }

  internal.Legend->ScalarVisibilityOn();
  internal.Legend->UseBackgroundOn();
  internal.Legend->SetBackgroundColor(0.97, 0.97, 0.97);
  internal.Legend->SetBackgroundOpacity(0.85);
  internal.Legend->BorderOff();
  internal.Legend->SetPadding(4);
  internal.Legend->PickableOff();
  vtkTextProperty* text = internal.Legend->GetEntryTextProperty();
  text->SetColor(0.0, 0.0, 0.0);
  text->ShadowOff();
  text->ItalicOff();
  text->BoldOff();
}

//------------------------------------------------------------------------------
vtkBlockPartsRepresentation::~vtkBlockPartsRepresentation() = default;

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetPart(bool& part, bool on)
{
  if (part != on)
  {
    part = on;
    this->GeometryFilter->Modified();
    this->MarkModified();
  }
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetShowWall(bool on)
{
  this->SetPart(this->Internal->Geometry->Options.wall, on);
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetShowWallNet(bool on)
{
  this->Internal->ShowWallNet = on;
  this->SetPart(this->Internal->Geometry->Options.wallNet, on);
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetShowSymmetryNet(bool on)
{
  this->SetPart(this->Internal->Geometry->Options.symmetryNet, on);
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetShowFarFieldNet(bool on)
{
  this->SetPart(this->Internal->Geometry->Options.farFieldNet, on);
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetShowBlockEdges(bool on)
{
  this->SetPart(this->Internal->Geometry->Options.blockEdges, on);
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetShowExtraordinaryCurves(bool on)
{
  this->SetPart(this->Internal->Geometry->Options.extraordinaryCurves, on);
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetShowCreases(bool on)
{
  this->SetPart(this->Internal->Geometry->Options.creases, on);
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetShowPartsLegend(bool on)
{
  this->Internal->ShowLegend = on;
  this->UpdateVisibility();
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetLayer(int layer)
{
  if (this->Internal->Geometry->Options.layer != layer)
  {
    this->Internal->Geometry->Options.layer = layer;
    this->GeometryFilter->Modified();
    this->MarkModified();
  }
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetSubdivision(int parts)
{
  if (this->Internal->Geometry->Options.subdivision != parts)
  {
    this->Internal->Geometry->Options.subdivision = parts;
    this->GeometryFilter->Modified();
    this->MarkModified();
  }
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetReach(double reach)
{
  if (this->Internal->Geometry->Options.reach != reach)
  {
    this->Internal->Geometry->Options.reach = reach;
    this->GeometryFilter->Modified();
    this->MarkModified();
  }
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetCurveWidth(double width)
{
  vtkProperty* property = this->Internal->CurvesActor->GetProperty();
  property->SetLineWidth(static_cast<float>(width));
  property->SetPointSize(static_cast<float>(2.2 * width));
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetReflectionLines(bool on)
{
  if (this->Internal->ReflectionLines != on)
  {
    this->Internal->ReflectionLines = on;
    this->SetPart(this->Internal->Geometry->Options.meshNormals, on);
    this->UpdateReflectionLines();
  }
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetNumberOfReflectionLines(int count)
{
  if (this->Internal->NumberOfReflectionLines != count)
  {
    this->Internal->NumberOfReflectionLines = count;
    this->UpdateReflectionLines();
  }
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::UpdateReflectionLines()
{
  // Names of the shader's variables are those of vtkOpenGLPolyDataMapper; they are no promised interface, and a test
  // looks at the picture.
  vtkShaderProperty* shader = this->Actor->GetShaderProperty();
  shader->ClearFragmentShaderReplacement("//VTK::Light::Impl", true);
  if (this->Internal->ReflectionLines)
  {
    // Long straight lamps, parallel to the horizontal axis of the view: the reflected ray meets one or the dark between
    // them depending on its angle around that axis.
    const std::string count = std::to_string(this->Internal->NumberOfReflectionLines) + ".0";
    shader->AddFragmentShaderReplacement("//VTK::Light::Impl", true,
      "//VTK::Light::Impl\n"
      "  vec3 bsvMirrored = reflect(normalize(vertexVC.xyz), normalize(normalVCVSOutput));\n"
      "  float bsvPhase = " +
        count +
        " * acos(clamp(bsvMirrored.y, -1.0, 1.0)) / 3.14159265;\n"
        "  float bsvWidth = fwidth(bsvPhase);\n"
        "  float bsvStripe = abs(2.0 * fract(bsvPhase) - 1.0) - 0.5;\n"
        "  float bsvLight = smoothstep(-bsvWidth, bsvWidth, bsvStripe);\n"
        // Stripes finer than pixels are grey.
        "  bsvLight = mix(bsvLight, 0.5, smoothstep(0.4, 0.8, bsvWidth));\n"
        "  gl_FragData[0] = vec4(mix(vec3(0.08), vec3(0.96), bsvLight) * (0.6 + 0.4 * abs(normalVCVSOutput.z)), "
        "opacity);\n",
      true);
  }
  this->MarkModified();
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetNormalArray(const char* name)
{
  // The active normals are lost on the way to the mapper.
  this->Superclass::SetNormalArray(name && *name && std::string(name) != "None" ? name : "Normals");
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::UpdateColoringParameters()
{
  this->Superclass::UpdateColoringParameters();
  // The net of a mesh are the edges of its quadrilaterals; that of a volume are lines of their own.
  if (this->Representation == SURFACE)
  {
    this->Property->SetEdgeVisibility(this->Internal->ShowWallNet && !this->Internal->IsVolume);
  }
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::SetVisibility(bool visible)
{
  this->Superclass::SetVisibility(visible);
  this->UpdateVisibility();
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::UpdateVisibility()
{
  Internals& internal = *this->Internal;
  const bool visible = this->GetVisibility();
  internal.NetsActor->SetVisibility(visible);
  internal.CurvesActor->SetVisibility(visible);
  internal.Legend->SetVisibility(visible && internal.ShowLegend && internal.HasEntries);
}

//------------------------------------------------------------------------------
bool vtkBlockPartsRepresentation::AddToView(vtkView* view)
{
  if (auto* render = vtkPVRenderView::SafeDownCast(view))
  {
    this->Internal->View = render;
    render->GetRenderer()->AddActor(this->Internal->NetsActor);
    render->GetRenderer()->AddActor(this->Internal->CurvesActor);
    render->GetNonCompositedRenderer()->AddActor(this->Internal->Legend);
  }
  return this->Superclass::AddToView(view);
}

//------------------------------------------------------------------------------
bool vtkBlockPartsRepresentation::RemoveFromView(vtkView* view)
{
  if (auto* render = vtkPVRenderView::SafeDownCast(view))
  {
    render->GetRenderer()->RemoveActor(this->Internal->NetsActor);
    render->GetRenderer()->RemoveActor(this->Internal->CurvesActor);
    render->GetNonCompositedRenderer()->RemoveActor(this->Internal->Legend);
  }
  return this->Superclass::RemoveFromView(view);
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::UpdateLegend()
{
  Internals& internal = *this->Internal;
  vtkFieldData* fields = internal.Entries->GetFieldData();
  auto* texts = vtkStringArray::SafeDownCast(fields->GetAbstractArray("Texts"));
  vtkDataArray* colors = fields->GetArray("EntryColors");
  const int count = texts && colors ? static_cast<int>(texts->GetNumberOfValues()) : 0;
  internal.HasEntries = count > 0;
  std::size_t width = 0;
  internal.Legend->SetNumberOfEntries(count);
  for (int n = 0; n < count; ++n)
  {
    double color[3];
    colors->GetTuple(n, color);
    const std::string text = "  " + texts->GetValue(n);
    width = std::max(width, text.size());
    double black[3] = { 0.0, 0.0, 0.0 };
    internal.Legend->SetEntry(n, symbol(color), text.c_str(), black);
  }
  internal.LegendSize = { 26.0 + 8.5 * static_cast<double>(width), 8.0 + 20.0 * count };
  this->PlaceLegend();
  this->UpdateVisibility();
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::PlaceLegend()
{
  Internals& internal = *this->Internal;
  if (!internal.View || !internal.HasEntries)
  {
    return;
  }
  const int* view = internal.View->GetRenderer()->GetSize();
  if (view[0] <= 0 || view[1] <= 0)
  {
    return;
  }
  constexpr double margin = 12.0;
  const double width = std::min(0.9, internal.LegendSize[0] / view[0]);
  const double height = std::min(0.9, internal.LegendSize[1] / view[1]);
  internal.Legend->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  internal.Legend->GetPosition2Coordinate()->SetCoordinateSystemToNormalizedViewport();
  internal.Legend->GetPositionCoordinate()->SetValue(1.0 - width - margin / view[0], 1.0 - height - margin / view[1]);
  internal.Legend->GetPosition2Coordinate()->SetValue(width, height);
}

//------------------------------------------------------------------------------
int vtkBlockPartsRepresentation::ProcessViewRequest(
  vtkInformationRequestKey* request, vtkInformation* inInfo, vtkInformation* outInfo)
{
  if (!this->Superclass::ProcessViewRequest(request, inInfo, outInfo))
  {
    return 0;
  }
  Internals& internal = *this->Internal;
  if (request == vtkPVView::REQUEST_UPDATE())
  {
    const bsv::BlockParts& parts = internal.Geometry->Parts;
    vtkNew<vtkPolyData> none;
    vtkPVView::SetPiece(inInfo, this, parts.nets ? parts.nets.Get() : none.Get(), 0, NetsPort);
    vtkPVView::SetPiece(inInfo, this, parts.curves ? parts.curves.Get() : none.Get(), 0, CurvesPort);
    vtkNew<vtkPolyData> entries;
    vtkNew<vtkStringArray> texts;
    texts->SetName("Texts");
    vtkNew<vtkDoubleArray> colors;
    colors->SetName("EntryColors");
    colors->SetNumberOfComponents(3);
    for (const bsv::BlockParts::Entry& entry : parts.legend)
    {
      texts->InsertNextValue(entry.text);
      colors->InsertNextTuple(entry.color.data());
    }
    vtkNew<vtkDoubleArray> isVolume;
    isVolume->SetName("IsVolume");
    isVolume->InsertNextValue(parts.isVolume ? 1.0 : 0.0);
    entries->GetFieldData()->AddArray(texts);
    entries->GetFieldData()->AddArray(colors);
    entries->GetFieldData()->AddArray(isVolume);
    vtkPVView::SetPiece(inInfo, this, entries, 0, LegendPort);
    vtkPVRenderView::SetDeliverToClientAndRenderingProcesses(inInfo, this, true, false, LegendPort);
  }
  else if (request == vtkPVView::REQUEST_RENDER())
  {
    this->PlaceLegend();
    internal.NetsMapper->SetInputDataObject(vtkPVView::GetDeliveredPiece(inInfo, this, NetsPort));
    internal.CurvesMapper->SetInputDataObject(vtkPVView::GetDeliveredPiece(inInfo, this, CurvesPort));
    vtkDataObject* entries = vtkPVView::GetDeliveredPiece(inInfo, this, LegendPort);
    if (entries && entries->GetFieldData() != internal.Entries->GetFieldData())
    {
      internal.Entries->SetFieldData(entries->GetFieldData());
      if (vtkDataArray* isVolume = entries->GetFieldData()->GetArray("IsVolume"))
      {
        internal.IsVolume = isVolume->GetTuple1(0) != 0.0;
      }
      this->UpdateLegend();
      this->UpdateColoringParameters();
    }
  }
  return 1;
}

//------------------------------------------------------------------------------
void vtkBlockPartsRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  const bsv::BlockPartsOptions& options = this->Internal->Geometry->Options;
  os << indent << "ShowWall: " << options.wall << '\n';
  os << indent << "Layer: " << options.layer << '\n';
  os << indent << "ShowWallNet: " << options.wallNet << '\n';
  os << indent << "ShowSymmetryNet: " << options.symmetryNet << '\n';
  os << indent << "ShowFarFieldNet: " << options.farFieldNet << '\n';
  os << indent << "ShowBlockEdges: " << options.blockEdges << '\n';
  os << indent << "ShowExtraordinaryCurves: " << options.extraordinaryCurves << '\n';
  os << indent << "ShowCreases: " << options.creases << '\n';
  os << indent << "Subdivision: " << options.subdivision << '\n';
  os << indent << "Reach: " << options.reach << '\n';
  os << indent << "ReflectionLines: " << this->Internal->ReflectionLines << '\n';
}

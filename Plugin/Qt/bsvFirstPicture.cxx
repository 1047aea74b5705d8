// SPDX-License-Identifier: BSD-3-Clause
#include "bsvFirstPicture.h"

#include "bsvFlight.h"

#include "pqApplicationCore.h"
#include "pqDataRepresentation.h"
#include "pqOutputPort.h"
#include "pqPipelineFilter.h"
#include "pqPropertiesPanel.h"
#include "pqRenderView.h"
#include "pqServerManagerModel.h"
#include "vtkCamera.h"
#include "vtkDataObject.h"
#include "vtkMath.h"
#include "vtkPVDataInformation.h"
#include "vtkPVGeneralSettings.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMRenderViewProxy.h"
#include "vtkSMRepresentationProxy.h"
#include "vtkSMTransferFunctionProxy.h"

#include <QVariant>
#include <QWidget>

#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace
{

/// Marks views and displays that have had their first picture.
const char* const Seen = "bsvSeen";
/// The width that a view had after the last Apply.
const char* const Width = "bsvWidth";

/// Titles of legends.
const std::pair<const char*, const char*> Titles[] = {
  { "ControlPointRule", "How control points are made" },
  { "Distance", "Distance (unit of the mesh)" },
  { "NormalDeviation", "Angle between normals (degrees)" },
  { "YPlus", "y+ of the first cell" },
  { "MeanCurvature", "Mean curvature (1 / length)" },
  { "GaussianCurvature", "Gaussian curvature (1 / length^2)" },
  { "Moved", "How far it moved (unit of the mesh)" },
};

bool isOurs(vtkSMProxy* display)
{
  for (const char* name : { "BlockMeshRepresentation", "BlockVolumeRepresentation", "GhostRepresentation",
         "TopologyRepresentation", "MeasuredSurfaceRepresentation", "BezierCellsRepresentation" })
  {
    if (std::strcmp(display->GetXMLName(), name) == 0)
    {
      return true;
    }
  }
  return false;
}

/// Looks at what is drawn from the front and above, from the side on which the mesh is of its symmetry plane.
void lookFromTheSide(pqRenderView* view, pqDataRepresentation* display)
{
  auto* shown = vtkSMRepresentationProxy::SafeDownCast(display->getProxy());
  vtkPVDataInformation* all = display->getOutputPortFromInput()->getDataInformation();
  vtkPVDataInformation* drawn = shown ? shown->GetRepresentedDataInformation() : nullptr;
  if (!all || !drawn)
  {
    return;
  }
  double outer[6], inner[6];
  all->GetBounds(outer);
  drawn->GetBounds(inner);
  if (!vtkMath::AreBoundsInitialized(outer) || !vtkMath::AreBoundsInitialized(inner))
  {
    return;
  }
  // A plane that both end at.
  int axis = -1;
  double side = 1.0;
  for (int d = 0; d < 3; ++d)
  {
    const double margin = 1e-6 * (inner[2 * d + 1] - inner[2 * d]);
    const bool low = std::abs(inner[2 * d] - outer[2 * d]) <= margin;
    const bool high = std::abs(inner[2 * d + 1] - outer[2 * d + 1]) <= margin;
    if (low != high && axis < 0)
    {
      axis = d;
      side = low ? 1.0 : -1.0;
    }
  }
  const int up = axis == 2 ? 1 : 2;
  // Not along the diagonal of two axes, where edges that cross would seem one.
  double look[3] = { 1.0, 1.3, 1.0 }, upwards[3] = { 0.0, 0.0, 0.0 };
  upwards[up] = 1.0;
  look[up] = -0.75;
  if (axis >= 0)
  {
    look[axis] = -1.3 * side;
  }
  auto* proxy = vtkSMRenderViewProxy::SafeDownCast(view->getProxy());
  proxy->ResetActiveCameraToDirection(look[0], look[1], look[2], upwards[0], upwards[1], upwards[2]);
  proxy->ResetCamera(true);
  double center[3];
  proxy->GetActiveCamera()->GetFocalPoint(center);
  view->setCenterOfRotation(center);
}

/// The array that colours a display, or nothing.
std::string coloringOf(vtkSMProxy* display)
{
  // Texts have no colours.
  const char* array = display->GetProperty("ColorArrayName")
    ? vtkSMPropertyHelper(display, "ColorArrayName").GetInputArrayNameToProcess()
    : nullptr;
  return array ? array : "";
}

void hideLegend(vtkSMProxy* display, pqView* view)
{
  vtkSMProxy* legend = vtkSMTransferFunctionProxy::FindScalarBarRepresentation(
    vtkSMPropertyHelper(display, "LookupTable").GetAsProxy(), view->getProxy());
  if (legend)
  {
    vtkSMPropertyHelper(legend, "Visibility").Set(0);
    legend->UpdateVTKObjects();
  }
}

/// A body has one colour, not the numbers of its parts, which ParaView takes where nothing else is coloured.
void takeBlockColors(pqDataRepresentation* display, pqView* view)
{
  vtkSMProxy* proxy = display->getProxy();
  const char* source = display->getInput() ? display->getInput()->getProxy()->GetXMLName() : "";
  if (std::strcmp(source, "NURBSSurfaceReader") != 0 || coloringOf(proxy) != "vtkBlockColors")
  {
    return;
  }
  hideLegend(proxy, view);
  vtkSMPropertyHelper(proxy, "ColorArrayName").SetInputArrayToProcess(vtkDataObject::POINT, "");
  proxy->UpdateVTKObjects();
}

/// The wall of the volume without curves and legend of its own.
void quietGround(pqDataRepresentation* joins, pqView* view)
{
  auto* filter = qobject_cast<pqPipelineFilter*>(joins->getInput());
  const QList<pqOutputPort*> inputs = filter ? filter->getInputs("Input") : QList<pqOutputPort*>();
  pqOutputPort* volume = inputs.isEmpty() ? nullptr : inputs.first();
  pqDataRepresentation* ground = volume ? volume->getRepresentation(view) : nullptr;
  if (!ground || !ground->getProxy()->GetProperty("ShowPartsLegend"))
  {
    return;
  }
  for (const char* part : { "ShowPartsLegend", "ShowExtraordinaryCurves", "ShowSymmetryNet" })
  {
    vtkSMPropertyHelper(ground->getProxy(), part).Set(0);
  }
  ground->getProxy()->UpdateVTKObjects();
}

} // namespace

//------------------------------------------------------------------------------
bsvFirstPicture::bsvFirstPicture(pqPropertiesPanel* panel, QObject* parent)
  : QObject(parent)
{
  QObject::connect(panel, SIGNAL(applied()), this, SLOT(applied()));
}

//------------------------------------------------------------------------------
void bsvFirstPicture::applied()
{
  const int views = pqApplicationCore::instance()->getServerManagerModel()->findItems<pqView*>().size();
  for (pqRenderView* view : pqApplicationCore::instance()->getServerManagerModel()->findItems<pqRenderView*>())
  {
    // A table that has come may have taken half of its width.
    const int before = view->property(Width).toInt();
    if (views > this->Views && before > 0)
    {
      bsv::keepWidth(
        view, []() {}, {}, before);
    }
    arrange(view);
    view->setProperty(Width, view->widget()->width());
  }
  this->Views = views;
}

//------------------------------------------------------------------------------
void bsvFirstPicture::arrange(pqRenderView* view)
{
  pqDataRepresentation* first = nullptr;
  bool changed = false;
  bool others = false;
  for (pqRepresentation* one : view->getRepresentations())
  {
    auto* display = qobject_cast<pqDataRepresentation*>(one);
    if (!display || !display->isVisible())
    {
      continue;
    }
    const bool isNew = !display->property(Seen).toBool();
    display->setProperty(Seen, true);
    const char* name = display->getProxy()->GetXMLName();
    if (isOurs(display->getProxy()))
    {
      first = first ? first : display;
    }
    else
    {
      others = others || !isNew;
    }
    bsvFirstPicture::setTitle(display->getProxy(), view->getProxy());
    if (isNew)
    {
      takeBlockColors(display, view);
    }
    if (isNew && std::strcmp(name, "JoinsRepresentation") == 0)
    {
      quietGround(display, view);
      // Without defects there is nothing whose colours mean anything.
      auto* shown = vtkSMRepresentationProxy::SafeDownCast(display->getProxy());
      if (shown && shown->GetRepresentedDataInformation()->GetNumberOfPoints() == 0)
      {
        hideLegend(shown, view);
      }
    }
    changed = changed || isNew;
  }
  if (changed && !view->property(Seen).toBool())
  {
    view->setProperty(Seen, true);
    if (first && !others && vtkPVGeneralSettings::GetInstance()->GetResetDisplayEmptyViews())
    {
      lookFromTheSide(view, first);
    }
  }
  if (changed)
  {
    view->render();
  }
}

//------------------------------------------------------------------------------
void bsvFirstPicture::setTitle(vtkSMProxy* display, vtkSMProxy* view)
{
  const std::string array = coloringOf(display);
  if (array.empty())
  {
    return;
  }
  vtkSMProxy* legend = vtkSMTransferFunctionProxy::FindScalarBarRepresentation(
    vtkSMPropertyHelper(display, "LookupTable").GetAsProxy(), view);
  if (legend && array == "Layer jump (degrees)" && vtkSMPropertyHelper(legend, "UseCustomLabels").GetAsInt() == 0)
  {
    // The ends of the classes.
    const double labels[] = { 0.01, 0.1, 1.0, 10.0, 100.0 };
    vtkSMPropertyHelper(legend, "UseCustomLabels").Set(1);
    vtkSMPropertyHelper(legend, "CustomLabels").Set(labels, 5);
    vtkSMPropertyHelper(legend, "AddRangeLabels").Set(0);
    vtkSMPropertyHelper(legend, "AutomaticLabelFormat").Set(0);
    // ParaView 6.1 has std::format in place of printf.
    vtkSMPropertyHelper format(legend, "LabelFormat");
    format.Set(std::string(format.GetAsString()).find('{') != std::string::npos ? "{:g}" : "%g");
    legend->UpdateVTKObjects();
  }
  for (const auto& [name, title] : Titles)
  {
    if (legend && array == name && array == vtkSMPropertyHelper(legend, "Title").GetAsString())
    {
      vtkSMPropertyHelper(legend, "Title").Set(title);
      vtkSMPropertyHelper(legend, "ComponentTitle").Set("");
      legend->UpdateVTKObjects();
    }
  }
}

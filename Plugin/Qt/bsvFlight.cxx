// SPDX-License-Identifier: BSD-3-Clause
#include "bsvFlight.h"

#include "pqActiveObjects.h"
#include "pqOutputPort.h"
#include "pqPVApplicationCore.h"
#include "pqPipelineSource.h"
#include "pqRenderView.h"
#include "pqSelectionManager.h"
#include "vtkCamera.h"
#include "vtkMath.h"
#include "vtkRenderer.h"
#include "vtkSMOutputPort.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMRenderViewProxy.h"
#include "vtkSMSessionProxyManager.h"
#include "vtkSMSourceProxy.h"
#include "vtkSelectionNode.h"
#include "vtkSmartPointer.h"

#include <QTimer>
#include <QVariant>
#include <QWidget>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace bsv
{

//------------------------------------------------------------------------------
void selectCell(pqOutputPort* port, int cell)
{
  vtkSMSessionProxyManager* proxies = port->getOutputPortProxy()->GetSessionProxyManager();
  const auto make = [&](const char* group, const char* name) {
    return vtkSmartPointer<vtkSMSourceProxy>::Take(vtkSMSourceProxy::SafeDownCast(proxies->NewProxy(group, name)));
  };
  const auto ids = make("sources", "IDSelectionSource");
  const vtkIdType processAndId[2] = { -1, cell };
  vtkSMPropertyHelper(ids, "IDs").Set(processAndId, 2);
  vtkSMPropertyHelper(ids, "FieldType").Set(vtkSelectionNode::CELL);
  ids->UpdateVTKObjects();
  const auto all = make("filters", "AppendSelections");
  vtkSMPropertyHelper(all, "Input").Set(ids);
  vtkSMPropertyHelper(all, "SelectionNames").Set("s0");
  vtkSMPropertyHelper(all, "Expression").Set("s0");
  all->UpdateVTKObjects();
  port->setSelectionInput(all, 0);
  if (pqSelectionManager* manager = pqPVApplicationCore::instance()->selectionManager())
  {
    manager->select(port);
  }
}

//------------------------------------------------------------------------------
int selectedCell(pqOutputPort* port)
{
  vtkSMSourceProxy* all = port->getSelectionInput();
  if (!all || !all->GetProperty("Input"))
  {
    return -1;
  }
  vtkSMPropertyHelper inputs(all, "Input");
  if (inputs.GetNumberOfElements() != 1)
  {
    return -1;
  }
  vtkSMProxy* ids = inputs.GetAsProxy(0);
  if (!ids || std::strcmp(ids->GetXMLName(), "IDSelectionSource") != 0)
  {
    return -1;
  }
  vtkSMPropertyHelper list(ids, "IDs");
  return vtkSMPropertyHelper(ids, "FieldType").GetAsInt() == vtkSelectionNode::CELL && list.GetNumberOfElements() == 2
    ? static_cast<int>(list.GetAsIdType(1))
    : -1;
}

//------------------------------------------------------------------------------
void flyTo(const std::array<double, 6>& bounds, const std::array<double, 3>& inwards)
{
  auto* view = qobject_cast<pqRenderView*>(pqActiveObjects::instance().activeView());
  if (!view)
  {
    return;
  }
  auto* proxy = vtkSMRenderViewProxy::SafeDownCast(view->getProxy());
  vtkCamera* camera = proxy->GetActiveCamera();
  double way[3];
  std::copy(inwards.begin(), inwards.end(), way);
  double look[3], up[3];
  camera->GetDirectionOfProjection(look);
  camera->GetViewUp(up);
  // Seen from behind the wall would hide it: half way between the two directions the camera looks past it.
  if (vtkMath::Normalize(way) > 0.0 && vtkMath::Dot(way, look) < 0.5)
  {
    for (int d = 0; d < 3; ++d)
    {
      look[d] = way[d] + 0.35 * look[d];
    }
    if (vtkMath::Normalize(look) == 0.0)
    {
      std::copy(way, way + 3, look);
    }
    if (std::abs(vtkMath::Dot(look, up)) > 0.95)
    {
      camera->GetDirectionOfProjection(up);
    }
    proxy->ResetActiveCameraToDirection(look[0], look[1], look[2], up[0], up[1], up[2]);
  }
  double box[6];
  std::copy(bounds.begin(), bounds.end(), box);
  proxy->ResetCamera(box);
  view->render();
}

//------------------------------------------------------------------------------
void keepWidth(pqRenderView* view, const std::function<void()>& makeRoom, const std::function<void()>& then, int before)
{
  before = before > 0 || !view ? before : view->widget()->width();
  makeRoom();
  static const char* const busy = "bsvKeepsWidth";
  if (!view || (view->property(busy).toBool() && !then))
  {
    return;
  }
  view->setProperty(busy, true);
  constexpr int afterLayout = 100; // milliseconds
  QTimer::singleShot(afterLayout, view, [view, before, then]() {
    view->setProperty(busy, false);
    const int now = view->widget()->width();
    auto* proxy = vtkSMRenderViewProxy::SafeDownCast(view->getProxy());
    if (now > 0 && before > now)
    {
      vtkCamera* camera = proxy->GetActiveCamera();
      const double part = static_cast<double>(now) / before;
      camera->Dolly(part);
      camera->SetParallelScale(camera->GetParallelScale() / part);
      proxy->GetRenderer()->ResetCameraClippingRange();
      proxy->UpdatePropertyInformation();
    }
    if (then)
    {
      then();
    }
    view->render();
  });
}

} // namespace bsv

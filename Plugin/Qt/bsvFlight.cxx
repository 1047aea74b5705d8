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

#include <QEvent>
#include <QPointer>
#include <QTimer>
#include <QVariant>
#include <QWidget>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace
{

/// Moves the camera back with every width that a view gets while the window is laid out, until it has been quiet for a
/// while: views pass through widths between the first and the last, some of them late on a busy machine.
class WidthKeeper : public QObject
{
public:
  /// The one that the view has, or null.
  static WidthKeeper* of(pqRenderView* view)
  {
    return static_cast<WidthKeeper*>(view->widget()->findChild<QObject*>(Name, Qt::FindDirectChildrenOnly));
  }

  WidthKeeper(pqRenderView* view)
    : QObject(view->widget())
    , View(view)
    , Last(view->widget()->width())
  {
    this->setObjectName(Name);
    view->widget()->installEventFilter(this);
    this->Quiet.setSingleShot(true);
    QObject::connect(&this->Quiet, &QTimer::timeout, this, [this]() { this->finish(); });
    this->Quiet.start(Pause);
  }

  void callAtTheEnd(std::function<void()> then) { this->Then = std::move(then); }

  /// The view had this width before.
  void follow(int before)
  {
    this->Last = before;
    this->adapt();
  }

protected:
  bool eventFilter(QObject* watched, QEvent* event) override
  {
    if (event->type() == QEvent::Resize)
    {
      this->adapt();
      this->Quiet.start(Pause);
    }
    return QObject::eventFilter(watched, event);
  }

private:
  static constexpr const char* Name = "bsvWidthKeeper";
  static constexpr int Pause = 400; // milliseconds

  void adapt()
  {
    const int now = this->View ? this->View->widget()->width() : 0;
    if (now > 0 && this->Last > 0 && now != this->Last)
    {
      const double part = static_cast<double>(now) / this->Last;
      auto* proxy = vtkSMRenderViewProxy::SafeDownCast(this->View->getProxy());
      vtkCamera* camera = proxy->GetActiveCamera();
      camera->Dolly(part);
      camera->SetParallelScale(camera->GetParallelScale() / part);
      proxy->GetRenderer()->ResetCameraClippingRange();
      proxy->UpdatePropertyInformation();
    }
    this->Last = now > 0 ? now : this->Last;
  }

  void finish()
  {
    this->deleteLater();
    if (!this->View)
    {
      return;
    }
    this->View->widget()->removeEventFilter(this);
    if (this->Then)
    {
      this->Then();
    }
    this->View->render();
  }

  QPointer<pqRenderView> View;
  std::function<void()> Then;
  QTimer Quiet;
  int Last;
};

} // namespace

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
  WidthKeeper* keeper = view ? WidthKeeper::of(view) : nullptr;
  if (view && !keeper)
  {
    // Its parent is the widget: it goes with the view.
    keeper = new WidthKeeper(view);
    if (before > 0)
    {
      keeper->follow(before);
    }
  }
  if (keeper && then)
  {
    keeper->callAtTheEnd(then);
  }
  makeRoom();
}

} // namespace bsv

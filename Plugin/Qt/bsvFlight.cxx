// SPDX-License-Identifier: BSD-3-Clause
#include "bsvFlight.h"

#include "pqActiveObjects.h"
#include "pqOutputPort.h"
#include "pqPVApplicationCore.h"
#include "pqPipelineSource.h"
#include "pqRenderView.h"
#include "pqSelectionManager.h"
#include "vtkSMOutputPort.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMRenderViewProxy.h"
#include "vtkSMSessionProxyManager.h"
#include "vtkSMSourceProxy.h"
#include "vtkSelectionNode.h"
#include "vtkSmartPointer.h"

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
void flyTo(const std::array<double, 6>& bounds)
{
  auto* view = qobject_cast<pqRenderView*>(pqActiveObjects::instance().activeView());
  if (!view)
  {
    return;
  }
  double box[6];
  std::copy(bounds.begin(), bounds.end(), box);
  vtkSMRenderViewProxy::SafeDownCast(view->getProxy())->ResetCamera(box);
  view->render();
}

} // namespace bsv

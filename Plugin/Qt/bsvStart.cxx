// SPDX-License-Identifier: BSD-3-Clause
#include "bsvStart.h"

#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"
#include "pqObjectBuilder.h"
#include "pqOutputPort.h"
#include "pqPipelineSource.h"
#include "pqServerManagerModel.h"
#include "vtkDataObject.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"

#include <QDockWidget>
#include <QMainWindow>
#include <QTimer>

#include <cstring>

namespace
{
constexpr int PanelWidth = 400;

bool isBody(pqOutputPort* port)
{
  vtkPVDataInformation* data = port->getDataInformation();
  return data && data->GetArrayInformation("KnotsV", vtkDataObject::FIELD) &&
    !data->GetArrayInformation("KnotsW", vtkDataObject::FIELD);
}

/// A conversion begins with the body that the session has, if there is one and only one.
void chooseBody(pqPipelineSource* filter)
{
  vtkSMProxy* proxy = filter->getProxy();
  if (std::strcmp(proxy->GetXMLName(), "CatmullClarkToBSplineVolume") != 0 ||
    vtkSMPropertyHelper(proxy, "Body").GetNumberOfElements() > 0)
  {
    return;
  }
  QList<pqOutputPort*> bodies;
  for (pqPipelineSource* source :
    pqApplicationCore::instance()->getServerManagerModel()->findItems<pqPipelineSource*>(filter->getServer()))
  {
    for (pqOutputPort* port : source->getOutputPorts())
    {
      if (source != filter && source->modifiedState() != pqProxy::UNINITIALIZED && isBody(port))
      {
        bodies << port;
      }
    }
  }
  if (bodies.size() == 1)
  {
    vtkSMPropertyHelper(proxy, "Body")
      .Set(bodies.first()->getSource()->getProxy(), static_cast<unsigned int>(bodies.first()->getPortNumber()));
    proxy->UpdateVTKObjects();
  }
}
}

//------------------------------------------------------------------------------
bsvStart::bsvStart(QObject* parent)
  : QObject(parent)
{
}

//------------------------------------------------------------------------------
void bsvStart::onStartup()
{
  QObject::connect(pqApplicationCore::instance()->getObjectBuilder(),
    static_cast<void (pqObjectBuilder::*)(pqPipelineSource*)>(&pqObjectBuilder::filterCreated), this, chooseBody);
  // The window may not have its layout yet.
  QTimer::singleShot(0, this, []() {
    auto* window = qobject_cast<QMainWindow*>(pqCoreUtilities::mainWidget());
    auto* dock = window ? window->findChild<QDockWidget*>("propertiesDock") : nullptr;
    if (dock && !dock->isFloating() && dock->width() < PanelWidth)
    {
      window->resizeDocks({ dock }, { PanelWidth }, Qt::Horizontal);
    }
  });
}

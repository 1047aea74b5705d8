// SPDX-License-Identifier: BSD-3-Clause
#include "bsvStart.h"

#include "bsvFirstPicture.h"
#include "bsvReaderChoice.h"
#include "bsvRuleTips.h"

#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"
#include "pqObjectBuilder.h"
#include "pqOutputPort.h"
#include "pqPipelineFilter.h"
#include "pqPropertiesPanel.h"
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
const char* const Conversion = "CatmullClarkToBSplineVolume";

bool isBody(pqOutputPort* port)
{
  vtkPVDataInformation* data = port->getDataInformation();
  return data && data->GetArrayInformation("KnotsV", vtkDataObject::FIELD) &&
    !data->GetArrayInformation("KnotsW", vtkDataObject::FIELD);
}

void setBody(vtkSMProxy* filter, pqOutputPort* body)
{
  vtkSMPropertyHelper(filter, "Body")
    .Set(body->getSource()->getProxy(), static_cast<unsigned int>(body->getPortNumber()));
  filter->UpdateVTKObjects();
}

/// The body of the conversion that a volume comes from, or null.
pqOutputPort* bodyOfConversion(pqPipelineSource* source)
{
  while (auto* filter = qobject_cast<pqPipelineFilter*>(source))
  {
    if (std::strcmp(filter->getProxy()->GetXMLName(), Conversion) == 0)
    {
      const QList<pqOutputPort*> bodies = filter->getInputs("Body");
      return bodies.isEmpty() ? nullptr : bodies.first();
    }
    const QList<pqOutputPort*> inputs = filter->getInputs("Input");
    source = inputs.isEmpty() ? nullptr : inputs.first()->getSource();
  }
  return nullptr;
}

/// A conversion begins with the body that the session has, if there is one and only one; Body Deviation with that of
/// the conversion.
void chooseBody(pqPipelineSource* filter)
{
  vtkSMProxy* proxy = filter->getProxy();
  const bool isConversion = std::strcmp(proxy->GetXMLName(), Conversion) == 0;
  const bool isDeviation = std::strcmp(proxy->GetXMLName(), "BodyDeviation") == 0;
  if ((!isConversion && !isDeviation) || vtkSMPropertyHelper(proxy, "Body").GetNumberOfElements() > 0)
  {
    return;
  }
  if (isDeviation)
  {
    if (pqOutputPort* body = bodyOfConversion(filter))
    {
      setBody(proxy, body);
      return;
    }
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
    setBody(proxy, bodies.first());
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
  new bsvReaderChoice(this);
  new bsvRuleTips(this);
  // The window may not have its layout yet.
  QTimer::singleShot(0, this, [this]() {
    auto* window = qobject_cast<QMainWindow*>(pqCoreUtilities::mainWidget());
    if (auto* panel = window ? window->findChild<pqPropertiesPanel*>() : nullptr)
    {
      new bsvFirstPicture(panel, this);
    }
    auto* dock = window ? window->findChild<QDockWidget*>("propertiesDock") : nullptr;
    if (dock && !dock->isFloating() && dock->width() < PanelWidth)
    {
      window->resizeDocks({ dock }, { PanelWidth }, Qt::Horizontal);
    }
  });
}

// SPDX-License-Identifier: BSD-3-Clause
#include "bsvActions.h"

#include "pqActiveObjects.h"
#include "pqApplicationCore.h"
#include "pqCoreUtilities.h"
#include "pqDataRepresentation.h"
#include "pqFileDialog.h"
#include "pqLinksModel.h"
#include "pqObjectBuilder.h"
#include "pqOutputPort.h"
#include "pqPipelineFilter.h"
#include "pqPipelineSource.h"
#include "pqRenderView.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "vtkDataObject.h"
#include "vtkNew.h"
#include "vtkSMPVRepresentationProxy.h"
#include "vtkSMParaViewPipelineControllerWithRendering.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMRenderViewProxy.h"
#include "vtkSMSourceProxy.h"

#include <QAction>
#include <QMessageBox>

#include <cstring>

namespace
{

const char* const Conversion = "CatmullClarkToBSplineVolume";

QString askFile(pqServer* server, const QString& title, const QString& filter, const char* name)
{
  pqFileDialog dialog(server, pqCoreUtilities::mainWidget(), title, QString(), filter, false);
  dialog.setObjectName(name);
  dialog.setFileMode(pqFileDialog::ExistingFile);
  return dialog.exec() == QDialog::Accepted && !dialog.getSelectedFiles().isEmpty() ? dialog.getSelectedFiles().first()
                                                                                    : QString();
}

/// The conversion that is active, or from which the active source comes; null after a message if there is none.
pqPipelineFilter* activeConversion()
{
  pqPipelineSource* source = pqActiveObjects::instance().activeSource();
  while (source)
  {
    auto* filter = qobject_cast<pqPipelineFilter*>(source);
    if (filter && std::strcmp(filter->getProxy()->GetXMLName(), Conversion) == 0)
    {
      return filter;
    }
    source =
      filter && filter->getInputCount() > 0 && filter->getAnyInput() ? filter->getAnyInput()->getSource() : nullptr;
  }
  QMessageBox::information(
    pqCoreUtilities::mainWidget(), "BSplineVolume", "Choose a CatmullClark To BSpline Volume in the Pipeline Browser.");
  return nullptr;
}

/// Shows an output with the representation Wall And Curves and its net. @return its display
vtkSMProxy* showWithNet(pqOutputPort* port, pqView* view)
{
  vtkNew<vtkSMParaViewPipelineControllerWithRendering> controller;
  vtkSMProxy* display = controller->Show(
    vtkSMSourceProxy::SafeDownCast(port->getSource()->getProxy()), port->getPortNumber(), view->getViewProxy());
  if (display && display->GetProperty("ShowWallNet"))
  {
    vtkSMRepresentationProxy::SetRepresentationType(display, "Wall And Curves");
    vtkSMPropertyHelper(display, "ShowWallNet").Set(1);
    display->UpdateVTKObjects();
  }
  return display;
}

} // namespace

//------------------------------------------------------------------------------
bsvActions::bsvActions(QObject* parent)
  : QActionGroup(parent)
{
  // They are buttons, not a choice of one.
  this->setExclusive(false);
  const auto add = [this](const char* text, const char* name, const char* tip, void (bsvActions::*slot)()) {
    auto* action = new QAction(text, this);
    action->setObjectName(name);
    action->setToolTip(tip);
    QObject::connect(action, &QAction::triggered, this, slot);
    this->addAction(action);
  };
  add("Convert Files...", "bsvConvertFiles", "A mesh and the CAD file of its body: readers and conversion",
    &bsvActions::convertFiles);
  add("Before And After", "bsvBeforeAndAfter", "Mesh and volume side by side, with linked cameras",
    &bsvActions::beforeAndAfter);
  add("Control Points By Rule", "bsvControlPoints", "Control points coloured by how each was made",
    &bsvActions::controlPoints);
}

//------------------------------------------------------------------------------
void bsvActions::convertFiles()
{
  pqServer* server = pqActiveObjects::instance().activeServer();
  if (!server)
  {
    return;
  }
  const QString mesh = askFile(server, "Mesh",
    "Block meshes (*.xyz *.p3d *.x *.grd *.g *.fmt *.bin *.unf *.cgns);;All files (*)", "bsvMeshDialog");
  if (mesh.isEmpty())
  {
    return;
  }
  const QString body = askFile(server, "Body of the mesh (Cancel: none)",
    "NURBS surfaces (*.igs *.iges *.stp *.step *.brep *.g2);;All files (*)", "bsvBodyDialog");
  pqObjectBuilder* builder = pqApplicationCore::instance()->getObjectBuilder();
  QMap<QString, QList<pqOutputPort*>> inputs;
  const auto read = [&](const char* input, const char* reader, const QString& file) {
    pqPipelineSource* source = builder->createReader("sources", reader, QStringList(file), server);
    if (source)
    {
      inputs[input] << source->getOutputPort(0);
      // The panel of the conversion lists the mesh's boundaries, and the body is what it can choose.
      source->updatePipeline();
      source->setModifiedState(pqProxy::UNMODIFIED);
    }
    return source != nullptr;
  };
  if (!read("Input", "HexBlockMeshReader", mesh) || (!body.isEmpty() && !read("Body", "NURBSSurfaceReader", body)))
  {
    return;
  }
  if (pqPipelineSource* filter = builder->createFilter("filters", Conversion, inputs, server))
  {
    pqActiveObjects::instance().setActiveSource(filter);
  }
}

//------------------------------------------------------------------------------
void bsvActions::beforeAndAfter()
{
  pqPipelineFilter* filter = activeConversion();
  if (!filter || filter->modifiedState() == pqProxy::UNINITIALIZED)
  {
    return;
  }
  vtkNew<vtkSMParaViewPipelineControllerWithRendering> controller;
  pqObjectBuilder* builder = pqApplicationCore::instance()->getObjectBuilder();
  pqView* after = pqActiveObjects::instance().activeView();
  if (!qobject_cast<pqRenderView*>(after))
  {
    after = builder->createView(pqRenderView::renderViewType(), filter->getServer());
    controller->AssignViewToLayout(after->getViewProxy());
  }
  pqView* before = builder->createView(pqRenderView::renderViewType(), filter->getServer());
  controller->AssignViewToLayout(before->getViewProxy());

  pqOutputPort* mesh = filter->getAnyInput();
  controller->Hide(
    vtkSMSourceProxy::SafeDownCast(mesh->getSource()->getProxy()), mesh->getPortNumber(), after->getViewProxy());
  showWithNet(filter->getOutputPort(0), after);
  showWithNet(mesh, before);
  auto* one = vtkSMRenderViewProxy::SafeDownCast(after->getProxy());
  auto* other = vtkSMRenderViewProxy::SafeDownCast(before->getProxy());
  for (const char* property : { "CameraPosition", "CameraFocalPoint", "CameraViewUp" })
  {
    const std::vector<double> value = vtkSMPropertyHelper(one, property, true).GetDoubleArray();
    vtkSMPropertyHelper(other, property).Set(value.data(), static_cast<unsigned int>(value.size()));
  }
  other->UpdateVTKObjects();
  pqLinksModel* links = pqApplicationCore::instance()->getLinksModel();
  QString name;
  for (int n = 1; name.isEmpty() || links->getLink(name); ++n)
  {
    name = QString("Before And After %1").arg(n);
  }
  links->addCameraLink(name, after->getProxy(), before->getProxy());
  after->render();
  before->render();
}

//------------------------------------------------------------------------------
void bsvActions::controlPoints()
{
  pqPipelineFilter* filter = activeConversion();
  pqView* view = pqActiveObjects::instance().activeView();
  if (!filter || filter->modifiedState() == pqProxy::UNINITIALIZED || !qobject_cast<pqRenderView*>(view))
  {
    return;
  }
  vtkNew<vtkSMParaViewPipelineControllerWithRendering> controller;
  vtkSMProxy* display = controller->Show(vtkSMSourceProxy::SafeDownCast(filter->getProxy()), 0, view->getViewProxy());
  vtkSMRepresentationProxy::SetRepresentationType(display, "Points");
  vtkSMPropertyHelper(display, "PointSize").Set(5);
  vtkSMPropertyHelper(display, "RenderPointsAsSpheres").Set(1);
  display->UpdateVTKObjects();
  if (auto* colored = vtkSMPVRepresentationProxy::SafeDownCast(display))
  {
    colored->SetScalarColoring("ControlPointRule", vtkDataObject::POINT);
    colored->SetScalarBarVisibility(view->getViewProxy(), true);
  }
  view->render();
}

// SPDX-License-Identifier: BSD-3-Clause
#include "bsvActions.h"

#include "bsvFirstPicture.h"
#include "bsvFlight.h"
#include "bsvPickedFaces.h"

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
#include "pqPropertiesPanel.h"
#include "pqRenderView.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "vtkDataObject.h"
#include "vtkNew.h"
#include "vtkPVArrayInformation.h"
#include "vtkPVDataInformation.h"
#include "vtkSMPVRepresentationProxy.h"
#include "vtkSMParaViewPipelineControllerWithRendering.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMRenderViewProxy.h"
#include "vtkSMSourceProxy.h"

#include <QAction>
#include <QMessageBox>
#include <QPointer>

#include <cstring>
#include <memory>

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

void tell(const QString& text)
{
  QMessageBox::information(pqCoreUtilities::mainWidget(), "BSplineVolume", text);
}

bool isVolume(pqOutputPort* port)
{
  vtkPVDataInformation* data = port->getDataInformation();
  return data && data->GetArrayInformation("KnotsW", vtkDataObject::FIELD);
}

/// Presses Apply.
void applyPanel()
{
  if (auto* panel = pqCoreUtilities::mainWidget()->findChild<pqPropertiesPanel*>())
  {
    panel->apply();
  }
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
    const QList<pqOutputPort*> inputs = filter ? filter->getInputs("Input") : QList<pqOutputPort*>();
    source = inputs.isEmpty() ? nullptr : inputs.first()->getSource();
  }
  tell("Choose a CatmullClark To BSpline Volume in the Pipeline Browser.");
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

/// The second view looks as the first one does, from now on.
void linkCameras(pqView* one, pqView* other)
{
  auto* from = vtkSMRenderViewProxy::SafeDownCast(one->getProxy());
  auto* to = vtkSMRenderViewProxy::SafeDownCast(other->getProxy());
  // Pictures that fill the view have an angle of their own.
  for (const char* property :
    { "CameraPosition", "CameraFocalPoint", "CameraViewUp", "CameraViewAngle", "CameraParallelScale" })
  {
    const std::vector<double> value = vtkSMPropertyHelper(from, property, true).GetDoubleArray();
    vtkSMPropertyHelper(to, property).Set(value.data(), static_cast<unsigned int>(value.size()));
  }
  to->UpdateVTKObjects();
  pqLinksModel* links = pqApplicationCore::instance()->getLinksModel();
  QString name;
  for (int n = 1; name.isEmpty() || links->getLink(name); ++n)
  {
    name = QString("Before And After %1").arg(n);
  }
  links->addCameraLink(name, from, to);
  one->render();
  other->render();
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
  add("Compare Volumes", "bsvCompare", "What changed between the two volumes that are selected, or the only two",
    &bsvActions::compare);
  add("Selected Faces Are Body", "bsvPickFaces",
    "Block faces of which cells are selected in the view become Body Faces of the conversion of their mesh",
    &bsvActions::pickFaces);
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
  pqView* before = pqActiveObjects::instance().activeView();
  if (!qobject_cast<pqRenderView*>(before))
  {
    before = builder->createView(pqRenderView::renderViewType(), filter->getServer());
    controller->AssignViewToLayout(before->getViewProxy());
  }
  // Made when the window is split, linked when both views have their sizes.
  const auto after = std::make_shared<QPointer<pqView>>();
  bsv::keepWidth(
    qobject_cast<pqRenderView*>(before),
    [&]() {
      *after = builder->createView(pqRenderView::renderViewType(), filter->getServer());
      controller->AssignViewToLayout((*after)->getViewProxy());
    },
    [one = QPointer<pqView>(before), after]() {
      if (one && *after)
      {
        linkCameras(one, *after);
      }
    });
  before->rename("Before: mesh");
  (*after)->rename("After: volume");

  // One verdict and one legend are too much for half a window.
  auto* conversion = vtkSMSourceProxy::SafeDownCast(filter->getProxy());
  controller->Hide(conversion, 0, before->getViewProxy());
  controller->Hide(conversion, 1, before->getViewProxy());
  showWithNet(filter->getInputs("Input").first(), before);
  if (vtkSMProxy* display = showWithNet(filter->getOutputPort(0), *after))
  {
    vtkSMPropertyHelper(display, "ShowPartsLegend").Set(0);
    display->UpdateVTKObjects();
  }
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
  vtkSMRepresentationProxy::SetRepresentationType(display, "Control Points");
  // Flat: spheres are not drawn in front of a wall on which they lie.
  vtkSMPropertyHelper(display, "PointSize").Set(6);
  display->UpdateVTKObjects();
  // The wall of the mesh as their ground.
  pqOutputPort* mesh = filter->getInputs("Input").first();
  vtkSMProxy* ground = controller->Show(
    vtkSMSourceProxy::SafeDownCast(mesh->getSource()->getProxy()), mesh->getPortNumber(), view->getViewProxy());
  if (ground && ground->GetProperty("ShowPartsLegend"))
  {
    for (const char* part : { "ShowPartsLegend", "ShowExtraordinaryCurves", "ShowCreases", "ShowSymmetryNet" })
    {
      vtkSMPropertyHelper(ground, part).Set(0);
    }
    ground->UpdateVTKObjects();
  }
  if (auto* colored = vtkSMPVRepresentationProxy::SafeDownCast(display))
  {
    colored->SetScalarColoring("ControlPointRule", vtkDataObject::POINT);
    colored->SetScalarBarVisibility(view->getViewProxy(), true);
    bsvFirstPicture::setTitle(display, view->getProxy());
  }
  view->render();
}

//------------------------------------------------------------------------------
void bsvActions::compare()
{
  pqServer* server = pqActiveObjects::instance().activeServer();
  // In the order in which they were made.
  QList<pqOutputPort*> all, chosen;
  for (pqPipelineSource* source :
    pqApplicationCore::instance()->getServerManagerModel()->findItems<pqPipelineSource*>(server))
  {
    pqOutputPort* port = source->getOutputPort(0);
    if (source->modifiedState() != pqProxy::UNINITIALIZED && isVolume(port))
    {
      all << port;
      const bool isChosen = pqActiveObjects::instance().selection().contains(source) ||
        pqActiveObjects::instance().selection().contains(port);
      chosen << (isChosen ? QList<pqOutputPort*>{ port } : QList<pqOutputPort*>());
    }
  }
  const QList<pqOutputPort*>& two = chosen.size() == 2 ? chosen : all;
  if (two.size() != 2)
  {
    tell("Select two volumes in the Pipeline Browser, with Ctrl: the later one is compared with the earlier one.");
    return;
  }
  QMap<QString, QList<pqOutputPort*>> inputs;
  inputs["Input"] << two[1];
  inputs["Before"] << two[0];
  pqPipelineSource* filter = pqApplicationCore::instance()->getObjectBuilder()->createFilter(
    "filters", "BSplineVolumeDifference", inputs, server);
  if (filter)
  {
    pqActiveObjects::instance().setActiveSource(filter);
    applyPanel();
  }
}

//------------------------------------------------------------------------------
void bsvActions::pickFaces()
{
  pqServer* server = pqActiveObjects::instance().activeServer();
  pqServerManagerModel* model = pqApplicationCore::instance()->getServerManagerModel();
  pqOutputPort* mesh = nullptr;
  for (pqPipelineSource* source : model->findItems<pqPipelineSource*>(server))
  {
    for (pqOutputPort* port : source->getOutputPorts())
    {
      mesh = port->getSelectionInput() ? port : mesh;
    }
  }
  if (!mesh || isVolume(mesh))
  {
    tell("Select cells of a mesh in the view: Select Cells On, and drag a rectangle.");
    return;
  }
  const bsv::PickedFaces picked = bsv::pickedFaces(mesh);
  if (!picked.problem.empty())
  {
    tell(QString::fromStdString(picked.problem));
    return;
  }
  pqPipelineSource* filter = nullptr;
  for (pqPipelineSource* consumer : mesh->getConsumers())
  {
    filter = std::strcmp(consumer->getProxy()->GetXMLName(), Conversion) == 0 ? consumer : filter;
  }
  if (!filter)
  {
    QMap<QString, QList<pqOutputPort*>> inputs;
    inputs["Input"] << mesh;
    filter = pqApplicationCore::instance()->getObjectBuilder()->createFilter("filters", Conversion, inputs, server);
  }
  if (!filter)
  {
    return;
  }
  std::vector<int> numbers;
  QString text;
  for (const auto& [block, face] : picked.faces)
  {
    numbers.push_back(block);
    numbers.push_back(face);
    text += QString("\nblock %1, face %2").arg(block).arg(face);
  }
  vtkSMPropertyHelper(filter->getProxy(), "BodyFaces").Set(numbers.data(), static_cast<unsigned int>(numbers.size()));
  filter->getProxy()->UpdateVTKObjects();
  if (filter->modifiedState() == pqProxy::UNMODIFIED)
  {
    filter->setModifiedState(pqProxy::MODIFIED);
  }
  pqActiveObjects::instance().setActiveSource(filter);
  tell("Body Faces of " + filter->getSMName() + ", from the next Apply on:" + text);
}

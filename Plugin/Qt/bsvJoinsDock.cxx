// SPDX-License-Identifier: BSD-3-Clause
#include "bsvJoinsDock.h"

#include "bsvFlight.h"

#include "pqActiveObjects.h"
#include "pqOutputPort.h"
#include "pqPVApplicationCore.h"
#include "pqPipelineSource.h"
#include "pqSelectionManager.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSourceProxy.h"

#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QStringList>
#include <QTableWidget>
#include <QVBoxLayout>

#include <cstring>

namespace
{

/// The port of vtkBSplineVolumeSmoothness with one polyline per join.
constexpr int JoinsPort = 4;
/// Fields of an entry of its property JoinList: these columns, then the six bounds.
const char* const Columns[] = { "Class", "What", "Blocks", "Jump", "Measure" };
constexpr int ColumnCount = 5;
constexpr int BoundsRole = Qt::UserRole;

} // namespace

//------------------------------------------------------------------------------
bsvJoinsDock::bsvJoinsDock(const QString& title, QWidget* parent, Qt::WindowFlags flags)
  : QDockWidget(title, parent, flags)
{
  this->build();
}

//------------------------------------------------------------------------------
bsvJoinsDock::bsvJoinsDock(QWidget* parent, Qt::WindowFlags flags)
  : QDockWidget(parent, flags)
{
  this->build();
}

//------------------------------------------------------------------------------
void bsvJoinsDock::build()
{
  this->setWindowTitle("Joins of B-Spline Volumes");
  this->setObjectName("bsvJoinsDock");
  auto* body = new QWidget(this);
  body->setObjectName("Body");
  auto* layout = new QVBoxLayout(body);
  layout->setContentsMargins(2, 2, 2, 2);
  this->Title = new QLabel("Apply BSpline Volume Smoothness to see its joins, defects first.", body);
  this->Title->setWordWrap(true);
  this->Table = new QTableWidget(body);
  this->Table->setObjectName("Joins");
  this->Table->setColumnCount(ColumnCount);
  QStringList names;
  for (const char* name : Columns)
  {
    names << name;
  }
  this->Table->setHorizontalHeaderLabels(names);
  this->Table->setSelectionBehavior(QAbstractItemView::SelectRows);
  this->Table->setSelectionMode(QAbstractItemView::SingleSelection);
  this->Table->setEditTriggers(QAbstractItemView::NoEditTriggers);
  this->Table->horizontalHeader()->setStretchLastSection(true);
  auto* button = new QPushButton("Fly To Join", body);
  button->setObjectName("Fly");
  layout->addWidget(this->Title);
  layout->addWidget(this->Table);
  layout->addWidget(button);
  this->setWidget(body);
  // It comes to the front when there is something to show.
  this->hide();

  QObject::connect(&pqActiveObjects::instance(), SIGNAL(sourceChanged(pqPipelineSource*)), this, SLOT(fill()));
  QObject::connect(&pqActiveObjects::instance(), SIGNAL(dataUpdated()), this, SLOT(fill()));
  QObject::connect(
    this->Table, &QTableWidget::currentCellChanged, this, [this](int row, int, int, int) { this->show(row); });
  QObject::connect(this->Table, &QTableWidget::cellDoubleClicked, this, [this](int, int) { this->fly(); });
  QObject::connect(button, SIGNAL(clicked()), this, SLOT(fly()));
  if (pqSelectionManager* manager = pqPVApplicationCore::instance()->selectionManager())
  {
    QObject::connect(
      manager, SIGNAL(selectionChanged(pqOutputPort*)), this, SLOT(picked(pqOutputPort*)), Qt::UniqueConnection);
  }
}

//------------------------------------------------------------------------------
pqOutputPort* bsvJoinsDock::joins() const
{
  return this->Source && this->Source->getNumberOfOutputPorts() > JoinsPort ? this->Source->getOutputPort(JoinsPort)
                                                                            : nullptr;
}

//------------------------------------------------------------------------------
void bsvJoinsDock::fill()
{
  pqPipelineSource* active = pqActiveObjects::instance().activeSource();
  if (active && std::strcmp(active->getProxy()->GetXMLName(), "BSplineVolumeSmoothness") == 0)
  {
    this->Source = active;
  }
  QStringList entries;
  if (this->Source)
  {
    vtkSMProxy* proxy = this->Source->getProxy();
    proxy->UpdatePropertyInformation(proxy->GetProperty("JoinList"));
    vtkSMPropertyHelper list(proxy, "JoinList", true);
    for (unsigned int n = 0; n < list.GetNumberOfElements(); ++n)
    {
      entries << list.GetAsString(n);
    }
  }
  this->Busy = true;
  this->Table->setRowCount(0);
  int defects = 0;
  for (const QString& entry : entries)
  {
    const QStringList fields = entry.split('\t');
    if (fields.size() != ColumnCount + 6)
    {
      continue;
    }
    const int row = this->Table->rowCount();
    this->Table->insertRow(row);
    for (int column = 0; column < ColumnCount; ++column)
    {
      auto* item = new QTableWidgetItem(fields[column]);
      item->setData(BoundsRole, QStringList(fields.mid(ColumnCount)));
      this->Table->setItem(row, column, item);
    }
    defects += fields[0] == "defect" ? 1 : 0;
  }
  this->Busy = false;
  this->Table->resizeColumnsToContents();
  if (this->Source)
  {
    this->Title->setText(QString("%1: %2 joins, %3 defects. Double click: fly there.")
                           .arg(this->Source->getSMName())
                           .arg(this->Table->rowCount())
                           .arg(defects));
    if (this->Table->rowCount() > 0 && active == this->Source)
    {
      this->setVisible(true);
      this->raise();
    }
  }
}

//------------------------------------------------------------------------------
void bsvJoinsDock::show(int row)
{
  if (this->Busy || row < 0 || !this->joins())
  {
    return;
  }
  this->Busy = true;
  bsv::selectCell(this->joins(), row);
  this->Busy = false;
  pqActiveObjects::instance().setActivePort(this->joins());
  if (pqView* view = pqActiveObjects::instance().activeView())
  {
    view->render();
  }
}

//------------------------------------------------------------------------------
void bsvJoinsDock::fly()
{
  const int row = this->Table->rowCount() > 0 ? std::max(0, this->Table->currentRow()) : -1;
  if (row < 0)
  {
    return;
  }
  if (this->Table->currentRow() != row)
  {
    this->Table->setCurrentCell(row, 0);
  }
  const QStringList fields = this->Table->item(row, 0)->data(BoundsRole).toStringList();
  std::array<double, 6> bounds;
  for (int n = 0; n < 6; ++n)
  {
    bounds[n] = fields[n].toDouble();
  }
  bsv::flyTo(bounds);
}

//------------------------------------------------------------------------------
void bsvJoinsDock::picked(pqOutputPort* port)
{
  if (this->Busy || !port || port != this->joins())
  {
    return;
  }
  const int cell = bsv::selectedCell(port);
  if (cell >= 0 && cell < this->Table->rowCount())
  {
    this->Busy = true;
    this->Table->setCurrentCell(cell, 0);
    this->Busy = false;
  }
}

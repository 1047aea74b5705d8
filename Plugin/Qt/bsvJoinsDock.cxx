// SPDX-License-Identifier: BSD-3-Clause
#include "bsvJoinsDock.h"

#include "bsvFlight.h"

#include "pqActiveObjects.h"
#include "pqCoreUtilities.h"
#include "pqOutputPort.h"
#include "pqPVApplicationCore.h"
#include "pqPipelineSource.h"
#include "pqRenderView.h"
#include "pqSelectionManager.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSourceProxy.h"

#include <QColor>
#include <QFontMetrics>
#include <QHeaderView>
#include <QLabel>
#include <QMainWindow>
#include <QPushButton>
#include <QStringList>
#include <QTableWidget>
#include <QVBoxLayout>

#include <algorithm>
#include <cstring>
#include <utility>

namespace
{

/// The port of vtkBSplineVolumeSmoothness with one polyline per join.
constexpr int JoinsPort = 4;
/// Fields of an entry of its property JoinList: these columns, then what flyTo() takes: six bounds and a direction.
const char* const Columns[] = { "Class", "What", "Blocks", "Jump", "Measure" };
constexpr int ColumnCount = 5;
/// The dock is as wide as its columns, up to this.
constexpr int MostWidth = 490;
constexpr int FlightCount = 9;
constexpr int FlightRole = Qt::UserRole;

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
  // Rows are one line high: as much of it as there is room.
  this->Table->setWordWrap(false);
  this->Table->horizontalHeader()->setStretchLastSection(true);
  this->Table->verticalHeader()->setDefaultSectionSize(QFontMetrics(this->Table->font()).lineSpacing() + 6);
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
    if (fields.size() != ColumnCount + FlightCount)
    {
      continue;
    }
    const int row = this->Table->rowCount();
    this->Table->insertRow(row);
    for (int column = 0; column < ColumnCount; ++column)
    {
      auto* item = new QTableWidgetItem(
        QString(fields[column]).remove("interface, ").remove("at an ").replace(" degrees", QString(QChar(0x00b0))));
      item->setToolTip(fields[column]);
      item->setData(FlightRole, QStringList(fields.mid(ColumnCount)));
      if (column == 0 && fields[0] == "defect")
      {
        item->setForeground(QColor(180, 20, 30));
      }
      this->Table->setItem(row, column, item);
    }
    defects += fields[0] == "defect" ? 1 : 0;
  }
  this->Busy = false;
  this->Table->resizeColumnsToContents();
  const int letter = QFontMetrics(this->Table->font()).averageCharWidth();
  for (const auto& [column, letters] : { std::make_pair(1, 24), std::make_pair(2, 20) })
  {
    this->Table->setColumnWidth(column, std::min(this->Table->columnWidth(column), letters * letter));
  }
  if (this->Source)
  {
    this->Title->setText(QString("%1: %2 joins, %3 defects. Double click: fly there.")
                           .arg(this->Source->getSMName())
                           .arg(this->Table->rowCount())
                           .arg(defects));
    if (this->Table->rowCount() > 0 && active == this->Source)
    {
      const bool wasHidden = this->isHidden();
      auto* view = qobject_cast<pqRenderView*>(pqActiveObjects::instance().activeView());
      const auto show = [this]() {
        this->setVisible(true);
        this->raise();
        this->makeRoom();
      };
      if (wasHidden)
      {
        bsv::keepWidth(view, show);
      }
      else
      {
        this->raise();
      }
    }
  }
}

//------------------------------------------------------------------------------
void bsvJoinsDock::makeRoom()
{
  auto* window = qobject_cast<QMainWindow*>(pqCoreUtilities::mainWidget());
  if (!window || this->isFloating())
  {
    return;
  }
  // What it measures is there after the next layout only.
  int width = 45 + QFontMetrics(this->Table->font()).horizontalAdvance("000");
  for (int column = 0; column < ColumnCount - 1; ++column)
  {
    width += this->Table->columnWidth(column);
  }
  window->resizeDocks({ this }, { std::min(width, MostWidth) }, Qt::Horizontal);
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
  const QStringList fields = this->Table->item(row, 0)->data(FlightRole).toStringList();
  std::array<double, 6> bounds;
  std::array<double, 3> inwards;
  for (int n = 0; n < FlightCount; ++n)
  {
    (n < 6 ? bounds[n] : inwards[n - 6]) = fields[n].toDouble();
  }
  bsv::flyTo(bounds, inwards);
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

// SPDX-License-Identifier: BSD-3-Clause
#include "bsvReaderChoice.h"

#include <QApplication>
#include <QEvent>
#include <QListWidget>

#include <utility>

//------------------------------------------------------------------------------
bsvReaderChoice::bsvReaderChoice(QObject* parent)
  : QObject(parent)
{
  qApp->installEventFilter(this);
}

//------------------------------------------------------------------------------
bool bsvReaderChoice::eventFilter(QObject* watched, QEvent* event)
{
  static const std::pair<const char*, const char*> Readers[] = {
    { "Hex Block Mesh Reader", "for B-spline volumes" },
    { "NURBS Surface Reader", "for their body" },
  };
  if (event->type() == QEvent::Show && watched->objectName() == QLatin1String("pqSelectReaderDialog"))
  {
    if (auto* list = watched->findChild<QListWidget*>("listWidget"))
    {
      for (const auto& [name, what] : Readers)
      {
        for (QListWidgetItem* item : list->findItems(name, Qt::MatchExactly))
        {
          item->setText(QString("%1: %2").arg(name, what));
          list->setCurrentItem(item);
        }
      }
    }
  }
  return QObject::eventFilter(watched, event);
}

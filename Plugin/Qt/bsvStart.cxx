// SPDX-License-Identifier: BSD-3-Clause
#include "bsvStart.h"

#include "pqCoreUtilities.h"

#include <QDockWidget>
#include <QMainWindow>
#include <QTimer>

namespace
{
constexpr int PanelWidth = 400;
}

//------------------------------------------------------------------------------
bsvStart::bsvStart(QObject* parent)
  : QObject(parent)
{
}

//------------------------------------------------------------------------------
void bsvStart::onStartup()
{
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

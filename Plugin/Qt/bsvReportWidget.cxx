// SPDX-License-Identifier: BSD-3-Clause
#include "bsvReportWidget.h"

#include "vtkSMProperty.h"

#include <QFontMetrics>
#include <QStringList>
#include <QTextEdit>
#include <QVBoxLayout>

namespace
{
constexpr int Lines = 14;
}

//------------------------------------------------------------------------------
bsvReportWidget::bsvReportWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent)
  : pqPropertyWidget(proxy, parent)
  , Box(new QTextEdit(this))
{
  this->setShowLabel(false);
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(this->Box);
  this->Box->setObjectName("Report");
  this->Box->setReadOnly(true);
  this->Box->setLineWrapMode(QTextEdit::WidgetWidth);
  this->Box->setMinimumWidth(50);
  this->Box->setFixedHeight(Lines * QFontMetrics(this->Box->font()).lineSpacing() + 10);
  this->addPropertyLink(this, "report", SIGNAL(reportChanged()), property);
}

//------------------------------------------------------------------------------
void bsvReportWidget::setReport(const QString& report)
{
  if (this->Report == report)
  {
    return;
  }
  this->Report = report;
  QStringList lines = report.split('\n');
  for (QString& line : lines)
  {
    line = line.toHtmlEscaped();
  }
  if (!lines.isEmpty() && !lines.first().isEmpty())
  {
    lines.first() = "<b>" + lines.first() + "</b>";
  }
  this->Box->setHtml(lines.join("<br/>"));
  Q_EMIT this->reportChanged();
}

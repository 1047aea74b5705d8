// SPDX-License-Identifier: BSD-3-Clause
#include "bsvRuleTips.h"

#include "Volume/ControlPointRule.h"

#include <QApplication>
#include <QEvent>
#include <QLabel>
#include <QRegularExpression>

//------------------------------------------------------------------------------
bsvRuleTips::bsvRuleTips(QObject* parent)
  : QObject(parent)
{
  qApp->installEventFilter(this);
}

//------------------------------------------------------------------------------
bool bsvRuleTips::eventFilter(QObject* watched, QEvent* event)
{
  // Qt's own label of tool tips: its text is set before it is shown, and again while it is, which resizes it.
  const bool isTip = (event->type() == QEvent::Show || event->type() == QEvent::Resize) &&
    watched->objectName() == QLatin1String("qtooltip_label");
  auto* label = isTip ? qobject_cast<QLabel*>(watched) : nullptr;
  if (label)
  {
    static const QRegularExpression code("ControlPointRule: (\\d++)(?! \\()");
    const QRegularExpressionMatch found = code.match(label->text());
    const std::vector<std::string>& names = bsv::controlPointRuleNames();
    const int rule = found.hasMatch() ? found.captured(1).toInt() : -1;
    if (rule >= 0 && rule < static_cast<int>(names.size()))
    {
      QString text = label->text();
      text.insert(found.capturedEnd(1), QString(" (%1)").arg(QString::fromStdString(names[rule])));
      static const QRegularExpression id("Id: (\\d++)");
      static const QRegularExpression size("BlockDimensions: \\((\\d+), (\\d+), ");
      const QRegularExpressionMatch point = id.match(text), block = size.match(text);
      if (point.hasMatch() && block.hasMatch())
      {
        const qlonglong n = point.captured(1).toLongLong();
        const qlonglong ni = block.captured(1).toLongLong(), nj = block.captured(2).toLongLong();
        if (ni > 0 && nj > 0)
        {
          text.insert(
            point.capturedEnd(1), QString(" (i %1, j %2, k %3)").arg(n % ni).arg(n / ni % nj).arg(n / (ni * nj)));
        }
      }
      label->setText(text);
      label->resize(label->sizeHint());
    }
  }
  return QObject::eventFilter(watched, event);
}

// SPDX-License-Identifier: BSD-3-Clause
/**
 * Panel widget `bsv_report` of a string property that a filter sets: a box of text to read and to copy, with lines
 * broken at its width, its first line, the verdict, in bold.
 */
#ifndef bsvReportWidget_h
#define bsvReportWidget_h

#include "pqPropertyWidget.h"

#include <QString>

class QTextEdit;

class bsvReportWidget : public pqPropertyWidget
{
  Q_OBJECT
  Q_PROPERTY(QString report READ report WRITE setReport)

public:
  bsvReportWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent = nullptr);

  QString report() const { return this->Report; }
  void setReport(const QString& report);

Q_SIGNALS:
  void reportChanged();

private:
  QTextEdit* Box;
  QString Report;
};

#endif

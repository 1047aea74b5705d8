// SPDX-License-Identifier: BSD-3-Clause
/**
 * ParaView's text about the point under the mouse (Hover Points On) has the numbers of its arrays only: this puts the
 * name of the rule beside the code of ControlPointRule, and i, j, k beside the index of the point. The block is there
 * already.
 */
#ifndef bsvRuleTips_h
#define bsvRuleTips_h

#include <QObject>

class bsvRuleTips : public QObject
{
  Q_OBJECT

public:
  explicit bsvRuleTips(QObject* parent);

protected:
  bool eventFilter(QObject* watched, QEvent* event) override;
};

#endif

// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   bsvReaderChoice
 * @brief   says in ParaView's question for a reader what the readers of this plugin do, and begins with ours
 *
 * ParaView asks which reader to take where several read a file, such as .cgns or .xyz. It lists them by name alone.
 */
#ifndef bsvReaderChoice_h
#define bsvReaderChoice_h

#include <QObject>

class bsvReaderChoice : public QObject
{
  Q_OBJECT

public:
  bsvReaderChoice(QObject* parent);

  bool eventFilter(QObject* watched, QEvent* event) override;
};

#endif

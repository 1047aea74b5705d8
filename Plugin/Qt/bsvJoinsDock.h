// SPDX-License-Identifier: BSD-3-Clause
/**
 * Dock with the list of joins of the Smoothness filter, defects first. A row shows its join in the view; a double click
 * or the button takes the camera there. A join that is picked in the view selects its row.
 */
#ifndef bsvJoinsDock_h
#define bsvJoinsDock_h

#include <QDockWidget>
#include <QPointer>

class QLabel;
class QTableWidget;
class pqOutputPort;
class pqPipelineSource;

class bsvJoinsDock : public QDockWidget
{
  Q_OBJECT

public:
  bsvJoinsDock(const QString& title, QWidget* parent = nullptr, Qt::WindowFlags flags = Qt::WindowFlags());
  explicit bsvJoinsDock(QWidget* parent = nullptr, Qt::WindowFlags flags = Qt::WindowFlags());

private Q_SLOTS:
  /// Lists the joins of the active filter, or of the one that was active last.
  void fill();
  void show(int row);
  void fly();
  void picked(pqOutputPort* port);

private:
  void build();
  void makeRoom();
  pqOutputPort* joins() const;

  QPointer<pqPipelineSource> Source;
  QLabel* Title = nullptr;
  QTableWidget* Table = nullptr;
  bool Busy = false;
};

#endif

// SPDX-License-Identifier: BSD-3-Clause
/**
 * When the plugin is loaded, makes room for its panels: the docks of the properties get at least 400 pixels. From then
 * on a new conversion begins with the NURBS surface that the session has, if it is the only one, as its body; Body
 * Deviation begins with that of the conversion. Watches over first pictures (bsvFirstPicture.h).
 */
#ifndef bsvStart_h
#define bsvStart_h

#include <QObject>

class bsvStart : public QObject
{
  Q_OBJECT

public:
  explicit bsvStart(QObject* parent = nullptr);

  void onStartup();
  void onShutdown() {}
};

#endif

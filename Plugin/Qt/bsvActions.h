// SPDX-License-Identifier: BSD-3-Clause
#ifndef bsvActions_h
#define bsvActions_h

#include <QActionGroup>

/**
 * The menu BSplineVolume: what takes many clicks in ParaView's own menus.
 * - Convert Files: asks for a mesh and for a CAD file of the body (Cancel: none), and sets up the readers and the
 *   conversion. One Apply does it all.
 * - Before And After: the mesh and the volume of the active conversion side by side with linked cameras, both with
 *   their nets.
 * - Control Points By Rule: the control points of the active conversion, coloured by how each was made.
 * - Selected Faces Are Body: block faces of which cells are selected in the view become Body Faces of the conversion of
 *   their mesh, which is made if there is none.
 * - Compare Volumes: the difference of the two volumes that are selected, or of the only two, applied at once.
 */
class bsvActions : public QActionGroup
{
  Q_OBJECT

public:
  explicit bsvActions(QObject* parent);

private Q_SLOTS:
  void convertFiles();
  void beforeAndAfter();
  void controlPoints();
  void compare();
  void pickFaces();
};

#endif

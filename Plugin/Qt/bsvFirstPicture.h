// SPDX-License-Identifier: BSD-3-Clause
/**
 * What the window does after an Apply beyond what the server's hints can say:
 * - the first picture in an empty view is seen from the side, with the symmetry plane behind, and fills the view;
 * - bodies have one colour;
 * - legends have titles with units in place of names of arrays;
 * - joins, when they are first shown, have the wall of their volume as a quiet ground: its own curves and their legend
 *   are switched off, so that one legend is left.
 */
#ifndef bsvFirstPicture_h
#define bsvFirstPicture_h

#include <QObject>

class pqPropertiesPanel;
class pqRenderView;
class vtkSMProxy;

class bsvFirstPicture : public QObject
{
  Q_OBJECT

public:
  bsvFirstPicture(pqPropertiesPanel* panel, QObject* parent);

  /// Gives the legend of a display its title, unless it has one that is not the array's name.
  static void setTitle(vtkSMProxy* display, vtkSMProxy* view);

private Q_SLOTS:
  void applied();

private:
  static void arrange(pqRenderView* view);

  int Views = 0;
};

#endif

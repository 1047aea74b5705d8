// SPDX-License-Identifier: BSD-3-Clause
/**
 * Takes the camera of the active view to a place of an output and selects a cell there.
 */
#ifndef bsvFlight_h
#define bsvFlight_h

#include <array>
#include <functional>

class pqOutputPort;
class pqRenderView;

namespace bsv
{

/// Selects one cell of a data set that is no composite, held by the first process; shown in all views.
void selectCell(pqOutputPort* port, int cell);

/// The cell that is selected, or -1: none, several, or something else.
int selectedCell(pqOutputPort* port);

/// @param bounds of what is to be seen; the view keeps its direction
/// @param inwards from there to what must not be in the way: the camera looks about that way, or from where it is if it
/// looks so already; zeros: from where it is
void flyTo(const std::array<double, 6>& bounds, const std::array<double, 3>& inwards);

/// Makes room beside a view and shows as much of the width as before: the camera goes back with every width that the
/// view gets while the window is laid out; `then` is called when that is over.
/// @param before the width before, or 0: what it is when this is called
void keepWidth(
  pqRenderView* view, const std::function<void()>& makeRoom, const std::function<void()>& then = {}, int before = 0);

} // namespace bsv

#endif

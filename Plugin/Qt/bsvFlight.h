// SPDX-License-Identifier: BSD-3-Clause
/**
 * Takes the camera of the active view to a place of an output and selects a cell there.
 */
#ifndef bsvFlight_h
#define bsvFlight_h

#include <array>

class pqOutputPort;

namespace bsv
{

/// Selects one cell of a data set that is no composite, held by the first process; shown in all views.
void selectCell(pqOutputPort* port, int cell);

/// The cell that is selected, or -1: none, several, or something else.
int selectedCell(pqOutputPort* port);

/// @param bounds of what is to be seen; the view keeps its direction
void flyTo(const std::array<double, 6>& bounds);

} // namespace bsv

#endif

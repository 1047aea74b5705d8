// SPDX-License-Identifier: BSD-3-Clause
/// @file PieceRequest.h
/// The pieces that VTK's pipeline asks readers and sources for.
#pragma once

#include "Execution/FilterExecution.h"
#include "Ranks/Piece.h"

#include <vtkInformation.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>

namespace bsv
{

/// The piece that is asked for in the information of an output.
inline Piece requestedPiece(vtkInformation* output)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  Piece piece;
  if (output->Has(Pipeline::UPDATE_PIECE_NUMBER()) && output->Has(Pipeline::UPDATE_NUMBER_OF_PIECES()))
  {
    piece.number = output->Get(Pipeline::UPDATE_PIECE_NUMBER());
    piece.count = std::max(1, output->Get(Pipeline::UPDATE_NUMBER_OF_PIECES()));
  }
  return piece;
}

/// filterExecution() for what makes a piece: with the other ranks if each of them was asked for the piece of its own
/// number, else alone.
inline Execution pieceExecution(vtkAlgorithm* algorithm, const Piece& piece, double first = 0.0, double last = 1.0)
{
  Execution run = filterExecution(algorithm, first, last);
  if (piece.count != run.ranks->size() || piece.number != run.ranks->rank())
  {
    run.ranks = aloneRank();
  }
  return run;
}

} // namespace bsv

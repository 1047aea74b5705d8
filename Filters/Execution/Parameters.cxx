// SPDX-License-Identifier: BSD-3-Clause
#include "Execution/Parameters.h"

#include <vtkAlgorithm.h>
#include <vtkIndent.h>

#include <limits>
#include <sstream>

namespace bsv
{

std::string parametersOf(vtkAlgorithm* algorithm)
{
  std::ostringstream text;
  for (int port = 0; port < algorithm->GetNumberOfInputPorts(); ++port)
  {
    text << "Connections of input " << port << ": " << algorithm->GetNumberOfInputConnections(port) << '\n';
  }
  // The digits that an error shows first, then all of them, for numbers that differ by less.
  for (const int digits : { 6, std::numeric_limits<double>::max_digits10 })
  {
    std::ostringstream common, all;
    common.precision(digits);
    all.precision(digits);
    algorithm->vtkAlgorithm::PrintSelf(common, vtkIndent());
    algorithm->PrintSelf(all, vtkIndent());
    text << all.str().substr(common.str().size());
  }
  return text.str();
}

} // namespace bsv

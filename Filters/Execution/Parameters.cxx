// SPDX-License-Identifier: BSD-3-Clause
#include "Execution/Parameters.h"

#include "Base/Types.h"

#include <vtkAlgorithm.h>
#include <vtkIndent.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <sstream>

namespace bsv
{

namespace
{

/// What an algorithm prints beyond what all algorithms do: its properties.
std::string printed(vtkAlgorithm* algorithm, int digits)
{
  std::ostringstream common, all;
  common.precision(digits);
  all.precision(digits);
  algorithm->vtkAlgorithm::PrintSelf(common, vtkIndent());
  algorithm->PrintSelf(all, vtkIndent());
  return all.str().substr(common.str().size());
}

/// The words of a property's name, as users see them.
std::string labelOf(const std::string& name)
{
  std::string label;
  for (const char letter : name)
  {
    const bool begins = std::isupper(static_cast<unsigned char>(letter)) && !label.empty() &&
      std::islower(static_cast<unsigned char>(label.back()));
    label += begins ? std::string(" ") + letter : std::string(1, letter);
  }
  return label;
}

bool endsWith(const std::string& text, const std::string& end)
{
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

} // namespace

void requireFiniteParameters(vtkAlgorithm* algorithm)
{
  std::istringstream lines(printed(algorithm, 6));
  for (std::string line; std::getline(lines, line);)
  {
    const std::size_t colon = line.find(':');
    const std::size_t first = std::min(line.find_first_not_of(' '), line.size());
    const std::string name = line.substr(first, colon - first);
    if (colon == std::string::npos || endsWith(name, "Name") || endsWith(name, "File") || endsWith(name, "Array"))
    {
      continue; // no numbers
    }
    std::string value = line.substr(colon + 1);
    std::replace_if(
      value.begin(), value.end(), [](char sign) { return std::strchr("(),", sign) != nullptr; }, ' ');
    std::istringstream words(value);
    std::string wrong;
    bool numbers = true;
    for (std::string word; words >> word;)
    {
      char* end = nullptr;
      const double number = std::strtod(word.c_str(), &end);
      numbers = numbers && *end == '\0';
      wrong = std::isfinite(number) ? wrong : word;
    }
    if (numbers && !wrong.empty())
    {
      throw Error(labelOf(name) + ": " + wrong + " is no finite number");
    }
  }
}

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
    text << printed(algorithm, digits);
  }
  return text.str();
}

} // namespace bsv

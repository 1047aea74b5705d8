// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/NURBSSurfaceFile.h"

#include "Base/MemoryCheck.h"
#include "Formats/CADOutput.h"
#include "IO/AtomicFile.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>

namespace bsv
{
namespace
{

std::string number(double value)
{
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof(text), value).ptr);
}

void writeG2(const std::vector<BodyPatch>& patches, AtomicFile& file)
{
  for (const BodyPatch& patch : patches)
  {
    const NURBSSurface& surface = patch.surface;
    std::string text = "200 1 0 0\n3 " + std::to_string(surface.rational() ? 1 : 0) + "\n";
    for (int d = 0; d < 2; ++d)
    {
      text += std::to_string(surface.count(d)) + " " + std::to_string(surface.degree[d] + 1) + "\n";
      for (std::size_t i = 0; i < surface.knots[d].size(); ++i)
      {
        text += (i == 0 ? "" : " ") + number(surface.knots[d][i]);
      }
      text += "\n";
    }
    for (std::size_t i = 0; i < surface.points.size(); ++i)
    {
      const double weight = surface.rational() ? surface.weights[i] : 1.0;
      for (int d = 0; d < 3; ++d)
      {
        text += (d == 0 ? "" : " ") + number(surface.points[i][d] * weight);
      }
      text += surface.rational() ? " " + number(weight) + "\n" : "\n";
    }
    file.write(text + "\n");
  }
}

} // namespace

void writeNURBSSurfaceFile(const SurfacesToWrite& surfaces, const std::string& fileName, double metres,
  const Execution& run, std::vector<std::string>& notes)
{
  const std::filesystem::path path(fileName);
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
    [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  const bool step = extension == ".step" || extension == ".stp";
  if (!step && extension != ".g2" && extension != ".igs" && extension != ".iges")
  {
    throw Error("File Name '" + fileName + "': the extension must be step, stp, iges, igs or g2");
  }
  double points = 0.0;
  for (const BodyPatch& patch : surfaces.patches)
  {
    points += static_cast<double>(patch.surface.points.size());
  }
  // Four numbers of up to 24 characters, as the library's and as ours.
  requireMemory(points * 2 * 4 * 24, "the patches", "their text");
  AtomicFile file(fileName);
  if (extension == ".g2")
  {
    writeG2(surfaces.patches, file);
  }
  else
  {
    notes.insert(notes.end(), surfaces.notes.begin(), surfaces.notes.end());
    writeCAD(surfaces, step ? CADFormat::STEP : CADFormat::IGES, metres, path.stem().string(), file, run, notes);
  }
  file.finish();
  file.publish();
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
// The wall of a conversion: how its points are taken, and how close it is to the body.
#include "Data/ConversionResult.h"

#include "Body/BodyEdges.h"
#include "Data/Verdict.h"
#include "Ranks/Ranks.h"
#include "vtkCatmullClarkToBSplineVolume.h"

#include "vtkDoubleArray.h"
#include "vtkPoints.h"

#include <algorithm>
#include <sstream>

namespace bsv
{

WallPoints takeWallPoints(const BlockComplex& complex, const ConversionOptions& options, const EntityRules& rules,
  int inputPoints, const BoundaryPatterns& patterns, BodyFitOptions fit, const Execution& run)
{
  using Filter = vtkCatmullClarkToBSplineVolume;
  const bool wall = std::any_of(complex.faces.begin(), complex.faces.end(), [&](const ComplexFace& face) {
    return face.boundary() && face.tag >= 0 && options.roles[face.tag] == BoundaryRole::Body;
  });
  if (!wall && (options.body || inputPoints >= Filter::ON_BODY))
  {
    throw Error(std::string(options.body ? "there is a Body" : "Input Points is OnBody or LeastSquares") +
      ", but no boundary of the mesh is part of it: Body Boundaries are " + quotedList(patterns) +
      ", the mesh has the boundaries " + quotedList(complex.boundaryNames) +
      (complex.boundaryNames.empty() && options.body
          ? ", and no block face lies on the Body (is the length unit the same?)"
          : "") +
      "; Body Faces chooses block faces");
  }

  WallPoints result;
  result.onBody = inputPoints >= Filter::ON_BODY;
  fit.leastSquares = inputPoints == Filter::LEAST_SQUARES;
  std::ostringstream text;
  if (options.body)
  {
    const WallDistances distances = wallDistances(complex, rules, *options.body, run);
    text << "body of " << options.body->patches().size() << " patches: " << distances.wallPoints
         << " wall points, largest distance of the points " << distances.inputPoints
         << ", of their Catmull-Clark limit points " << distances.limitPoints << '\n';
    result.distance = distances.limitPoints;
    if (inputPoints == Filter::AUTOMATIC)
    {
      result.onBody = distances.inputPoints <= distances.limitPoints;
    }
  }
  text << "input points taken as " << (fit.leastSquares ? "LeastSquares" : result.onBody ? "OnBody" : "ControlNet");
  if (inputPoints == Filter::AUTOMATIC)
  {
    text << ", chosen automatically" << (options.body ? "" : ", as always without a body");
  }
  text << '\n';
  if (result.onBody || options.body)
  {
    fit.edgesOnly = !result.onBody;
    result.fit = solveFit(complex, options, rules, fit, run);
    const BodyFitReport& report = result.fit->report;
    result.distance = result.onBody ? report.residual : result.distance;
    result.displacement = report.displacement;
    text << (result.onBody ? "wall" : "creases and borders of the wall") << " fitted in " << report.iterations
         << " iterations: limit points within " << report.residual << " of their targets, before "
         << report.initialResidual << "; wall points moved by up to " << report.displacement << '\n';
    if (fit.leastSquares)
    {
      text << "between its mesh points the wall is off the body by at most " << report.sampleDistance[1] << ", RMS "
           << report.sampleRms[1] << "; before " << report.sampleDistance[0] << ", RMS " << report.sampleRms[0] << '\n';
    }
    const Index blunt = result.onBody ? bluntPoints(complex, rules, *run.ranks) : 0;
    if (blunt > 0)
    {
      text << "wall cells differ by more than 4 : 1 across a bend of more than 45 degrees at " << blunt
           << " wall points: interpolation overshoots there, a crease (Crease Angle 30 to 50) does not\n";
    }
  }
  result.report = text.str();
  return result;
}

BodyDistance wallDistance(
  const ConvertedMesh& conversion, const ConversionOptions& options, const BodySurface& body, const Execution& run)
{
  std::vector<BSplineVolume> volumes(conversion.nets.size());
  std::vector<VolumeFace> faces;
  for (const ComplexFace& face : conversion.complex.faces)
  {
    const FaceUse& use = face.uses.front();
    vtkStructuredGrid* net = conversion.nets[use.block];
    if (net && roleOf(options, face) == BoundaryRole::Body)
    {
      BSplineVolume& volume = volumes[use.block];
      volume.knots = conversion.knots[use.block];
      volume.points = vtkDoubleArray::SafeDownCast(net->GetPoints()->GetData())->GetPointer(0);
      faces.push_back({ &volume, use.face });
    }
  }
  return bodyDistance(faces, body, run);
}

std::vector<std::string> wallSentences(const WallPoints& wall, bool hasBody, const BodyDistance& distance)
{
  if (!hasBody)
  {
    return { wall.onBody ? "Wall: within " + shortNumber(wall.distance) + " of the mesh points"
                         : "Wall: no body given" };
  }
  std::string text = "Wall: within " + shortNumber(distance.largest) + " of the body";
  if (distance.inEdges > 0.0)
  {
    text += ", " + shortNumber(100.0 * distance.inEdges) + " % of an edge";
  }
  if (distance.largest > 0.0)
  {
    text += " at";
    for (const double x : distance.where)
    {
      text += ' ' + shortNumber(x);
    }
  }
  std::vector<std::string> sentences{ text };
  if (wall.displacement > 0.0)
  {
    sentences.push_back("Wall points: moved by at most " + shortNumber(wall.displacement));
  }
  return sentences;
}

} // namespace bsv

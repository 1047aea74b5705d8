// SPDX-License-Identifier: BSD-3-Clause
/// @file ConversionResult.h
/// A conversion as vtkCatmullClarkToBSplineVolume shows it: control nets as grids (ConversionNets.cxx), what became of
/// the wall (ConversionWall.cxx), and the report (ConversionText.cxx).
#pragma once

#include "Complex/BlockComplex.h"
#include "Complex/EntityClass.h"
#include "Conversion/Conversion.h"
#include "Data/BoundaryPatterns.h"
#include "Wall/BodyDistance.h"
#include "Wall/BodyFit.h"

#include "vtkSmartPointer.h"
#include "vtkStructuredGrid.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

class vtkPartitionedDataSetCollection;

namespace bsv
{

/// What InputPoints means for one mesh and body.
struct WallPoints
{
  bool onBody = false;
  /// Displacements of the wall's points, if they are moved.
  std::optional<WallFit> fit;
  /// Largest distance of a limit point of the wall from the body, or from its target; and how far points were moved.
  double distance = 0.0;
  double displacement = 0.0;
  /// How it was decided, and what the fit did, one sentence each.
  std::string report;
};

/// Three coordinates and a rule.
constexpr double BytesPerControlPoint = 3 * sizeof(double) + 1;

/// One attempt at the conversion.
struct ConvertedMesh
{
  /// With the wall as it was fitted.
  BlockComplex complex;
  WallPoints wallPoints;
  /// Shares of the displacements of wall points; empty: all 1.
  std::vector<double> shares;
  std::vector<vtkSmartPointer<vtkStructuredGrid>> nets;
  std::vector<std::array<std::vector<double>, 3>> knots;
  ConversionReport counts;
  WallMotion motion;
};

/// Grid for the control points of a block, with everything but their values.
vtkSmartPointer<vtkStructuredGrid> controlNet(
  const ComplexBlock& block, const std::array<std::vector<double>, 3>& knots, ControlNetStorage& storage);

/// Joins the pieces that creases alone made. Collective.
void joinBlocks(ConvertedMesh& conversion, const std::vector<ControlNetStorage>& storage, const Execution& run);

void setContacts(vtkPartitionedDataSetCollection* volume, const BlockComplex& complex);

/// The crease lines of a mesh in the control nets of its converted blocks, which may be pieces of those of the mesh:
/// each piece gets the part that lies in it.
std::vector<CreaseLine> creasesOfNets(const std::vector<CreaseLine>& creases, const BlockComplex& complex,
  const std::vector<std::array<std::vector<double>, 3>>& knots);

/// Decides how the wall's points are taken, and fits its control mesh: all of it if they lie on the body, else along
/// the edges of the body.
WallPoints takeWallPoints(const BlockComplex& complex, const ConversionOptions& options, const EntityRules& rules,
  int inputPoints, const BoundaryPatterns& patterns, BodyFitOptions fit, const Execution& run);

/// Of the converted wall. Collective.
BodyDistance wallDistance(
  const ConvertedMesh& conversion, const ConversionOptions& options, const BodySurface& body, const Execution& run);

/// How close the wall is to the body.
std::vector<std::string> wallSentences(const WallPoints& wall, bool hasBody, const BodyDistance& distance);

std::string triple(const char* separator, int a, int b, int c);

/// How far the converted wall is from the mesh.
std::string motionText(const WallMotion& motion, bool onBody);

/// What the fit gave up for valid spans.
std::string shareText(const std::vector<double>& shares);

std::string reportText(const BlockComplex& complex, const EntityClasses& classes, const ConversionOptions& options,
  const WallPoints& wallPoints, const ConversionReport& counts,
  const std::vector<std::array<std::vector<double>, 3>>& knots);

/// What became of the checked spans.
std::string spanText(const BlockComplex& complex, const ConversionOptions& options, const SpanReport& spans);

/// What each of several ranks had to do.
std::string rankText(const BlockComplex& complex, const std::vector<Index>& received);

} // namespace bsv

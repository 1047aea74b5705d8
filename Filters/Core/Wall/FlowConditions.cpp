// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/FlowConditions.h"

#include "Mesh/BlockSurface.h"

#include <algorithm>
#include <cmath>

namespace bsv
{
namespace
{

constexpr double Gamma = 1.4;
constexpr double GasConstant = 287.05287;

} // namespace

double sutherlandViscosity(double temperature)
{
  return 1.458e-6 * temperature * std::sqrt(temperature) / (temperature + 110.4);
}

ReferenceState referenceState(const FlowConditions& flow)
{
  const auto check = [](double value, const char* name) {
    if (!(value > 0.0 && std::isfinite(value)))
    {
      throw Error(std::string(name) + " " + text(value) + " is not above 0");
    }
  };
  check(flow.reynoldsNumber, "Reynolds Number");
  check(flow.machNumber, "Mach Number");
  check(flow.referenceLength, "Reference Length");
  check(flow.lengthUnit, "Length Unit");
  check(flow.temperature, "Temperature");
  check(flow.prandtlNumber, "Prandtl Number");
  if (!(flow.viscosity >= 0.0 && std::isfinite(flow.viscosity)))
  {
    throw Error("Viscosity " + text(flow.viscosity) + " is not at least 0");
  }
  if (!(flow.transition >= 0.0))
  {
    throw Error("Transition Location " + text(flow.transition) + " is not at least 0");
  }
  const double machSquared = flow.machNumber * flow.machNumber;
  ReferenceState state;
  state.soundSpeed = std::sqrt(Gamma * GasConstant * flow.temperature);
  state.velocity = flow.machNumber * state.soundSpeed;
  state.viscosity = flow.viscosity > 0.0 ? flow.viscosity : sutherlandViscosity(flow.temperature);
  const double length = flow.referenceLength * flow.lengthUnit;
  state.density = flow.reynoldsNumber * state.viscosity / (state.velocity * length);
  state.pressure = state.density * GasConstant * flow.temperature;
  state.conductivity = state.viscosity * Gamma * GasConstant / (Gamma - 1.0) / flow.prandtlNumber;
  state.time = length / state.velocity;
  state.viscousCoefficient = 1.0 / flow.reynoldsNumber;
  state.heatCoefficient = 1.0 / ((Gamma - 1.0) * machSquared * flow.reynoldsNumber * flow.prandtlNumber);
  state.pressureCoefficient = 1.0 / (Gamma * machSquared);
  return state;
}

PlateLayer plateLayer(const FlowConditions& flow, double x)
{
  const auto reynoldsAt = [&](double at) { return flow.reynoldsNumber * at / flow.referenceLength; };
  const auto laminar = [&](double at) { return at > 0.0 ? 5.0 * at / std::sqrt(reynoldsAt(at)) : 0.0; };
  PlateLayer layer;
  layer.distance = x;
  layer.reynolds = reynoldsAt(x);
  layer.turbulent = x > flow.transition;
  if (layer.turbulent)
  {
    const double root = std::pow(layer.reynolds, 0.2);
    layer.thickness = std::max(0.37 * (x - flow.transition) / root, laminar(flow.transition));
    layer.skinFriction = 0.0592 / root;
  }
  else
  {
    layer.thickness = laminar(x);
    layer.skinFriction = 0.664 / std::sqrt(layer.reynolds);
  }
  return layer;
}

double yPlus(const FlowConditions& flow, double skinFriction, double height)
{
  return height * flow.reynoldsNumber * std::sqrt(0.5 * skinFriction) / flow.referenceLength;
}

double heightOf(const FlowConditions& flow, double skinFriction, double yPlus)
{
  return yPlus * flow.referenceLength / (flow.reynoldsNumber * std::sqrt(0.5 * skinFriction));
}

} // namespace bsv

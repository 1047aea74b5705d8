// SPDX-License-Identifier: BSD-3-Clause
/// @file FlowConditions.h
/// Reference quantities of a flow, and what a flat-plate boundary layer tells about the mesh at a wall.
///
/// Sources:
/// - U.S. Standard Atmosphere, 1976 (NOAA-S/T 76-1562): gas constant and Sutherland's formula of air;
/// - H. Schlichting, K. Gersten, Boundary-Layer Theory, 9th ed., Springer 2017, doi:10.1007/978-3-662-52919-5: flat
///   plates, chapters 6 (laminar) and 18 (turbulent);
/// - F. M. White, Viscous Fluid Flow, 3rd ed., McGraw-Hill 2006: the same in sections 4-3.1 and 6-6.
#pragma once

#include "Base/Types.h"

#include <string>
#include <vector>

namespace bsv
{

struct FlowConditions
{
  /// Re = rho U L / mu of the free stream, > 0.
  double reynoldsNumber = 1e6;
  /// M = U / a of the free stream, > 0.
  double machNumber = 0.2;
  /// L in the length unit of the mesh, > 0.
  double referenceLength = 1.0;
  /// Metres per length unit of the mesh, > 0; only for density, pressure and the like.
  double lengthUnit = 1.0;
  /// Static temperature of the free stream, kelvin, > 0.
  double temperature = 288.15;
  /// Dynamic viscosity of the free stream, Pa s; 0: by Sutherland's formula.
  double viscosity = 0.0;
  /// Pr = mu c_p / k, > 0.
  double prandtlNumber = 0.72;
  /// Distance from the leading edge at which the layer turns turbulent, length unit of the mesh, >= 0. Infinite: never.
  double transition = 0.0;
};

/// The free stream as dimensional reference quantities (SI), and the coefficients that remain in the Navier-Stokes
/// equations made dimensionless with rho, U, L, T and mu of the free stream.
///
/// Perfect gas, gamma = 1.4, R = 287.05287 J/(kg K): p = rho R T, a = sqrt(gamma R T), c_p = gamma R / (gamma - 1).
struct ReferenceState
{
  double soundSpeed = 0.0;   ///< a, m/s
  double velocity = 0.0;     ///< U = M a, m/s
  double viscosity = 0.0;    ///< mu, Pa s
  double density = 0.0;      ///< rho = Re mu / (U L), kg/m^3
  double pressure = 0.0;     ///< p = rho R T, Pa
  double conductivity = 0.0; ///< k = mu c_p / Pr, W/(m K)
  double time = 0.0;         ///< L / U, s
  /// Coefficient of the viscous stresses: 1 / Re.
  double viscousCoefficient = 0.0;
  /// Coefficient of the heat flux in the energy equation: 1 / ((gamma - 1) M^2 Re Pr).
  double heatCoefficient = 0.0;
  /// p / (rho U^2) = 1 / (gamma M^2).
  double pressureCoefficient = 0.0;
};

/// Dynamic viscosity of air in Pa s, mu = 1.458e-6 T^1.5 / (T + 110.4), T in kelvin (Standard Atmosphere, equation
/// (51)). Valid from about 100 K to 1900 K.
double sutherlandViscosity(double temperature);

/// @throws Error that names the property for values out of range.
ReferenceState referenceState(const FlowConditions& flow);

/// Boundary layer of a flat plate at one place.
struct PlateLayer
{
  double distance = 0.0; ///< x from the leading edge, length unit of the mesh
  double reynolds = 0.0; ///< Re_x = Re x / L
  bool turbulent = false;
  /// delta. Laminar: 5 x / sqrt(Re_x) (Blasius 1908; u = 0.99 U); turbulent: 0.37 (x - x_0) / Re_x^0.2 with x_0 where
  /// the layer turns turbulent (Prandtl, one-seventh power law), but not less than the laminar layer has there.
  double thickness = 0.0;
  /// c_f = tau_w / (rho U^2 / 2). Laminar: 0.664 / sqrt(Re_x) (Blasius); turbulent: 0.0592 / Re_x^0.2.
  double skinFriction = 0.0;
};

/// Incompressible formulas. Laminar ones hold for 1e3 < Re_x < 5e5 (up to 3e6 in a quiet stream), turbulent ones for
/// 5e5 < Re_x < 1e7; they are used beyond. `x` > 0.
PlateLayer plateLayer(const FlowConditions& flow, double x);

/// y+ = y u_tau / nu of a height, with u_tau = U sqrt(c_f / 2): y+ = y Re sqrt(c_f / 2) / L.
double yPlus(const FlowConditions& flow, double skinFriction, double height);
/// The height with a given y+, in the length unit of the mesh.
double heightOf(const FlowConditions& flow, double skinFriction, double yPlus);

} // namespace bsv

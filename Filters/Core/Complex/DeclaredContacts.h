// SPDX-License-Identifier: BSD-3-Clause
/// @file DeclaredContacts.h
/// The contacts and boundaries that a mesh declares.
#pragma once

#include "Complex/GluingPass.h"

namespace bsv
{

/// Checks and takes all declared interfaces and boundaries.
class DeclaredContacts : public GluingPass
{
public:
  explicit DeclaredContacts(const GluingPass& pass)
    : GluingPass(pass)
  {
  }
  /// Collective. @throws Error for declarations out of bounds, overlapping or not matching the coordinates.
  void operator()();

private:
  void checkRange(const std::string& what, int block, int face, const FaceRange& range) const;
  /// Compares declared contacts. Mostly one layer of points, which are the same, is all that other ranks must send.
  std::vector<Comparison> compareDeclared();
  void takeInterfaces();
  void takeBoundary(int n);
};

} // namespace bsv

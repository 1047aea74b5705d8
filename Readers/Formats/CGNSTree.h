// SPDX-License-Identifier: BSD-3-Clause
/// @file CGNSTree.h
/// A look at the nodes of a CGNS file before the CGNS library loads them: it ends the process if a node claims more
/// data than there is memory, and overruns its buffers if one has a type it does not know.
#pragma once

#include <set>
#include <string>

namespace bsv
{

/// Checks type, dimensions and data size of every node against the size of the file. Linked nodes are not followed.
/// @return paths of boundary conditions without any points, at which some versions of the library refuse the file
/// @throws Error naming file, node and value.
std::set<std::string> checkCGNSTree(const std::string& fileName);

} // namespace bsv

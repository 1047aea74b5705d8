// SPDX-License-Identifier: BSD-3-Clause
/// @file NURBSSurfaceFile.h
/// Files of untrimmed NURBS patches: GoTools `.g2` (class 200) and IGES 5.3 (entity 128).
#pragma once

#include "Body/NURBSSurface.h"

#include <string>
#include <vector>

namespace bsv
{

/// Writes the patches in the format that the file's extension names: g2, igs, iges. Numbers are the shortest that read
/// back to the same double. Patches whose outward normal is -(x_u x x_v) are written with u reversed, since the formats
/// do not know of it. IGES files declare metres, and hold the first eight characters of the names.
/// @throws Error for another extension, patches that are trimmed, and what AtomicFile refuses.
void writeNURBSSurfaceFile(const std::vector<BodyPatch>& patches, const std::string& fileName);

} // namespace bsv

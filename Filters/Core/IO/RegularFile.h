// SPDX-License-Identifier: BSD-3-Clause
/// @file RegularFile.h
/// What can be read: opening a pipe waits for someone who writes, and devices never end.
#pragma once

#include "Base/Types.h"

#include <filesystem>
#include <string>
#include <system_error>

namespace bsv
{

/// Never throws.
inline bool isRegularFile(const std::string& path)
{
  std::error_code failure;
  return std::filesystem::is_regular_file(path, failure);
}

/// @throws Error that names the file if it does not exist or is a folder, a pipe or a device.
inline void requireRegularFile(const std::string& path)
{
  if (!isRegularFile(path))
  {
    std::error_code failure;
    throw Error(path + (std::filesystem::exists(path, failure) ? ": not a regular file" : ": no such file"));
  }
}

} // namespace bsv

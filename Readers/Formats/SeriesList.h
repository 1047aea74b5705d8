// SPDX-License-Identifier: BSD-3-Clause
/// @file SeriesList.h
/// Lists of the files of a series, ParaView's `.series` files: {"files": [{"name": .., "time": ..}, ..]}.
#pragma once

#include <string>
#include <vector>

namespace bsv
{

/// A file of a list; without a time, its place in the list.
struct SeriesFile
{
  std::string name;
  double time;
};

/// Whether the name ends in `.series`.
bool isSeriesList(const std::string& fileName);

/// The files in their order; names without a folder are beside the list.
/// @throws Error naming the list and the line, also if it names no file or times do not ascend.
std::vector<SeriesFile> readSeriesList(const std::string& fileName);

} // namespace bsv

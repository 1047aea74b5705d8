// SPDX-License-Identifier: BSD-3-Clause
/// @file HOPRFile.h
/// HOPR's file as HDF5 has it, written in a process of its own (LibraryFile.h).
#pragma once

#include "Formats/LibraryFile.h"

#include <cstdint>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

namespace bsv
{

enum class HDF5Type
{
  Integer, ///< 32 bits
  Real,    ///< 64 bits
  Text     ///< HOPRLibrary::TextLength characters, padded with spaces
};

/// What is asked of the HDF5 library.
class HOPRLibrary
{
public:
  static constexpr const char* Name = "HOPR";
  static constexpr std::size_t TextLength = 255;
  static constexpr auto methods()
  {
    return std::make_tuple(&HOPRLibrary::number, &HOPRLibrary::count, &HOPRLibrary::create, &HOPRLibrary::integers,
      &HOPRLibrary::reals, &HOPRLibrary::texts);
  }

  HOPRLibrary(const std::string& path, const std::string& target);
  ~HOPRLibrary();
  HOPRLibrary(const HOPRLibrary&) = delete;
  HOPRLibrary& operator=(const HOPRLibrary&) = delete;

  /// Attributes.
  void number(const std::string& name, double value);
  void count(const std::string& name, int value);
  /// A data set of rows. @param columns 0: one value a row
  void create(const std::string& name, HDF5Type type, Index rows, int columns);
  /// Writes the rows [first, first + count).
  void integers(const std::string& name, Index first, Index count, int columns, const std::vector<int>& values);
  void reals(const std::string& name, Index first, Index count, int columns, const std::vector<double>& values);
  void texts(const std::string& name, Index first, Index count, int columns, const std::vector<char>& values);
  std::string close();

private:
  void check(std::int64_t status, const std::string& what) const;
  void attribute(const std::string& name, HDF5Type type, const void* value);
  void rows(const std::string& name, HDF5Type type, Index first, Index count, int columns, const void* values);

  std::string Path;
  std::string Target;
  std::int64_t File = -1;
  /// Brings back what the library does with errors elsewhere.
  std::function<void()> Restore;
};

using HOPRFile = LibraryFile<HOPRLibrary>;

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
/// @file AtomicFile.h
/// A file that appears complete or not at all.
#pragma once

#include "Types.h"

#include <string>
#include <vector>

namespace bsv
{

/// Writes beside the target, under a temporary name, and renames at the end. Until then, and after any error, an
/// existing target is untouched; the temporary file is removed when the object goes. A symbolic link is followed, an
/// existing file's permissions are kept.
class AtomicFile
{
public:
  /// @throws Error if no file can be made there, or the target is no regular file.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Room for at least `size` characters in the buffer, which advance() then takes.
  char* room(std::size_t size);
  void advance(const char* end) { this->Used = static_cast<std::size_t>(end - this->Buffer.data()); }
  void write(const std::string& text) { this->write(text.data(), text.size()); }
  /// Large pieces are not copied.
  void write(const char* data, std::size_t size);

  /// Everything written is on the disk. @throws Error, for example for a full disk.
  void finish();
  /// Gives the finished file its name. @throws Error
  void publish();

private:
  void flush();
  void put(const char* data, std::size_t size);
  [[noreturn]] void fail(const std::string& what) const;

  std::string Target;
  std::string Temporary;
  int Descriptor = -1;
  std::vector<char> Buffer;
  std::size_t Used = 0;
};

} // namespace bsv

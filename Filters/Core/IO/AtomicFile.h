// SPDX-License-Identifier: BSD-3-Clause
/// @file AtomicFile.h
/// A file that appears complete or not at all.
#pragma once

#include "Base/Types.h"
#include "Ranks/Ranks.h"

#include <string>
#include <vector>

namespace bsv
{

/// The operating system refused to create, write or replace a file.
class FileError : public Error
{
public:
  /// @param code the value of errno
  FileError(const std::string& text, int code);
  /// With the complete text of another one.
  FileError(const std::string& text, bool noRoom)
    : Error(text)
    , NoRoom(noRoom)
  {
  }
  /// Whether there was no room for the file: a full disk, a quota, a limit on the size of files.
  bool noRoom() const { return this->NoRoom; }

private:
  bool NoRoom;
};

/// Characters on their way out, collected into large pieces.
class OutputBuffer
{
public:
  OutputBuffer()
    : Buffer(std::size_t(1) << 20)
  {
  }
  virtual ~OutputBuffer() = default;
  OutputBuffer(const OutputBuffer&) = delete;
  OutputBuffer& operator=(const OutputBuffer&) = delete;

  /// Room for at least `size` characters in the buffer, which advance() then takes.
  char* room(std::size_t size);
  void advance(const char* end) { this->Used = static_cast<std::size_t>(end - this->Buffer.data()); }
  void write(const std::string& text) { this->write(text.data(), text.size()); }
  /// Large pieces are not copied.
  void write(const char* data, std::size_t size);
  void flush();

protected:
  virtual void put(const char* data, std::size_t size) = 0;

private:
  std::vector<char> Buffer;
  std::size_t Used = 0;
};

/// Counts the characters and drops them.
class CharacterCount : public OutputBuffer
{
public:
  /// Of all that was written.
  Index count()
  {
    this->flush();
    return this->Count;
  }

protected:
  void put(const char*, std::size_t size) override { this->Count += static_cast<Index>(size); }

private:
  Index Count = 0;
};

/// Writes beside the target, under a temporary name, and renames at the end. Until then, and after any error, an
/// existing target is untouched; the temporary file is removed when the object goes, and one that a killed process has
/// left when the same target is written again. A symbolic link is followed, even if it points to nothing yet; an
/// existing file's permissions are kept.
///
/// Several ranks can write to one file: each opens it, seeks the places of its parts, and finishes; rank 0 then
/// publishes it.
class AtomicFile : public OutputBuffer
{
public:
  /// Rank 0 makes the file, the others open it. Collective.
  /// @throws Error if no file can be made there, the target is no regular file, or a rank does not find it.
  explicit AtomicFile(const std::string& path, const Ranks& ranks = *aloneRank());
  ~AtomicFile() override;

  /// The file that will appear, with symbolic links followed.
  const std::string& target() const { return this->Target; }

  /// Goes on at `offset` characters from the start of the file.
  void seek(Index offset);
  /// Where the next character goes.
  Index position();

  /// @name For libraries that write files themselves, on rank 0 only
  ///@{
  /// The path to write to, in place of writing here. Whether the library replaces the file there does not matter.
  const std::string& temporaryPath() const { return this->Temporary; }
  /// @throws FileError if there is no room for so many bytes: some libraries do not survive a full disk.
  void requireRoom(double bytes) const;
  /// The library has closed its file: what it wrote is now the content. @throws Error
  void takeOver();
  ///@}

  /// Everything written here is on the disk. @throws Error, for example for a full disk.
  void finish();
  /// Gives the finished file its name; on rank 0 only. @throws Error
  void publish();

protected:
  void put(const char* data, std::size_t size) override;

private:
  void create();
  std::string withLinksFollowed(const std::string& path) const;
  void limitSize();
  void keepPermissions();
  void discard();
  [[noreturn]] void fail(const std::string& what) const;

  std::string Target;
  std::string Temporary;
  /// Permissions of the file that is replaced, or 0.
  unsigned int Mode = 0;
  /// Bytes that a file may have (RLIMIT_FSIZE), or -1.
  Index Largest = -1;
  bool Owner = true;
  int Descriptor = -1;
};

} // namespace bsv

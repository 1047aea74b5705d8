// SPDX-License-Identifier: BSD-3-Clause
/// @file Archive.h
/// Values in a row of bytes, for another process of the same program on the same machine.
#pragma once

#include "Base/Types.h"

#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

namespace bsv
{

/// Whether the bytes of a value are all of it. Eigen's fixed vectors do not say so.
template <typename Value>
struct IsBytes : std::is_trivially_copyable<Value>
{
};
template <int Rows>
struct IsBytes<Eigen::Matrix<double, Rows, 1>> : std::true_type
{
};

/// Writes values; ArchiveReader gives them back in the same order.
class ArchiveWriter
{
public:
  static constexpr bool IsReading = false;

  template <typename Value>
  void operator()(const Value& value)
  {
    static_assert(IsBytes<Value>::value, "bytes are the value");
    this->Bytes.append(reinterpret_cast<const char*>(&value), sizeof(Value));
  }
  void operator()(const std::string& text)
  {
    (*this)(static_cast<std::uint64_t>(text.size()));
    this->Bytes += text;
  }
  /// A list of any such values.
  template <typename Value>
  void operator()(const std::vector<Value>& values)
  {
    (*this)(static_cast<std::uint64_t>(values.size()));
    if constexpr (IsBytes<Value>::value)
    {
      this->Bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
    }
    else
    {
      for (const Value& value : values)
      {
        (*this)(value);
      }
    }
  }

  std::string take() { return std::move(this->Bytes); }

private:
  std::string Bytes;
};

class ArchiveReader
{
public:
  static constexpr bool IsReading = true;

  explicit ArchiveReader(const std::string& bytes)
    : Bytes(bytes)
  {
  }

  template <typename Value>
  void operator()(Value& value)
  {
    static_assert(IsBytes<Value>::value, "bytes are the value");
    std::memcpy(static_cast<void*>(&value), this->take(sizeof(Value)), sizeof(Value));
  }
  void operator()(std::string& text)
  {
    const std::uint64_t size = this->count(1);
    text.assign(this->take(size), size);
  }
  template <typename Value>
  void operator()(std::vector<Value>& values)
  {
    values.resize(this->count(IsBytes<Value>::value ? sizeof(Value) : 8));
    for (Value& value : values)
    {
      (*this)(value);
    }
  }

  /// The number of items that follow, which take at least so many bytes each.
  std::uint64_t count(std::size_t least)
  {
    std::uint64_t count = 0;
    (*this)(count);
    if (count > (this->Bytes.size() - this->At) / least)
    {
      throw Error("the result of another process is damaged");
    }
    return count;
  }

private:
  const char* take(std::size_t size)
  {
    if (size > this->Bytes.size() - this->At)
    {
      throw Error("the result of another process ends too early");
    }
    const char* at = this->Bytes.data() + this->At;
    this->At += size;
    return at;
  }

  const std::string& Bytes;
  std::size_t At = 0;
};

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
/// @file Files.h
/// Files and folders of a test.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

namespace bsvtest
{

/// A folder for this test alone, removed at its end.
class TemporaryFolder
{
public:
  TemporaryFolder()
  {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    this->Path = std::filesystem::temp_directory_path() /
      (std::string("bsv-") + test->test_suite_name() + "-" + test->name() + "-" +
        std::to_string(std::random_device()()));
    std::filesystem::create_directories(this->Path);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(this->Path); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  void operator=(const TemporaryFolder&) = delete;

  std::string operator/(const std::string& name) const { return (this->Path / name).string(); }
  std::string path() const { return this->Path.string(); }
  /// Files and folders in it.
  std::size_t files() const
  {
    return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(this->Path), std::filesystem::directory_iterator()));
  }

private:
  std::filesystem::path Path;
};

inline void writeFile(const std::string& fileName, const std::string& content)
{
  std::ofstream(fileName, std::ios::binary) << content;
}

inline std::string readFile(const std::string& fileName)
{
  std::ifstream stream(fileName, std::ios::binary);
  return { std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>() };
}

} // namespace bsvtest

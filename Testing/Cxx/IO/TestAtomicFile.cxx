// SPDX-License-Identifier: BSD-3-Clause
// A file appears whole or not at all, wherever its name leads, and nothing else stays beside it.
#include "IO/AtomicFile.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <string>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

using bsv::AtomicFile;
namespace fs = std::filesystem;

namespace
{

class AtomicFiles : public testing::Test
{
protected:
  void SetUp() override
  {
    std::string name = (fs::temp_directory_path() / "bsv-AtomicFile-XXXXXX").string();
    this->Folder = ::mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(this->Folder); }

  static void write(const fs::path& path, const std::string& text)
  {
    AtomicFile file(path.string());
    file.write(text);
    file.finish();
    file.publish();
  }
  static std::string read(const fs::path& path)
  {
    std::ifstream stream(path, std::ios::binary);
    return { std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>() };
  }
  std::set<std::string> names() const
  {
    std::set<std::string> all;
    for (const auto& entry : fs::directory_iterator(this->Folder))
    {
      all.insert(entry.path().filename().string());
    }
    return all;
  }
  /// Runs `work` in a process that then ends without a word. @return whether it came to its end.
  template <typename Work>
  static bool inLostProcess(const Work& work)
  {
    const pid_t child = ::fork();
    if (child == 0)
    {
      work();
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }

  fs::path Folder;
};

TEST_F(AtomicFiles, WhatKilledWritersLeftGoesWithTheNextWrite)
{
  const fs::path target = this->Folder / "mesh.xyz";
  write(target, "old");
  const auto lose = [](const fs::path& path) {
    ASSERT_TRUE(inLostProcess([&] {
      auto* file = new AtomicFile(path.string());
      file->write("half");
      file->flush();
    }));
  };
  lose(target);
  lose(target);
  lose(this->Folder / "other.xyz");
  EXPECT_EQ(this->names().size(), 3u) << "one of each";
  EXPECT_EQ(read(target), "old");
  {
    // A writer that is still there keeps its file.
    AtomicFile open(target.string());
    EXPECT_EQ(this->names().size(), 3u);
    write(target, "new");
    EXPECT_EQ(this->names().size(), 3u);
    open.write("newest");
    open.finish();
    open.publish();
  }
  EXPECT_EQ(read(target), "newest");
  EXPECT_EQ(this->names().size(), 2u) << "that of the other file";
  write(this->Folder / "other.xyz", "");
  EXPECT_EQ(this->names(), (std::set<std::string>{ "mesh.xyz", "other.xyz" }));
}

TEST_F(AtomicFiles, ForeignTemporaryFilesStayForADay)
{
  const fs::path target = this->Folder / "mesh.xyz";
  std::string name;
  {
    const AtomicFile file(target.string());
    name = fs::path(file.temporaryPath()).filename().string();
  }
  // mesh.xyz.<hash>.<machine>-<process>-<attempt>.tmp
  const std::size_t machine = name.rfind('.', name.size() - 5) + 1;
  name.replace(machine, 8, name.compare(machine, 8, "00000000") == 0 ? "00000001" : "00000000");
  std::ofstream(this->Folder / name) << "theirs";
  write(target, "");
  EXPECT_EQ(this->names().count(name), 1u);
  fs::last_write_time(this->Folder / name, fs::file_time_type::clock::now() - std::chrono::hours(25));
  write(target, "");
  EXPECT_EQ(this->names(), std::set<std::string>{ "mesh.xyz" });
}

TEST_F(AtomicFiles, LinksAreFollowed)
{
  fs::create_directory(this->Folder / "far");
  fs::create_symlink("far/file", this->Folder / "relative");
  fs::create_symlink(this->Folder / "relative", this->Folder / "chain");
  write(this->Folder / "chain", "made where nothing was");
  EXPECT_EQ(read(this->Folder / "far" / "file"), "made where nothing was");
  write(this->Folder / "chain", "replaced");
  EXPECT_EQ(read(this->Folder / "far" / "file"), "replaced");
  EXPECT_TRUE(fs::is_symlink(this->Folder / "relative") && fs::is_symlink(this->Folder / "chain"));

  fs::create_symlink("circle", this->Folder / "circle");
  EXPECT_THROW(write(this->Folder / "circle", ""), bsv::FileError);
  fs::create_symlink("nowhere/file", this->Folder / "lost");
  EXPECT_THROW(write(this->Folder / "lost", ""), bsv::FileError);
  fs::create_symlink("far", this->Folder / "folder");
  EXPECT_THROW(write(this->Folder / "folder", ""), bsv::Error);
}

TEST_F(AtomicFiles, NamesAreAsLongAsTheFileSystemTakes)
{
  const auto longest = static_cast<std::size_t>(::pathconf(this->Folder.c_str(), _PC_NAME_MAX));
  const std::string a(longest, 'a');
  std::string b = a;
  b.back() = 'b';
  AtomicFile first((this->Folder / a).string());
  write(this->Folder / b, "b");
  write(this->Folder / a, "a");
  EXPECT_EQ(read(this->Folder / a), "a");
  EXPECT_EQ(read(this->Folder / b), "b");
  EXPECT_EQ(this->names().size(), 3u);
  // At once, before anything is written.
  EXPECT_THROW(AtomicFile((this->Folder / (a + "a")).string()), bsv::FileError);
}

TEST_F(AtomicFiles, NoRoomIsSaidAndTheOldFileStays)
{
  const fs::path target = this->Folder / "mesh.xyz";
  write(target, "old");
  EXPECT_TRUE(inLostProcess([&] {
    const struct rlimit limit = { 3000000, 3000000 };
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const auto refused = [](const auto& work) {
      try
      {
        work();
        return false;
      }
      catch (const bsv::FileError& error)
      {
        return error.noRoom() && std::string(error.what()).find("mesh.xyz") != std::string::npos;
      }
    };
    // In large pieces, in small ones, and as a library asks.
    const bool large = refused([&] { write(target, std::string(3000001, 'x')); });
    const bool small = refused([&] {
      AtomicFile file(target.string());
      for (int n = 0; n < 40000; ++n)
      {
        file.write(std::string(100, 'x'));
      }
    });
    const bool library = refused([&] { AtomicFile(target.string()).requireRoom(3000001.0); });
    write(target.string() + "2", std::string(3000000, 'x'));
    ::_exit(large && small && library ? 0 : 1);
  }));
  EXPECT_EQ(read(target), "old");
  EXPECT_EQ(this->names(), (std::set<std::string>{ "mesh.xyz", "mesh.xyz2" }));
  try
  {
    AtomicFile(target.string()).requireRoom(1e30);
    ADD_FAILURE() << "there is no such disk";
  }
  catch (const bsv::FileError& error)
  {
    EXPECT_TRUE(error.noRoom());
    EXPECT_NE(std::string(error.what()).find("No space left"), std::string::npos) << error.what();
  }
}

} // namespace

// SPDX-License-Identifier: BSD-3-Clause
// Whatever happens in a process that reads a file, this one gets one error and goes on; nothing stays open.
#include "Execution/ChildProcess.h"

#include "Support/MeshFiles.h"

#include "Formats/CGNSZones.h"
#include "Formats/ReaderJobs.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>

#include <sys/wait.h>

using namespace bsv;

namespace
{

/// Runs a line of shell as a child.
std::optional<ChildResult> shell(
  const std::string& line, const ChildLimits& limits = {}, const Execution& run = Execution())
{
  return runChild("/bin/sh", { "-c", line }, "mesh.cgns", limits, run);
}

std::string failure(const std::string& line, const ChildLimits& limits = {})
{
  try
  {
    shell(line, limits);
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return {};
}

std::size_t openDescriptors()
{
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd"))
  {
    count += !entry.path().empty();
  }
  return count;
}

bool hasChildren()
{
  return waitpid(-1, nullptr, WNOHANG) >= 0;
}

} // namespace

TEST(ChildProcess, EveryEndIsOneError)
{
  const std::size_t before = openDescriptors();
  ChildLimits limits;
  limits.processorSeconds = 1.0;
  limits.idleSeconds = 0.5;
  limits.bytes = 3e8;
  const struct
  {
    const char* line;
    const char* word;
  } ends[] = {
    { "kill -SEGV $$", "segmentation fault" },
    { "kill -ABRT $$", "abort" },
    { "exit 3", "code 3" },
    { "exit 0", "failed" },
    { "while :; do :; done", "stopped" },
    { "exec sleep 100", "done nothing" },
    { "exec tail /dev/zero", "failed" },
    // More than it is to say, or something else.
    { "exec yes >&4", "failed" },
    { "printf 'D\\001\\000\\000\\000\\000\\000\\000\\000' >&4; exec yes >&4", "failed" },
    { "printf 'D\\020\\000\\000\\000\\000\\000\\000\\000ab' >&4", "failed" },
    { "printf 'E\\005\\000\\000\\000\\000\\000\\000\\000wrong' >&4", "wrong" },
  };
  for (const auto& end : ends)
  {
    const std::string text = failure(end.line, limits);
    EXPECT_NE(text.find(end.word), std::string::npos) << end.line << ": " << text;
    EXPECT_FALSE(hasChildren()) << end.line;
  }
  EXPECT_EQ(openDescriptors(), before);
}

TEST(ChildProcess, TextAndFileComeBack)
{
  const std::size_t before = openDescriptors();
  {
    const auto result = shell("yes | head -c 100000; printf 'D\\004\\000\\000\\000\\000\\000\\000\\000text' >&4");
    ASSERT_TRUE(result);
    EXPECT_EQ(result->message, "text");
    Index offset = 0;
    auto* written = static_cast<double*>(result->file.append(8000, offset));
    written[999] = 2.5;
    auto* seen = static_cast<double*>(result->file.section(offset, 8000));
    EXPECT_EQ(seen[999], 2.5);
    seen[999] = 3.5; // a copy of its own
    EXPECT_EQ(written[999], 2.5);
    SharedFile::release(written);
    SharedFile::release(seen);
    EXPECT_THROW(result->file.section(0, Index(1) << 30), Error);
  }
  EXPECT_EQ(openDescriptors(), before);
}

TEST(ChildProcess, AbortEndsIt)
{
  Execution run;
  int reports = 0;
  run.progress = [&](double) { return ++reports < 3; };
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THROW(shell("exec sleep 100", {}, run), Aborted);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
  EXPECT_FALSE(hasChildren());
}

TEST(ChildProcess, ProgramThatIsNotThere)
{
  EXPECT_FALSE(runChild("/no/such/program", {}, "mesh.cgns", {}, Execution()));
  EXPECT_TRUE(programBeside("NoSuchProgram").empty());
  EXPECT_FALSE(programBeside("BSplineVolumeReadFile").empty());
}

TEST(ChildProcess, ReadsTheSameAsThisProcess)
{
  meshfiles::TemporaryFolder folder;
  meshcases::MeshCase mesh = meshcases::cutBox({ 7, 3, 2 }, { { { 4 }, {}, {} } }, meshcases::wavy);
  mesh.boundaryNames = { "wall" };
  meshcases::declareAll(mesh);
  for (const bool isFloat : { false, true })
  {
    meshfiles::CGNSKind kind;
    kind.isFloat = isFloat;
    meshfiles::writeCGNS(mesh, folder / "mesh.cgns", kind);
    const CGNSZones here = loadCGNS(folder / "mesh.cgns");
    const CGNSZones there = loadCGNSApart(folder / "mesh.cgns", {}, {});
    EXPECT_TRUE(there.warnings.empty());
    ASSERT_EQ(there.blocks.size(), here.blocks.size());
    for (std::size_t b = 0; b < here.blocks.size(); ++b)
    {
      EXPECT_EQ(there.blocks[b].name, here.blocks[b].name);
      ASSERT_EQ(there.blocks[b].counts, here.blocks[b].counts);
      EXPECT_EQ(there.blocks[b].floats != nullptr, isFloat);
      for (Index v = 0; v < 3 * here.blocks[b].size(); ++v)
      {
        ASSERT_EQ(isFloat ? there.blocks[b].floats[v] : there.blocks[b].doubles[v],
          isFloat ? here.blocks[b].floats[v] : here.blocks[b].doubles[v]);
      }
    }
    EXPECT_EQ(there.interfaces.size(), here.interfaces.size());
    EXPECT_EQ(there.boundaryNames, here.boundaryNames);
    EXPECT_EQ(there.contacts.size(), here.contacts.size());
  }
}

TEST(ChildProcess, RefusedFilesLeaveNothingOpen)
{
  meshfiles::TemporaryFolder folder;
  const meshcases::MeshCase mesh = meshcases::cutBox({ 3, 2, 2 });
  for (const int type : { CG_FILE_ADF, CG_FILE_HDF5 })
  {
    meshfiles::writeCGNS(mesh, folder / "mesh.cgns", { type });
    std::string bytes = meshfiles::readFile(folder / "mesh.cgns");
    std::size_t replaced = 0;
    for (std::size_t at = bytes.find("CoordinateY"); at != std::string::npos; at = bytes.find("CoordinateY"))
    {
      bytes.replace(at, 11, "Coord\xff\xfenate");
      ++replaced;
    }
    ASSERT_GT(replaced, 0u);
    meshfiles::writeFile(folder / "bad.cgns", bytes);
    const std::size_t before = openDescriptors();
    for (int n = 0; n < 5; ++n)
    {
      meshfiles::refusal(folder / "bad.cgns");
    }
    EXPECT_EQ(openDescriptors(), before);
  }
}

// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/OpenFOAMOutput.h"

#include "Formats/PointNumbering.h"
#include "IO/TextOutput.h"
#include "Ranks/Ranks.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <limits>
#include <system_error>

namespace bsv
{

namespace
{

using Label = std::int32_t;

/// Corners (VTK's order) of the faces i min, i max, j min, j max, k min, k max, outward in a right-handed block.
constexpr int FaceCorners[6][4] = { { 0, 4, 7, 3 }, { 1, 2, 6, 5 }, { 0, 1, 5, 4 }, { 3, 7, 6, 2 }, { 0, 3, 2, 1 },
  { 4, 5, 6, 7 } };
constexpr Ijk CornerOffset[8] = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 0, 1 },
  { 1, 1, 1 }, { 0, 1, 1 } };

/// Rows of cells between two reports.
constexpr int ReportedRows = 64;

class CaseWriter
{
public:
  CaseWriter(const MeshToWrite& mesh, bool binary, const Execution& run)
    : Mesh(mesh)
    , Binary(binary)
    , Run(run)
    , Numbers(countsOf(mesh), mesh.interfaces, run)
    , Neighbours(countsOf(mesh), mesh.interfaces)
  {
    Index quads = 0;
    for (const BlockToWrite& block : mesh.blocks)
    {
      this->FirstCell.push_back(this->Cells);
      this->Cells += block.cellCount();
      for (int d = 0; d < 3; ++d)
      {
        quads += Index(block.counts[d]) * block.cells((d + 1) % 3) * block.cells((d + 2) % 3);
      }
    }
    Index contacts = 0;
    for (const Interface& contact : mesh.interfaces)
    {
      contacts += count(contact.rangeA);
    }
    Index outer = 0;
    for (const BoundaryPatch& patch : mesh.boundaries)
    {
      outer += count(patch.range);
    }
    this->Faces = quads - contacts;
    this->Inner = this->Faces - outer;
    const Index most = std::numeric_limits<Label>::max();
    if (this->Numbers.count() > most || 4 * this->Faces > most)
    {
      throw Error("the mesh has " + std::to_string(this->Numbers.count()) + " points and " +
        std::to_string(this->Faces) + " faces, more than labels of 32 bits can count");
    }
    this->sortPatches();
  }

  void write(FileGroup& files, const std::string& folder)
  {
    this->points(files.add(folder + "points"));
    this->faces(files.add(folder + "faces"));
    this->labels(files.add(folder + "owner"), "owner", true);
    this->labels(files.add(folder + "neighbour"), "neighbour", false);
    this->boundary(files.add(folder + "boundary"));
  }

  std::vector<std::string> notes;

private:
  static std::vector<Ijk> countsOf(const MeshToWrite& mesh)
  {
    std::vector<Ijk> counts;
    for (const BlockToWrite& block : mesh.blocks)
    {
      counts.push_back(block.counts);
    }
    return counts;
  }

  static Index count(const FaceRange& range) { return Index(range.hi[0] - range.lo[0]) * (range.hi[1] - range.lo[1]); }

  /// Boundaries by name, in the order of the names, the nameless last.
  void sortPatches()
  {
    std::vector<std::string> names = allowedNames(this->Mesh.boundaryNames, "_-+.:", 200);
    for (std::size_t n = 0; n < names.size(); ++n)
    {
      if (names[n] != this->Mesh.boundaryNames[n])
      {
        this->notes.push_back("boundary '" + this->Mesh.boundaryNames[n] + "' is patch '" + names[n] + "' in the case");
      }
    }
    for (int tag = 0; tag <= static_cast<int>(names.size()); ++tag)
    {
      const bool named = tag < static_cast<int>(names.size());
      Patch patch;
      patch.name = named ? names[tag] : "defaultFaces";
      const std::string type = named ? this->Mesh.boundaryTypes[tag] : "";
      patch.type = type.compare(0, 6, "BCWall") == 0 ? "wall" : type == "BCSymmetryPlane" ? "symmetry" : "patch";
      for (std::size_t b = 0; b < this->Mesh.boundaries.size(); ++b)
      {
        if (this->Mesh.boundaries[b].tag == (named ? tag : -1))
        {
          patch.parts.push_back(b);
          patch.faces += count(this->Mesh.boundaries[b].range);
        }
      }
      if (named || patch.faces > 0)
      {
        this->Patches.push_back(patch);
      }
    }
  }

  /// Writes text on rank 0 only.
  template <typename Write>
  void onFirst(AtomicFile& file, const Write& write) const
  {
    if (this->Run.ranks->rank() == 0)
    {
      TextOutput out(file);
      write(out);
    }
  }

  void header(AtomicFile& file, const std::string& kind, const std::string& object, bool counts = false) const
  {
    this->onFirst(file, [&](TextOutput& out) {
      out << "FoamFile\n{\n    version     2.0;\n    format      " << (this->Binary ? "binary" : "ascii") << ";\n";
      if (this->Binary)
      {
        out << "    arch        \"LSB;label=32;scalar=64\";\n";
      }
      out << "    class       " << kind << ";\n";
      if (counts)
      {
        out << "    note        \"nPoints: " << this->Numbers.count() << " nCells: " << this->Cells
            << " nFaces: " << this->Faces << " nInternalFaces: " << this->Inner << "\";\n";
      }
      out << "    location    \"constant/polyMesh\";\n    object      " << object << ";\n}\n\n";
    });
  }

  void begin(AtomicFile& file, Index size) const
  {
    this->onFirst(file, [&](TextOutput& out) { out << size << (this->Binary ? "\n(" : "\n(\n"); });
  }
  void end(AtomicFile& file) const
  {
    this->onFirst(file, [](TextOutput& out) { out << ")\n"; });
  }

  void points(AtomicFile& file) const
  {
    this->header(file, "vectorField", "points");
    this->begin(file, this->Numbers.count());
    std::vector<FilePart> parts;
    for (std::size_t b = 0; b < this->Mesh.blocks.size(); ++b)
    {
      const int id = static_cast<int>(b);
      const Index size = this->Numbers.firstOf(id + 1) - this->Numbers.firstOf(id);
      parts.push_back({ this->Mesh.blocks[b].rank, static_cast<double>(this->Mesh.blocks[b].size()),
        [this, id](OutputBuffer& out, const PartReport& report) { this->blockPoints(out, id, report); },
        this->Binary ? size * Index(3 * sizeof(double)) : -1 });
    }
    writeParts(file, parts, this->Run);
    this->end(file);
  }

  void blockPoints(OutputBuffer& out, int b, const PartReport& report) const
  {
    const BlockToWrite& block = this->Mesh.blocks[b];
    this->Numbers.forFirst(b, [&](const Ijk& p) {
      if (p[0] == 1 && p[1] % ReportedRows == 1)
      {
        report(static_cast<double>(block.counts[0]) * (p[1] + double(block.counts[1]) * p[2]));
      }
      const Vec3 x = block.at(p[0], p[1], p[2]);
      if (this->Binary)
      {
        out.write(reinterpret_cast<const char*>(x.data()), 3 * sizeof(double));
        return;
      }
      char* to = out.room(100);
      *to++ = '(';
      for (int c = 0; c < 3; ++c)
      {
        to = std::to_chars(to, to + 30, x[c]).ptr;
        *to++ = c < 2 ? ' ' : ')';
      }
      *to++ = '\n';
      out.advance(to);
    });
  }

  Index cellNumber(int block, const Ijk& cell) const
  {
    const BlockToWrite& of = this->Mesh.blocks[block];
    return this->FirstCell[block] + cell[0] + Index(of.cells(0)) * (cell[1] + Index(of.cells(1)) * cell[2]);
  }

  /// Calls visit(face, owner, neighbour) for the inner faces that the cells of a block own, in their order.
  template <typename Visit>
  void innerFaces(int b, const PartReport& report, const Visit& visit) const
  {
    const BlockToWrite& block = this->Mesh.blocks[b];
    const Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
    const Index steps[3] = { 1, cells[0], Index(cells[0]) * cells[1] };
    Index own = this->FirstCell[b];
    int row = 0;
    for (int k = 0; k < cells[2]; ++k)
    {
      for (int j = 0; j < cells[1]; ++j)
      {
        if (row++ % ReportedRows == 0)
        {
          report(static_cast<double>(own - this->FirstCell[b]));
        }
        for (int i = 0; i < cells[0]; ++i, ++own)
        {
          const Ijk cell{ i, j, k };
          std::array<std::pair<Index, int>, 6> next;
          int found = 0;
          for (int face = 0; face < 6; ++face)
          {
            const int d = faceDirection(face);
            if (cell[d] != (faceSide(face) ? cells[d] - 1 : 0))
            {
              if (faceSide(face))
              {
                next[found++] = { own + steps[d], face };
              }
              continue;
            }
            const FaceNeighbours::Neighbour other =
              this->Neighbours.across({ b, face, cell[faceAxis(face, 0)], cell[faceAxis(face, 1)] });
            if (other.quad.block >= 0)
            {
              const Index number = this->cellNumber(other.quad.block, this->Neighbours.cellAt(other.quad));
              // A cell that meets itself: the face is written once, from its lower side.
              if (number > own || (number == own && face < other.quad.face))
              {
                next[found++] = { number, face };
              }
            }
          }
          for (int n = 1; n < found; ++n)
          {
            for (int m = n; m > 0 && next[m] < next[m - 1]; --m)
            {
              std::swap(next[m], next[m - 1]);
            }
          }
          for (int n = 0; n < found; ++n)
          {
            visit(cell, next[n].second, own, next[n].first);
          }
        }
      }
    }
  }

  /// Point numbers of a face of a cell, outward.
  std::array<Label, 4> faceLabels(int b, const Ijk& cell, int face) const
  {
    std::array<Label, 4> labels{};
    for (int n = 0; n < 4; ++n)
    {
      const Ijk& offset = CornerOffset[FaceCorners[face][this->Mesh.blocks[b].leftHanded ? 3 - n : n]];
      labels[n] =
        static_cast<Label>(this->Numbers(b, { cell[0] + offset[0], cell[1] + offset[1], cell[2] + offset[2] }));
    }
    return labels;
  }

  template <typename Visit>
  void boundaryFaces(const BoundaryPatch& patch, const PartReport& report, const Visit& visit) const
  {
    Index done = 0;
    for (int t = patch.range.lo[1]; t < patch.range.hi[1]; ++t)
    {
      report(static_cast<double>(done));
      for (int s = patch.range.lo[0]; s < patch.range.hi[0]; ++s, ++done)
      {
        visit(this->Neighbours.cellAt({ patch.block, patch.face, s, t }));
      }
    }
  }

  /// Parts for what every face has, in the order of the faces. @param bytes of a binary face.
  template <typename WriteFace>
  std::vector<FilePart> faceParts(Index bytes, bool withBoundary, const WriteFace& writeFace) const
  {
    std::vector<FilePart> parts;
    for (std::size_t b = 0; b < this->Mesh.blocks.size(); ++b)
    {
      const int id = static_cast<int>(b);
      parts.push_back({ this->Mesh.blocks[b].rank, static_cast<double>(this->Mesh.blocks[b].cellCount()),
        [this, id, writeFace](OutputBuffer& out, const PartReport& report) {
          this->innerFaces(id, report,
            [&](const Ijk& cell, int face, Index own, Index other) { writeFace(out, id, cell, face, own, other); });
        },
        -1 });
    }
    for (const Patch& patch : this->Patches)
    {
      for (const std::size_t n : patch.parts)
      {
        const BoundaryPatch& part = this->Mesh.boundaries[n];
        if (withBoundary)
        {
          parts.push_back({ this->Mesh.blocks[part.block].rank, static_cast<double>(count(part.range)),
            [this, &part, writeFace](OutputBuffer& out, const PartReport& report) {
              this->boundaryFaces(part, report, [&](const Ijk& cell) {
                writeFace(out, part.block, cell, part.face, this->cellNumber(part.block, cell), Index(-1));
              });
            },
            this->Binary ? bytes * count(part.range) : -1 });
        }
      }
    }
    return parts;
  }

  void faces(AtomicFile& file) const
  {
    this->header(file, this->Binary ? "faceCompactList" : "faceList", "faces");
    if (this->Binary)
    {
      // Where the points of each face begin in the list of all.
      this->begin(file, this->Faces + 1);
      const Index size = this->Faces + 1;
      writeParts(file,
        { { 0, 1.0,
          [size](OutputBuffer& out, const PartReport& report) {
            for (Index f = 0; f < size; ++f)
            {
              constexpr Index Often = 1 << 16;
              if (f % Often == 0)
              {
                report(static_cast<double>(f) / static_cast<double>(size));
              }
              const Label start = static_cast<Label>(4 * f);
              out.write(reinterpret_cast<const char*>(&start), sizeof(Label));
            }
          },
          size * Index(sizeof(Label)) } },
        this->Run);
      this->end(file);
    }
    this->begin(file, this->Binary ? 4 * this->Faces : this->Faces);
    writeParts(file,
      this->faceParts(4 * sizeof(Label), true,
        [this](OutputBuffer& out, int b, const Ijk& cell, int face, Index, Index) {
          const std::array<Label, 4> labels = this->faceLabels(b, cell, face);
          if (this->Binary)
          {
            out.write(reinterpret_cast<const char*>(labels.data()), 4 * sizeof(Label));
            return;
          }
          char* to = out.room(60);
          *to++ = '4';
          for (int n = 0; n < 4; ++n)
          {
            *to++ = n == 0 ? '(' : ' ';
            to = std::to_chars(to, to + 12, labels[n]).ptr;
          }
          *to++ = ')';
          *to++ = '\n';
          out.advance(to);
        }),
      this->Run);
    this->end(file);
  }

  /// The cells on one side of all faces.
  void labels(AtomicFile& file, const std::string& object, bool owner) const
  {
    this->header(file, "labelList", object, true);
    this->begin(file, owner ? this->Faces : this->Inner);
    writeParts(file,
      this->faceParts(sizeof(Label), owner,
        [this, owner](OutputBuffer& out, int, const Ijk&, int, Index own, Index other) {
          const Label value = static_cast<Label>(owner ? own : other);
          if (this->Binary)
          {
            out.write(reinterpret_cast<const char*>(&value), sizeof(Label));
            return;
          }
          char* to = out.room(13);
          to = std::to_chars(to, to + 12, value).ptr;
          *to++ = '\n';
          out.advance(to);
        }),
      this->Run);
    this->end(file);
  }

  void boundary(AtomicFile& file) const
  {
    this->header(file, "polyBoundaryMesh", "boundary");
    this->onFirst(file, [&](TextOutput& out) {
      out << static_cast<int>(this->Patches.size()) << "\n(\n";
      Index start = this->Inner;
      for (const Patch& patch : this->Patches)
      {
        out << "    " << patch.name << "\n    {\n        type            " << patch.type
            << ";\n        nFaces          " << patch.faces << ";\n        startFace       " << start << ";\n    }\n";
        start += patch.faces;
      }
      out << ")\n";
    });
  }

  struct Patch
  {
    std::string name;
    std::string type;
    Index faces = 0;
    /// Indices of the mesh's boundaries.
    std::vector<std::size_t> parts;
  };

  const MeshToWrite& Mesh;
  const bool Binary;
  const Execution& Run;
  const PointNumbering Numbers;
  const FaceNeighbours Neighbours;
  std::vector<Index> FirstCell;
  std::vector<Patch> Patches;
  Index Cells = 0;
  Index Faces = 0;
  Index Inner = 0;
};

/// Files of the folder that the writer replaces.
bool isWritten(const std::string& name)
{
  const char* const names[] = { "points", "faces", "owner", "neighbour", "boundary" };
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

/// Names of the files of a folder that `chosen` takes, sorted; none if the folder cannot be read.
template <typename Chosen>
std::vector<std::string> filesOf(const std::filesystem::path& folder, const Chosen& chosen)
{
  std::vector<std::string> names;
  std::error_code failure;
  for (std::filesystem::directory_iterator at(folder, failure), end; !failure && at != end; at.increment(failure))
  {
    const std::string name = at->path().filename().string();
    if (chosen(at->path()))
    {
      names.push_back(name);
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// A case is a folder: a second file `.foam` in it would open the mesh of the one that was written last.
/// @throws Error if there is another one, and a mesh
void refuseAnotherCase(const std::filesystem::path& path, const std::string& folder)
{
  std::error_code failure;
  if (!std::filesystem::exists(folder + "points", failure))
  {
    return;
  }
  const std::vector<std::string> others =
    filesOf(std::filesystem::absolute(path, failure).parent_path(), [&](const std::filesystem::path& file) {
      return file.extension() == ".foam" && file.filename() != path.filename();
    });
  if (!others.empty())
  {
    throw Error("'" + path.string() + "': the folder holds the case '" + others[0] +
      "', whose mesh, constant/polyMesh, would be replaced; write to a folder of its own, or to '" + others[0] +
      "' to replace it");
  }
}

} // namespace

void writeOpenFOAM(const MeshToWrite& mesh, FileGroup& files, const std::string& path, bool binary,
  const Execution& run, std::vector<std::string>& notes)
{
  const std::string folder = (std::filesystem::path(path).parent_path() / "constant" / "polyMesh" / "").string();
  if (run.ranks->rank() == 0)
  {
    refuseAnotherCase(path, folder);
    std::error_code failure;
    if (!std::filesystem::create_directories(folder, failure) && failure)
    {
      throw FileError("Cannot create the folder '" + folder + "'", failure.value());
    }
    const std::vector<std::string> stale = filesOf(folder, [](const std::filesystem::path& file) {
      const std::string name = file.filename().string();
      return !isWritten(name) && name[0] != '.' && file.extension() != ".tmp";
    });
    if (!stale.empty())
    {
      notes.push_back("'" + folder + "' still holds '" + stale[0] + "'" +
        (stale.size() > 1 ? " and " + std::to_string(stale.size() - 1) + " more" : "") +
        ", which this writer does not replace; OpenFOAM may read that with the new mesh");
    }
  }
  CaseWriter output(mesh, binary, run);
  output.write(files, folder);
  // What ParaView opens.
  files.add(path);
  if (run.ranks->rank() == 0)
  {
    notes.insert(notes.end(), output.notes.begin(), output.notes.end());
  }
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
// The habits of programs that write meshes: the same mesh in other words is the same mesh, and what contradicts the
// mesh or is not needed is left out with a warning that names it.
#include "Support/MeshFiles.h"

#include "Conversion/Conversion.h"
#include "Data/BoundaryPatterns.h"
#include "Data/HexBlockData.h"

#include <vtkCellData.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdList.h>
#include <vtkInformation.h>
#include <vtkPointData.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>
#include <vtk_cgns.h>
// clang-format off
#include VTK_CGNS(cgns_io.h)
// clang-format on
#include <vtk_hdf5.h>

#include <functional>
#include <iostream>
#include <map>
#include <set>

using namespace meshfiles;
using bsv::BlockMesh;

namespace
{

/// Two blocks that meet in i = 4 of the first, all contacts declared.
MeshCase twoBlocks()
{
  MeshCase mesh = meshcases::cutBox({ 7, 3, 2 }, { { { 4 }, {}, {} } }, meshcases::wavy);
  meshcases::declareAll(mesh);
  mesh.boundaries.clear();
  mesh.boundaryNames.clear();
  return mesh;
}

struct Result
{
  std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
  BlockMesh mesh;
  std::vector<std::string> warnings;
};

Result readMesh(const std::string& fileName)
{
  Reading reading;
  read(reading, fileName);
  EXPECT_TRUE(reading.errors.empty()) << reading.errors[0];
  Result result;
  result.mesh = bsv::structuredBlocks(reading.output, result.grids);
  result.warnings = reading.warnings;
  return result;
}

/// Quadrilaterals by name and type.
std::map<std::string, std::vector<std::array<int, 4>>> boundaries(const BlockMesh& mesh)
{
  std::map<std::string, std::vector<std::array<int, 4>>> quads;
  for (const bsv::BoundaryPatch& patch : mesh.boundaries)
  {
    const std::string type = mesh.boundaryTypes.empty() ? "" : mesh.boundaryTypes[patch.tag];
    auto& list = quads[mesh.boundaryNames[patch.tag] + ": " + type];
    for (int t = patch.range.lo[1]; t < patch.range.hi[1]; ++t)
    {
      for (int s = patch.range.lo[0]; s < patch.range.hi[0]; ++s)
      {
        list.push_back({ patch.block, patch.face, s, t });
      }
    }
  }
  for (auto& [name, list] : quads)
  {
    std::sort(list.begin(), list.end());
  }
  return quads;
}

std::vector<bsv::BoundaryRole> roles(const BlockMesh& mesh)
{
  bsv::BlockComplex complex;
  complex.boundaryNames = mesh.boundaryNames;
  complex.boundaryTypes = mesh.boundaryTypes;
  return bsv::boundaryRoles(complex, bsv::defaultBodyBoundaries(), bsv::defaultSymmetryBoundaries());
}

bool mentions(const std::vector<std::string>& texts, const std::vector<std::string>& words)
{
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& text) {
    return std::all_of(
      words.begin(), words.end(), [&](const std::string& word) { return text.find(word) != std::string::npos; });
  });
}

//----------------------------------------------------------------------------------------------------------------------
// CGNS

using BCType = CGNS_ENUMT(BCType_t);

/// Writes the mesh, and `change` more into it.
template <typename Change>
void writeChanged(const MeshCase& mesh, const std::string& fileName, const Change& change, int type = CG_FILE_HDF5)
{
  writeCGNS(mesh, fileName, { type });
  int file = 0;
  require(cg_open(fileName.c_str(), CG_MODE_MODIFY, &file));
  change(file);
  require(cg_close(file));
}

void condition(int file, int zone, const std::string& name, BCType type, const std::vector<cgsize_t>& points,
  const std::string& family = "", CGNS_ENUMT(PointSetType_t) set = CGNS_ENUMV(PointRange),
  CGNS_ENUMT(GridLocation_t) location = CGNS_ENUMV(Vertex))
{
  int id = 0;
  require(cg_boco_write(
    file, 1, zone, name.c_str(), type, set, static_cast<cgsize_t>(points.size() / 3), points.data(), &id));
  if (location != CGNS_ENUMV(Vertex))
  {
    require(cg_boco_gridlocation_write(file, 1, zone, id, location));
  }
  if (!family.empty())
  {
    require(cg_goto(file, 1, "Zone_t", zone, "ZoneBC_t", 1, "BC_t", id, "end"));
    require(cg_famname_write(family.c_str()));
  }
}

void family(int file, const std::string& name, BCType type)
{
  int id = 0;
  int condition = 0;
  require(cg_family_write(file, 1, name.c_str(), &id));
  require(cg_fambc_write(file, 1, id, "FamBC", type, &condition));
}

void deleteNode(int file, const std::string& parent, const char* name)
{
  int io = 0;
  double root = 0.0;
  double id = 0.0;
  double child = 0.0;
  require(cg_get_cgio(file, &io));
  require(cgio_get_root_id(io, &root));
  require(cgio_get_node_id(io, root, parent.c_str(), &id));
  require(cgio_get_node_id(io, id, name, &child));
  require(cgio_delete_node(io, id, child));
}

/// Turns what the library writes in integers of 8 bytes into integers of 4 bytes.
void narrowIntegers(int file, double node)
{
  int children = 0;
  require(cgio_number_children(file, node, &children));
  for (int c = 1; c <= children; ++c)
  {
    double id = 0.0;
    int found = 0;
    std::array<char, 64> type{};
    require(cgio_children_ids(file, node, c, 1, &found, &id));
    require(cgio_get_data_type(file, id, type.data()));
    if (std::string(type.data()) == "I8")
    {
      int dimensions = 0;
      std::array<cgsize_t, 12> counts{};
      require(cgio_get_dimensions(file, id, &dimensions, counts.data()));
      cgsize_t size = 1;
      for (int d = 0; d < dimensions; ++d)
      {
        size *= counts[d];
      }
      std::vector<std::int64_t> wide(static_cast<std::size_t>(size));
      require(cgio_read_all_data_type(file, id, "I8", wide.data()));
      const std::vector<std::int32_t> narrow(wide.begin(), wide.end());
      require(cgio_set_dimensions(file, id, "I4", dimensions, counts.data()));
      require(cgio_write_all_data(file, id, narrow.data()));
    }
    narrowIntegers(file, id);
  }
}

} // namespace

TEST(MeshFileHabits, NodesThatTheLibraryDoesNotSeeAreAnError)
{
  TemporaryFolder folder;
  const std::string fileName = folder / "mesh.cgns";
  writeChanged(twoBlocks(), fileName, [](int file) {
    condition(file, 1, "skin", CGNS_ENUMV(BCWall), { 1, 1, 1, 5, 4, 1 });
  });
  // The group anew, as programs make it that do not ask HDF5 to keep the order of its members.
  const hid_t file = H5Fopen(fileName.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t zone = H5Gopen2(file, "/Base/zone 1", H5P_DEFAULT);
  const hid_t from = H5Gopen2(zone, "ZoneBC", H5P_DEFAULT);
  const hid_t to = H5Gcreate2(zone, "new", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(to, 0);
  ASSERT_GE(H5Ocopy(from, "skin", to, "skin", H5P_DEFAULT, H5P_DEFAULT), 0);
  for (int n = 0; n < H5Aget_num_attrs(from); ++n)
  {
    const hid_t attribute =
      H5Aopen_by_idx(from, ".", H5_INDEX_NAME, H5_ITER_INC, static_cast<hsize_t>(n), H5P_DEFAULT, H5P_DEFAULT);
    std::array<char, 64> name{};
    std::array<char, 256> value{};
    ASSERT_GT(H5Aget_name(attribute, name.size(), name.data()), 0);
    const hid_t type = H5Aget_type(attribute);
    const hid_t space = H5Aget_space(attribute);
    ASSERT_LE(H5Aget_storage_size(attribute), value.size());
    ASSERT_GE(H5Aread(attribute, type, value.data()), 0);
    const hid_t copy = H5Acreate2(to, name.data(), type, space, H5P_DEFAULT, H5P_DEFAULT);
    ASSERT_GE(H5Awrite(copy, type, value.data()), 0);
    H5Aclose(copy);
    H5Sclose(space);
    H5Tclose(type);
    H5Aclose(attribute);
  }
  H5Gclose(to);
  H5Gclose(from);
  ASSERT_GE(H5Ldelete(zone, "ZoneBC", H5P_DEFAULT), 0);
  ASSERT_GE(H5Lmove(zone, "new", zone, "ZoneBC", H5P_DEFAULT, H5P_DEFAULT), 0);
  H5Gclose(zone);
  H5Fclose(file);

  Reading reading;
  read(reading, fileName);
  if (reading.errors.empty())
  {
    // This version of the library sees them.
    EXPECT_EQ(boundaries(readMesh(fileName).mesh).size(), 1u);
    return;
  }
  EXPECT_TRUE(mentions(reading.errors, { "mesh.cgns", "node /Base/zone 1/ZoneBC", "0 of its 1 child nodes" }))
    << reading.errors[0];
}

TEST(MeshFileHabits, LinksToOtherFiles)
{
  for (const int type : { CG_FILE_HDF5, CG_FILE_ADF })
  {
    SCOPED_TRACE(type);
    TemporaryFolder folder;
    // As solvers write their results: the grid stays in its own file.
    writeCGNS(twoBlocks(), folder / "grid.cgns", { type });
    require(cg_set_file_type(type));
    int file = 0;
    require(cg_open((folder / "solution.cgns").c_str(), CG_MODE_WRITE, &file));
    int id = 0;
    require(cg_base_write(file, "Base", 3, 3, &id));
    require(cg_goto(file, 1, "end"));
    for (const char* zone : { "zone 1", "zone 2" })
    {
      require(cg_link_write(zone, "grid.cgns", (std::string("/Base/") + zone).c_str()));
    }
    require(cg_close(file));
    const Result expected = readMesh(folder / "grid.cgns");
    const Result found = readMesh(folder / "solution.cgns");
    EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
    EXPECT_EQ(found.mesh.interfaces.size(), expected.mesh.interfaces.size());
    // The grid has gone.
    std::filesystem::rename(folder / "grid.cgns", folder / "elsewhere.cgns");
    const std::string error = refusal(folder / "solution.cgns");
    EXPECT_NE(
      error.find("node /Base/zone 1: the node is a link to /Base/zone 1 of the file 'grid.cgns'"), std::string::npos)
      << error;
  }
}

TEST(MeshFileHabits, SomeZonesOfAMeshAreAMesh)
{
  TemporaryFolder folder;
  MeshCase mesh = twoBlocks();
  mesh.interfaces.clear();
  writeChanged(mesh, folder / "mesh.cgns", [](int file) {
    condition(file, 1, "skin", CGNS_ENUMV(BCWall), { 1, 1, 1, 5, 4, 1 });
    const cgsize_t range[6] = { 1, 1, 1, 1, 4, 3 };
    const cgsize_t donor[6] = { 7, 1, 1, 7, 4, 3 };
    const int transform[3] = { 1, 2, 3 };
    int id = 0;
    require(cg_1to1_write(file, 1, 1, "left", "zone 9", range, donor, transform, &id));
    const cgsize_t size[9] = { 3, 2, 1, 2, 1, 0, 0, 0, 0 };
    require(cg_zone_write(file, 1, "a surface", size, CGNS_ENUMV(Structured), &id));
  });
  const Result found = readMesh(folder / "mesh.cgns");
  EXPECT_EQ(found.mesh.blocks.size(), 2u);
  EXPECT_EQ(boundaries(found.mesh)["skin: BCWall"].size(), 4u * 3);
  EXPECT_TRUE(mentions(found.warnings, { "interfaces left out", "'zone 1'", "'left'", "'zone 9'" }));
  EXPECT_TRUE(mentions(found.warnings, { "zones left out", "'a surface'", "3 x 2 x 1 points" }));

  int file = 0;
  int base = 0;
  int zone = 0;
  require(cg_open((folder / "surface.cgns").c_str(), CG_MODE_WRITE, &file));
  require(cg_base_write(file, "Base", 3, 3, &base));
  const cgsize_t size[9] = { 3, 2, 1, 2, 1, 0, 0, 0, 0 };
  require(cg_zone_write(file, base, "a surface", size, CGNS_ENUMV(Structured), &zone));
  require(cg_close(file));
  EXPECT_NE(refusal(folder / "surface.cgns").find("no zone is a volume: 'a surface' has 3 x 2 x 1"), std::string::npos);
}

TEST(MeshFileHabits, BoundariesInEightWays)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  // Faces of zone 1 (5 x 4 x 3 points) and zone 2 (4 x 4 x 3 points).
  struct Face
  {
    int zone;
    const char* name;
    BCType type;
    std::vector<cgsize_t> range;
  };
  const std::vector<Face> faces = { { 1, "upper skin", CGNS_ENUMV(BCWallViscous), { 1, 1, 1, 5, 4, 1 } },
    { 2, "upper skin", CGNS_ENUMV(BCWallViscous), { 1, 1, 1, 4, 4, 1 } },
    { 1, "mid plane", CGNS_ENUMV(BCSymmetryPlane), { 1, 1, 1, 5, 1, 3 } },
    { 2, "mid plane", CGNS_ENUMV(BCSymmetryPlane), { 1, 1, 1, 4, 1, 3 } },
    { 1, "wall of the tunnel", CGNS_ENUMV(BCFarfield), { 1, 1, 3, 5, 4, 3 } } };
  struct Way
  {
    const char* what;
    bool families, types, ownTypes, padded, narrow, list, linked;
    int file;
  };
  const std::vector<Way> ways = {
    { "families with types", true, true, false, false, false, false, false, CG_FILE_HDF5 },
    { "names and types, no families", false, false, true, false, false, false, false, CG_FILE_HDF5 },
    { "families and both types", true, true, true, false, false, false, false, CG_FILE_HDF5 },
    { "names with blanks at the end", false, false, true, true, false, false, false, CG_FILE_HDF5 },
    { "families with blanks at the end, ADF", true, true, false, true, false, false, false, CG_FILE_ADF },
    { "integers of 4 bytes", true, true, false, false, true, false, false, CG_FILE_HDF5 },
    { "lists of points", true, true, false, false, false, true, false, CG_FILE_HDF5 },
    { "zones linked from another file", true, true, false, false, false, false, true, CG_FILE_HDF5 },
  };
  std::map<std::string, std::vector<std::array<int, 4>>> first;
  for (const Way& way : ways)
  {
    SCOPED_TRACE(way.what);
    const std::string fileName = folder / ("way" + std::to_string(&way - ways.data()) + ".cgns");
    writeChanged(
      mesh, fileName,
      [&](int file) {
        std::set<std::string> written;
        for (const Face& face : faces)
        {
          const std::string name = std::string(face.name) + (way.padded ? "  " : "");
          if (way.families && written.insert(face.name).second)
          {
            family(file, face.name, way.types ? face.type : CGNS_ENUMV(BCTypeNull));
          }
          std::vector<cgsize_t> points = face.range;
          if (way.list)
          {
            points.clear();
            for (cgsize_t k = face.range[2]; k <= face.range[5]; ++k)
            {
              for (cgsize_t j = face.range[1]; j <= face.range[4]; ++j)
              {
                for (cgsize_t i = face.range[0]; i <= face.range[3]; ++i)
                {
                  points.insert(points.end(), { i, j, k });
                }
              }
            }
          }
          condition(file, face.zone, way.families ? "BC_" + std::to_string(&face - faces.data()) : name,
            way.ownTypes ? face.type : CGNS_ENUMV(FamilySpecified), points, way.families ? name : "",
            way.list ? CGNS_ENUMV(PointList) : CGNS_ENUMV(PointRange));
        }
      },
      way.file);
    if (way.narrow)
    {
      int file = 0;
      double root = 0.0;
      require(cgio_open_file(fileName.c_str(), CGIO_MODE_MODIFY, CGIO_FILE_NONE, &file));
      require(cgio_get_root_id(file, &root));
      narrowIntegers(file, root);
      require(cgio_close_file(file));
    }
    std::string opened = fileName;
    if (way.linked)
    {
      opened = folder / "links.cgns";
      int file = 0;
      int base = 0;
      require(cg_set_file_type(CG_FILE_HDF5));
      require(cg_open(opened.c_str(), CG_MODE_WRITE, &file));
      require(cg_base_write(file, "Base", 3, 3, &base));
      require(cg_goto(file, 1, "end"));
      const std::string target = std::filesystem::path(fileName).filename().string();
      for (const char* node : { "zone 1", "zone 2", "upper skin", "mid plane", "wall of the tunnel" })
      {
        require(cg_link_write(node, target.c_str(), (std::string("/Base/") + node).c_str()));
      }
      require(cg_close(file));
    }
    const Result found = readMesh(opened);
    EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
    const auto quads = boundaries(found.mesh);
    first = first.empty() ? quads : first;
    EXPECT_EQ(quads, first);
    EXPECT_EQ(found.mesh.boundaryNames, (std::vector<std::string>{ "upper skin", "mid plane", "wall of the tunnel" }));
    EXPECT_EQ(roles(found.mesh),
      (std::vector<bsv::BoundaryRole>{
        bsv::BoundaryRole::Body, bsv::BoundaryRole::Symmetry, bsv::BoundaryRole::Other }));
    EXPECT_EQ(found.mesh.interfaces.size(), mesh.interfaces.size());
    // A row of the table that a run of this test alone prints.
    std::cout << "| " << way.what << " | " << (quads == first ? "the same" : "OTHER") << " quadrilaterals and types | ";
    for (std::size_t n = 0; n < found.mesh.boundaryNames.size(); ++n)
    {
      const bsv::BoundaryRole role = roles(found.mesh)[n];
      std::cout << found.mesh.boundaryNames[n] << ": "
                << (role == bsv::BoundaryRole::Body          ? "body, "
                       : role == bsv::BoundaryRole::Symmetry ? "symmetry, "
                                                             : "other, ");
    }
    std::cout << found.mesh.interfaces.size() << " contacts |\n";
  }
  EXPECT_EQ(first.size(), 3u);
  EXPECT_EQ(first["upper skin: BCWallViscous"].size(), 4u * 3 + 3 * 3);
}

TEST(MeshFileHabits, NamesThatPatternsChooseWinOverTypes)
{
  const std::vector<std::string> names = { "wing", "farfield wall", "no type wall", "outer" };
  const std::vector<std::string> types = { "BCWallViscous", "BCFarfield", "BCTypeUserDefined", "BCFarfield" };
  const auto selected = [&](const bsv::BoundaryPatterns& patterns) {
    std::vector<bool> result;
    for (int tag = 0; tag < 4; ++tag)
    {
      result.push_back(bsv::isBodyBoundary(patterns, names, types, tag));
    }
    return result;
  };
  EXPECT_EQ(selected(bsv::defaultBodyBoundaries()), (std::vector<bool>{ true, false, false, false }));
  EXPECT_EQ(selected({ "outer" }), (std::vector<bool>{ false, false, false, true }));
  EXPECT_EQ(selected({ "no type*", "BCFarfield" }), (std::vector<bool>{ false, true, true, true }));
  // A pattern that is also one of the default ones is meant as it is written, but for a longer list of the same.
  const std::vector<std::string> tunnel = { "wall below", "wall of the tunnel" };
  const std::vector<std::string> kinds = { "BCInflow", "BCFarfield" };
  EXPECT_TRUE(bsv::isBodyBoundary({ "wall*" }, tunnel, kinds, 0));
  EXPECT_TRUE(bsv::isBodyBoundary({ "wall*" }, tunnel, kinds, 1));
  bsv::BoundaryPatterns longer = bsv::defaultBodyBoundaries();
  longer.emplace_back("*below");
  EXPECT_TRUE(bsv::isBodyBoundary(longer, tunnel, kinds, 0));
  EXPECT_FALSE(bsv::isBodyBoundary(longer, tunnel, kinds, 1));
}

TEST(MeshFileHabits, NumberedConditionsAreNamedByTheirType)
{
  TemporaryFolder folder;
  writeChanged(twoBlocks(), folder / "mesh.cgns", [](int file) {
    condition(file, 1, "BC_1", CGNS_ENUMV(BCWall), { 1, 1, 1, 5, 4, 1 });
    condition(file, 1, "C00021", CGNS_ENUMV(BCFarfield), { 1, 1, 3, 5, 4, 3 });
    condition(file, 2, "dom-7", CGNS_ENUMV(BCWall), { 1, 1, 1, 4, 4, 1 });
    condition(file, 2, "flap2", CGNS_ENUMV(BCWall), { 1, 1, 3, 4, 4, 3 });
    // One name for two types.
    condition(file, 2, "flap 2", CGNS_ENUMV(BCWallInviscid), { 1, 1, 1, 4, 1, 3 });
    condition(file, 1, "flap 2", CGNS_ENUMV(BCWallViscous), { 1, 1, 1, 5, 1, 3 });
  });
  const BlockMesh mesh = readMesh(folder / "mesh.cgns").mesh;
  EXPECT_EQ(mesh.boundaryNames,
    (std::vector<std::string>{ "BCWall", "BCFarfield", "flap 2", "flap2", "flap 2 (BCWallInviscid)" }));
}

TEST(MeshFileHabits, ConditionsThatContradictTheMeshAreLeftOut)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  struct Kind
  {
    const char* what;
    std::function<void(int)> change;
    /// What the warning must say.
    std::vector<std::string> words;
    /// Quadrilaterals that keep the name.
    std::size_t kept;
  };
  const BCType wall = CGNS_ENUMV(BCWall);
  const auto range = CGNS_ENUMV(PointRange);
  const std::vector<Kind> kinds = {
    { "on an interface",
      [&](int file) {
        condition(file, 1, "skin", wall, { 5, 1, 1, 5, 4, 3 });
      },
      { "'skin'", "block 'zone 1'", "i max", "interface" }, 0 },
    { "partly on an interface of the donor's side",
      [&](int file) {
        // All faces of the zone that have i = 1 or k = 1, as a list.
        std::vector<cgsize_t> points;
        for (cgsize_t k = 1; k <= 3; ++k)
        {
          for (cgsize_t j = 1; j <= 4; ++j)
          {
            for (cgsize_t i = 1; i <= 4; ++i)
            {
              if (i == 1 || k == 1)
              {
                points.insert(points.end(), { i, j, k });
              }
            }
          }
        }
        condition(file, 2, "skin", wall, points, "", CGNS_ENUMV(PointList));
      },
      { "'skin'", "block 'zone 2'", "i min" }, 9 },
    { "index -1",
      [&](int file) {
        condition(file, 2, "skin", wall, { 1, 1, -1, 4, 4, -1 });
      },
      { "'zone 2'", "'skin'", "(1, 1, -1) to (4, 4, -1)" }, 0 },
    { "beyond the zone",
      [&](int file) {
        condition(file, 1, "skin", wall, { 1, 1, 1, 6, 4, 1 });
      },
      { "'zone 1'", "'skin'", "(6, 4, 1)" }, 0 },
    { "plane inside the zone",
      [&](int file) {
        condition(file, 1, "skin", wall, { 3, 1, 1, 3, 4, 3 });
      },
      { "'zone 1'", "'skin'", "inside" }, 0 },
    { "whole zone",
      [&](int file) {
        condition(file, 1, "skin", wall, { 1, 1, 1, 5, 4, 3 });
      },
      { "'zone 1'", "'skin'", "not on a face" }, 0 },
    { "list with a point of another zone",
      [&](int file) {
        condition(file, 2, "skin", wall, { 1, 1, 1, 5, 1, 1, 1, 2, 1 }, "", CGNS_ENUMV(PointList));
      },
      { "'zone 2'", "'skin'", "(5, 1, 1)" }, 0 },
    { "elements",
      [&](int file) {
        condition(file, 1, "skin", wall, { 1, 1, 1, 9, 1, 1 }, "", CGNS_ENUMV(ElementRange));
      },
      { "'zone 1'", "'skin'" }, 0 },
    { "at edges",
      [&](int file) {
        condition(file, 1, "skin", wall, { 1, 1, 1, 4, 3, 1 }, "", range, CGNS_ENUMV(EdgeCenter));
      },
      { "'skin'", "EdgeCenter" }, 0 },
    { "where another one is",
      [&](int file) {
        condition(file, 1, "skin", wall, { 1, 1, 1, 5, 4, 1 });
        condition(file, 1, "far", CGNS_ENUMV(BCFarfield), { 1, 1, 1, 5, 2, 1 });
      },
      { "'far'", "k min", "'skin'" }, 12 },
    { "a line",
      [&](int file) {
        condition(file, 1, "skin", wall, { 1, 1, 1, 5, 1, 1 });
      },
      { "'zone 1'", "'skin'", "(1, 1, 1) to (5, 1, 1)", "line or a point" }, 0 },
    { "a list of the points of a line",
      [&](int file) {
        condition(file, 1, "skin", wall, { 1, 1, 1, 2, 1, 1 }, "", CGNS_ENUMV(PointList));
      },
      { "'zone 1'", "'skin'", "no quadrilateral" }, 0 },
    { "holes of an overset grid",
      [&](int file) {
        const cgsize_t box[6] = { 2, 2, 1, 3, 3, 2 };
        int id = 0;
        require(cg_hole_write(file, 1, 1, "cut away", CGNS_ENUMV(Vertex), CGNS_ENUMV(PointRange), 1, 2, box, &id));
      },
      { "holes", "'zone 1'", "'cut away'" }, 0 },
    { "overset connectivity",
      [&](int file) {
        const cgsize_t box[6] = { 1, 1, 3, 4, 4, 3 };
        int id = 0;
        require(cg_conn_write_short(file, 1, 2, "fringe", CGNS_ENUMV(Vertex), CGNS_ENUMV(Overset),
          CGNS_ENUMV(PointRange), 2, box, "zone 1", &id));
      },
      { "general connectivity", "'zone 2'", "'fringe'", "Overset", "'zone 1'" }, 0 },
    // The same in other words needs no warning.
    { "at face centres",
      [&](int file) {
        condition(file, 1, "skin", wall, { 1, 1, 3, 4, 3, 3 }, "", range, CGNS_ENUMV(FaceCenter));
      },
      {}, 12 },
    { "at the cells behind the face",
      [&](int file) {
        condition(file, 1, "skin", wall, { 1, 1, 2, 4, 3, 2 }, "", range, CGNS_ENUMV(CellCenter));
      },
      {}, 12 },
    { "twice",
      [&](int file) {
        condition(file, 1, "skin", wall, { 1, 1, 1, 5, 4, 1 }, "skin");
        condition(file, 1, "again", wall, { 1, 1, 1, 5, 2, 1 }, "skin");
      },
      {}, 12 },
  };
  for (const Kind& kind : kinds)
  {
    SCOPED_TRACE(kind.what);
    for (const int type : { CG_FILE_ADF, CG_FILE_HDF5 })
    {
      const std::string file = folder / (std::to_string(&kind - kinds.data()) + "-" + std::to_string(type) + ".cgns");
      writeChanged(mesh, file, kind.change, type);
      const Result found = readMesh(file);
      EXPECT_EQ(found.warnings.size(), kind.words.empty() ? 0u : 1u);
      EXPECT_TRUE(kind.words.empty() || mentions(found.warnings, kind.words))
        << (found.warnings.empty() ? "" : found.warnings[0]);
      EXPECT_EQ(boundaries(found.mesh)["skin: BCWall"].size(), kind.kept);
      EXPECT_EQ(found.mesh.interfaces.size(), mesh.interfaces.size());
      // The rest of the program takes it.
      EXPECT_EQ(bsv::buildBlockComplex(found.mesh).blocks.size(), 2u);
    }
  }
}

TEST(MeshFileHabits, ConditionsWithoutPointsAreNamed)
{
  TemporaryFolder folder;
  // What some versions of the library leave out without a word, and others refuse.
  for (const int type : { CG_FILE_ADF, CG_FILE_HDF5 })
  {
    for (const auto set : { CGNS_ENUMV(PointRange), CGNS_ENUMV(PointList) })
    {
      const std::string fileName = folder / (std::to_string(type) + cg_PointSetTypeName(set) + ".cgns");
      writeChanged(
        twoBlocks(), fileName,
        [&](int file) {
          condition(file, 1, "kept", CGNS_ENUMV(BCWall), { 1, 1, 1, 5, 4, 1 });
          condition(file, 2, "skin", CGNS_ENUMV(BCWall), { 1, 1, 1, 4, 4, 1 }, "skin", set);
          deleteNode(file, "/Base/zone 2/ZoneBC/skin", cg_PointSetTypeName(set));
        },
        type);
      Reading reading;
      read(reading, fileName);
      ASSERT_EQ(reading.errors.size() + reading.warnings.size(), 1u);
      const std::string text = reading.errors.empty() ? reading.warnings[0] : reading.errors[0];
      EXPECT_TRUE(mentions({ text }, { "zone 2", "skin", "no points" })) << text;
    }
  }
}

TEST(MeshFileHabits, BasesOfSurfacesAreLeftOut)
{
  TemporaryFolder folder;
  writeChanged(twoBlocks(), folder / "mesh.cgns", [](int file) {
    const cgsize_t flat[6] = { 3, 3, 2, 2, 0, 0 };
    int base = 0;
    int zone = 0;
    require(cg_base_write(file, "skin", 2, 3, &base));
    require(cg_zone_write(file, base, "patch", flat, CGNS_ENUMV(Structured), &zone));
  });
  const Result found = readMesh(folder / "mesh.cgns");
  EXPECT_EQ(found.mesh.blocks.size(), 2u);
  EXPECT_TRUE(mentions(found.warnings, { "base 'skin'", "surface" }));
}

TEST(MeshFileHabits, StepsOfCGNSHaveTheirOwnCoordinates)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  for (const int rind : { 0, 1 })
  {
    const std::string fileName = folder / ("steps" + std::to_string(rind) + ".cgns");
    writeChanged(
      mesh, fileName,
      [&](int file) {
        const cgsize_t three = 3;
        const double times[3] = { 0.25, 0.5, 2.0 };
        require(cg_biter_write(file, 1, "TimeIterValues", 3));
        require(cg_goto(file, 1, "BaseIterativeData_t", 1, "end"));
        require(cg_array_write("TimeValues", CGNS_ENUMV(RealDouble), 1, &three, times));
        for (int zone = 1; zone <= 2; ++zone)
        {
          const MeshCase::Block& block = mesh.blocks[zone - 1];
          int grid = 0;
          require(cg_grid_write(file, 1, zone, "GridCoordinates#2", &grid));
          require(cg_goto(file, 1, "Zone_t", zone, "GridCoordinates_t", grid, "end"));
          // Layers outside of the zone, whose coordinates mean nothing here.
          const int planes[6] = { rind, 0, 0, 2 * rind, rind, rind };
          cgsize_t size[3];
          for (int d = 0; d < 3; ++d)
          {
            size[d] = block.counts[d] + planes[2 * d] + planes[2 * d + 1];
          }
          if (rind > 0)
          {
            require(cg_rind_write(planes));
          }
          for (int axis = 0; axis < 3; ++axis)
          {
            std::vector<double> values(static_cast<std::size_t>(size[0] * size[1] * size[2]), 1e9);
            for (std::size_t p = 0; p < block.points.size(); ++p)
            {
              const auto i = static_cast<cgsize_t>(p % block.counts[0]) + planes[0];
              const auto j = static_cast<cgsize_t>(p / block.counts[0] % block.counts[1]) + planes[2];
              const auto k = static_cast<cgsize_t>(p / block.counts[0] / block.counts[1]) + planes[4];
              values[i + size[0] * (j + size[1] * k)] = block.points[p][axis] + 10.0 * (axis + 1);
            }
            const char* names[3] = { "CoordinateX", "CoordinateY", "CoordinateZ" };
            require(cg_array_write(names[axis], CGNS_ENUMV(RealDouble), 3, size, values.data()));
          }
          require(cg_ziter_write(file, 1, zone, "ZoneIterativeData"));
          require(cg_goto(file, 1, "Zone_t", zone, "ZoneIterativeData_t", 1, "end"));
          std::string pointers;
          for (const char* name : { "GridCoordinates", "GridCoordinates#2", "GridCoordinates" })
          {
            pointers += name;
            pointers.resize((pointers.size() + 31) / 32 * 32, ' ');
          }
          const cgsize_t shape[2] = { 32, 3 };
          require(cg_array_write("GridCoordinatesPointers", CGNS_ENUMV(Character), 2, shape, pointers.data()));
        }
      },
      rind > 0 ? CG_FILE_ADF : CG_FILE_HDF5);
    Reading reading;
    reading.reader->SetFileName(fileName.c_str());
    reading.reader->UpdateInformation();
    vtkInformation* info = reading.reader->GetOutputInformation(0);
    ASSERT_EQ(info->Length(vtkStreamingDemandDrivenPipeline::TIME_STEPS()), 3);
    EXPECT_EQ(info->Get(vtkStreamingDemandDrivenPipeline::TIME_STEPS(), 2), 2.0);
    for (const double time : { 0.25, 0.5, 1.9, 2.0 })
    {
      reading.reader->UpdateTimeStep(time);
      std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
      const BlockMesh found = bsv::structuredBlocks(reading.reader->GetOutputDataObject(0), grids);
      ASSERT_EQ(found.blocks.size(), 2u);
      const double moved = time == 0.5 || time == 1.9 ? 10.0 : 0.0;
      for (int b = 0; b < 2; ++b)
      {
        for (const Ijk& p : { Ijk{ 0, 0, 0 }, Ijk{ 3, 2, 1 }, Ijk{ 3, 3, 2 } })
        {
          EXPECT_EQ(found.blocks[b].points(p), bsv::Vec3(mesh.blocks[b].at(p) + moved * bsv::Vec3(1.0, 2.0, 3.0)));
        }
      }
      EXPECT_EQ(found.interfaces.size(), mesh.interfaces.size());
    }
  }
}

TEST(MeshFileHabits, FamiliesWithinFamiliesHaveTypes)
{
  TemporaryFolder folder;
  writeChanged(twoBlocks(), folder / "mesh.cgns", [](int file) {
    int id = 0;
    int fambc = 0;
    // A tree of families; the type is that of a leaf, or of what it belongs to.
    family(file, "aircraft", CGNS_ENUMV(BCWallViscous));
    require(cg_gopath(file, "/Base/aircraft"));
    require(cg_node_family_write("wing", &id));
    require(cg_node_family_write("inlet", &id));
    require(cg_gopath(file, "/Base/aircraft/inlet"));
    require(cg_node_fambc_write("FamBC", CGNS_ENUMV(BCOutflow), &fambc));
    // A family that names another one as the one that it belongs to.
    require(cg_family_write(file, 1, "tail", &id));
    require(cg_family_name_write(file, 1, id, "Parent", "aircraft"));
    require(cg_family_write(file, 1, "colour", &id));
    family(file, "sky", CGNS_ENUMV(BCFarfield));

    const auto specified = CGNS_ENUMV(FamilySpecified);
    condition(file, 1, "a", specified, { 1, 1, 1, 5, 4, 1 }, "aircraft/wing");
    condition(file, 2, "b", specified, { 1, 1, 1, 4, 4, 1 }, "/Base/aircraft/inlet");
    condition(file, 1, "c", specified, { 1, 1, 3, 5, 4, 3 }, "tail");
    condition(file, 2, "d", specified, { 1, 1, 3, 4, 4, 3 }, "colour");
    condition(file, 1, "e", specified, { 1, 1, 1, 5, 1, 3 });
    // Families besides: the type of the first that has one; its name, if it is the first of all.
    const auto besides = [&](int zone, int number, const char* name) {
      require(cg_goto(file, 1, "Zone_t", zone, "ZoneBC_t", 1, "BC_t", number, "end"));
      require(cg_multifam_write("AdditionalFamily", name));
    };
    besides(2, 2, "sky");
    besides(1, 3, "sky");
  });
  const Result found = readMesh(folder / "mesh.cgns");
  EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
  std::map<std::string, std::string> types;
  for (std::size_t n = 0; n < found.mesh.boundaryNames.size(); ++n)
  {
    types[found.mesh.boundaryNames[n]] = found.mesh.boundaryTypes[n];
  }
  EXPECT_EQ(types,
    (std::map<std::string, std::string>{ { "aircraft/wing", "BCWallViscous" }, { "aircraft/inlet", "BCOutflow" },
      { "tail", "BCWallViscous" }, { "colour", "BCFarfield" }, { "sky", "BCFarfield" } }));
}

TEST(MeshFileHabits, FamiliesThatAreNotThereAreNamed)
{
  TemporaryFolder folder;
  const auto specified = CGNS_ENUMV(FamilySpecified);
  writeChanged(twoBlocks(), folder / "mesh.cgns", [&](int file) {
    family(file, "Wing", CGNS_ENUMV(BCWall));
    condition(file, 1, "a", specified, { 1, 1, 1, 5, 4, 1 }, "Wing");
    condition(file, 2, "b", specified, { 1, 1, 1, 4, 4, 1 }, "WING");
    condition(file, 1, "c", specified, { 1, 1, 3, 5, 4, 3 }, "tail");
    // It has a type of its own.
    condition(file, 2, "d", CGNS_ENUMV(BCFarfield), { 1, 1, 3, 4, 4, 3 }, "sky");
  });
  const Result found = readMesh(folder / "mesh.cgns");
  ASSERT_EQ(found.warnings.size(), 1u);
  EXPECT_TRUE(mentions(found.warnings, { "'b': 'WING' (it has 'Wing')", "'c': 'tail'" })) << found.warnings[0];
  EXPECT_EQ(found.warnings[0].find("sky"), std::string::npos) << found.warnings[0];
  EXPECT_EQ(found.mesh.boundaryNames.size(), 4u);
}

TEST(MeshFileHabits, FacesBeyondTheZoneAreSaidAsTheFileHasThem)
{
  TemporaryFolder folder;
  // Zone 1 has 5 x 4 x 3 points, and so 4 x 3 faces along i and j.
  writeChanged(twoBlocks(), folder / "mesh.cgns", [&](int file) {
    for (const auto& [name, points] : { std::pair("points", std::vector<cgsize_t>{ 1, 1, 1, 5, 4, 1 }),
           std::pair("zero", std::vector<cgsize_t>{ 0, 1, 1, 3, 3, 1 }) })
    {
      condition(file, 1, name, CGNS_ENUMV(BCWall), points);
    }
    for (const int number : { 1, 2 })
    {
      require(cg_goto(file, 1, "Zone_t", 1, "ZoneBC_t", 1, "BC_t", number, "end"));
      require(cg_gridlocation_write(CGNS_ENUMV(KFaceCenter)));
    }
  });
  const Result found = readMesh(folder / "mesh.cgns");
  ASSERT_EQ(found.warnings.size(), 1u);
  EXPECT_TRUE(mentions(found.warnings,
    { "'points': the range (1, 1, 1) to (5, 4, 1) at KFaceCenter leaves the 4 faces of the zone along i, as if it "
      "counted points",
      "'zero': the range (0, 1, 1) to (3, 3, 1)" }))
    << found.warnings[0];
  EXPECT_TRUE(found.mesh.boundaries.empty());
}

TEST(MeshFileHabits, TransformsThatSayNoMoreThanNeeded)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  const std::string fileName = folder / "mesh.cgns";
  const auto expectWhole = [&] {
    const Result found = readMesh(fileName);
    EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
    ASSERT_EQ(found.mesh.interfaces.size(), 1u);
    EXPECT_EQ(found.mesh.interfaces[0].orientation, mesh.interfaces[0].orientation);
  };
  // The default is the identity.
  writeChanged(mesh, fileName, [](int file) {
    for (int zone = 1; zone <= 2; ++zone)
    {
      require(cg_goto(file, 1, "Zone_t", zone, "ZoneGridConnectivity_t", 1, "GridConnectivity1to1_t", 1, "end"));
      require(cg_delete_node("Transform"));
    }
  });
  expectWhole();
  // The direction across need not be given.
  writeCGNS(mesh, fileName, { CG_FILE_HDF5 });
  int file = 0;
  double root = 0.0;
  require(cgio_open_file(fileName.c_str(), CGIO_MODE_MODIFY, CGIO_FILE_NONE, &file));
  require(cgio_get_root_id(file, &root));
  for (const std::string zone : { "zone 1", "zone 2" })
  {
    double contacts = 0.0;
    double contact = 0.0;
    double node = 0.0;
    int found = 0;
    require(cgio_get_node_id(file, root, ("/Base/" + zone + "/ZoneGridConnectivity").c_str(), &contacts));
    require(cgio_children_ids(file, contacts, 1, 1, &found, &contact));
    require(cgio_get_node_id(file, contact, "Transform", &node));
    const std::int32_t transform[3] = { 0, 2, 3 };
    require(cgio_write_all_data(file, node, transform));
  }
  require(cgio_close_file(file));
  expectWhole();
}

TEST(MeshFileHabits, PeriodicListsOfPointsAreBoundaries)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  // The faces j min and j max of zone 1 repeat each other, as a range and as a list.
  writeChanged(mesh, folder / "mesh.cgns", [](int file) {
    const auto connect = [&](const char* name, const std::vector<cgsize_t>& points, CGNS_ENUMT(PointSetType_t) set) {
      int id = 0;
      const auto count = static_cast<cgsize_t>(points.size() / 3);
      std::vector<cgsize_t> donor(set == CGNS_ENUMV(PointRange) ? 3 * 15 : points.size(), 1);
      require(cg_conn_write(file, 1, 1, name, CGNS_ENUMV(Vertex), CGNS_ENUMV(Abutting1to1), set, count, points.data(),
        "zone 1", CGNS_ENUMV(Structured), CGNS_ENUMV(PointListDonor), CGNS_ENUMV(DataTypeNull),
        static_cast<cgsize_t>(donor.size() / 3), donor.data(), &id));
      const float zero[3] = { 0, 0, 0 };
      const float shift[3] = { 0, 1, 0 };
      require(cg_conn_periodic_write(file, 1, 1, id, zero, zero, shift));
    };
    std::vector<cgsize_t> points;
    for (cgsize_t k = 1; k <= 3; ++k)
    {
      for (cgsize_t i = 1; i <= 5; ++i)
      {
        points.insert(points.end(), { i, 4, k });
      }
    }
    connect("low", { 1, 1, 1, 5, 1, 3 }, CGNS_ENUMV(PointRange));
    connect("high", points, CGNS_ENUMV(PointList));
  });
  const Result found = readMesh(folder / "mesh.cgns");
  EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
  EXPECT_EQ(boundaries(found.mesh)["Periodic: "].size(), 2u * 4 * 2);
  EXPECT_EQ(found.mesh.interfaces.size(), mesh.interfaces.size());
}

TEST(MeshFileHabits, CylindricalCoordinatesBecomeCartesian)
{
  TemporaryFolder folder;
  MeshCase mesh = twoBlocks();
  const double degree = std::acos(-1.0) / 180.0;
  for (const bool degrees : { false, true })
  {
    const std::string fileName = folder / (degrees ? "degrees.cgns" : "radians.cgns");
    writeChanged(mesh, fileName, [&](int file) {
      for (int zone = 1; zone <= 2; ++zone)
      {
        require(cg_goto(file, 1, "Zone_t", zone, "GridCoordinates_t", 1, "end"));
        require(cg_delete_node("CoordinateX"));
        require(cg_delete_node("CoordinateY"));
        std::vector<double> r;
        std::vector<double> theta;
        for (const bsv::Vec3& x : mesh.blocks[zone - 1].points)
        {
          r.push_back(std::hypot(x[0], x[1]));
          theta.push_back(std::atan2(x[1], x[0]) / (degrees ? degree : 1.0));
        }
        int id = 0;
        require(cg_coord_write(file, 1, zone, CGNS_ENUMV(RealDouble), "CoordinateTheta", theta.data(), &id));
        require(cg_coord_write(file, 1, zone, CGNS_ENUMV(RealDouble), "CoordinateR", r.data(), &id));
      }
      require(cg_goto(file, 1, "end"));
      require(cg_units_write(CGNS_ENUMV(Kilogram), CGNS_ENUMV(Meter), CGNS_ENUMV(Second), CGNS_ENUMV(Kelvin),
        degrees ? CGNS_ENUMV(Degree) : CGNS_ENUMV(Radian)));
    });
    const Result found = readMesh(fileName);
    EXPECT_EQ(found.warnings.size(), 1u);
    EXPECT_TRUE(mentions(found.warnings, { "cylindrical", "'zone 1'", "'zone 2'" }));
    ASSERT_EQ(found.mesh.blocks.size(), 2u);
    for (int b = 0; b < 2; ++b)
    {
      for (vtkIdType p = 0; p < found.grids[b]->GetNumberOfPoints(); ++p)
      {
        const bsv::Vec3 x(found.grids[b]->GetPoint(p));
        // Sizes of a few units; the angle has passed through a quotient.
        EXPECT_LT((x - mesh.blocks[b].points[p]).norm(), 1e-14 * (1.0 + x.norm()));
      }
    }
    EXPECT_EQ(bsv::buildBlockComplex(found.mesh).blocks.size(), 2u);
  }
  // Other coordinates are named.
  writeChanged(mesh, folder / "other.cgns", [&](int file) {
    require(cg_goto(file, 1, "Zone_t", 1, "GridCoordinates_t", 1, "end"));
    require(cg_delete_node("CoordinateY"));
  });
  const std::string text = refusal(folder / "other.cgns");
  EXPECT_NE(text.find("zone 'zone 1': the zone has no CoordinateY, but CoordinateX, CoordinateZ"), std::string::npos)
    << text;
}

TEST(MeshFileHabits, LengthUnitsThatDifferAreNamed)
{
  TemporaryFolder folder;
  const auto writeUnits = [](CGNS_ENUMT(LengthUnits_t) unit) {
    require(
      cg_units_write(CGNS_ENUMV(Kilogram), unit, CGNS_ENUMV(Second), CGNS_ENUMV(Kelvin), CGNS_ENUMV(AngleUnitsNull)));
  };
  for (const auto second : { CGNS_ENUMV(Inch), CGNS_ENUMV(Meter) })
  {
    writeChanged(twoBlocks(), folder / "mesh.cgns", [&](int file) {
      require(cg_goto(file, 1, "end"));
      writeUnits(CGNS_ENUMV(Meter));
      require(cg_goto(file, 1, "Zone_t", 2, "GridCoordinates_t", 1, "DataArray_t", 1, "end"));
      writeUnits(second);
    });
    const Result found = readMesh(folder / "mesh.cgns");
    EXPECT_EQ(found.warnings.size(), second == CGNS_ENUMV(Inch) ? 1u : 0u);
    EXPECT_EQ(mentions(found.warnings, { "length units", "Inch", "'zone 2'", "Meter", "'zone 1'" }),
      second == CGNS_ENUMV(Inch));
  }
}

namespace
{

/// Ways in which an unstructured zone says which of its faces are the boundary "skin".
enum class HexZoneWay
{
  ElementsAtFaceCentre,
  ElementRange,
  ElementList,
  Points,
  PointsWithoutQuadrilaterals,
  Family,
  SectionAlone,
  MixedSection,
};

/// The blocks as unstructured zones, whose faces k = 0 are the boundary "skin", a wall.
void writeHexZones(const MeshCase& mesh, const std::string& fileName, HexZoneWay way, int fileType)
{
  int file = 0;
  int base = 0;
  require(cg_set_file_type(fileType));
  require(cg_open(fileName.c_str(), CG_MODE_WRITE, &file));
  require(cg_base_write(file, "Base", 3, 3, &base));
  if (way == HexZoneWay::Family)
  {
    family(file, "skin", CGNS_ENUMV(BCWall));
  }
  for (const MeshCase::Block& block : mesh.blocks)
  {
    const Ijk& n = block.counts;
    const auto point = [&](int i, int j, int k) { return cgsize_t(1) + i + cgsize_t(n[0]) * (j + n[1] * k); };
    std::vector<cgsize_t> cells;
    std::vector<cgsize_t> quads;
    std::vector<cgsize_t> mixed;
    for (int j = 0; j + 1 < n[1]; ++j)
    {
      for (int i = 0; i + 1 < n[0]; ++i)
      {
        const std::vector<cgsize_t> quad{ point(i, j, 0), point(i, j + 1, 0), point(i + 1, j + 1, 0),
          point(i + 1, j, 0) };
        quads.insert(quads.end(), quad.begin(), quad.end());
        for (int k = 0; k + 1 < n[2]; ++k)
        {
          std::vector<cgsize_t> cell;
          for (const int up : { k, k + 1 })
          {
            cell.insert(
              cell.end(), { point(i, j, up), point(i + 1, j, up), point(i + 1, j + 1, up), point(i, j + 1, up) });
          }
          cells.insert(cells.end(), cell.begin(), cell.end());
          mixed.push_back(CGNS_ENUMV(HEXA_8));
          mixed.insert(mixed.end(), cell.begin(), cell.end());
        }
      }
    }
    const auto cellCount = static_cast<cgsize_t>(cells.size() / 8);
    const auto quadCount = static_cast<cgsize_t>(quads.size() / 4);
    const cgsize_t size[3] = { static_cast<cgsize_t>(block.points.size()), cellCount, 0 };
    int zone = 0;
    int id = 0;
    const std::string name = "zone " + std::to_string(&block - mesh.blocks.data());
    require(cg_zone_write(file, base, name.c_str(), size, CGNS_ENUMV(Unstructured), &zone));
    const char* axes[3] = { "CoordinateX", "CoordinateY", "CoordinateZ" };
    for (int axis = 0; axis < 3; ++axis)
    {
      std::vector<double> values;
      for (const bsv::Vec3& x : block.points)
      {
        values.push_back(x[axis]);
      }
      require(cg_coord_write(file, base, zone, CGNS_ENUMV(RealDouble), axes[axis], values.data(), &id));
    }
    if (way == HexZoneWay::MixedSection)
    {
      std::vector<cgsize_t> offsets{ 0 };
      for (cgsize_t c = 0; c < cellCount; ++c)
      {
        offsets.push_back(offsets.back() + 9);
      }
      for (cgsize_t q = 0; q < quadCount; ++q)
      {
        mixed.push_back(CGNS_ENUMV(QUAD_4));
        mixed.insert(mixed.end(), quads.begin() + 4 * q, quads.begin() + 4 * q + 4);
        offsets.push_back(offsets.back() + 5);
      }
      require(cg_poly_section_write(
        file, base, zone, "all", CGNS_ENUMV(MIXED), 1, cellCount + quadCount, 0, mixed.data(), offsets.data(), &id));
    }
    else
    {
      require(cg_section_write(file, base, zone, "cells", CGNS_ENUMV(HEXA_8), 1, cellCount, 0, cells.data(), &id));
      if (way != HexZoneWay::PointsWithoutQuadrilaterals)
      {
        require(cg_section_write(file, base, zone, way == HexZoneWay::SectionAlone ? "skin" : "faces",
          CGNS_ENUMV(QUAD_4), cellCount + 1, cellCount + quadCount, 0, quads.data(), &id));
      }
    }
    if (way == HexZoneWay::SectionAlone)
    {
      continue;
    }
    std::vector<cgsize_t> numbers{ cellCount + 1, cellCount + quadCount };
    CGNS_ENUMT(PointSetType_t) set = CGNS_ENUMV(PointRange);
    if (way == HexZoneWay::ElementRange)
    {
      set = CGNS_ENUMV(ElementRange);
    }
    if (way == HexZoneWay::ElementList)
    {
      set = CGNS_ENUMV(PointList);
      numbers.clear();
      for (cgsize_t q = quadCount; q > 0; --q)
      {
        numbers.push_back(cellCount + q);
      }
    }
    const bool points = way == HexZoneWay::Points || way == HexZoneWay::PointsWithoutQuadrilaterals;
    if (points)
    {
      numbers = { 1, point(n[0] - 1, n[1] - 1, 0) };
    }
    const bool named = way == HexZoneWay::Family;
    require(
      cg_boco_write(file, base, zone, named ? "BC_1" : "skin", named ? CGNS_ENUMV(FamilySpecified) : CGNS_ENUMV(BCWall),
        set, static_cast<cgsize_t>(numbers.size()), numbers.data(), &id));
    if (!points && way != HexZoneWay::ElementRange)
    {
      require(cg_boco_gridlocation_write(file, base, zone, id, CGNS_ENUMV(FaceCenter)));
    }
    if (named)
    {
      require(cg_goto(file, base, "Zone_t", zone, "ZoneBC_t", 1, "BC_t", id, "end"));
      require(cg_famname_write("skin"));
    }
  }
  require(cg_close(file));
}

} // namespace

TEST(MeshFileHabits, UnstructuredZonesOfHexahedra)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  for (int way = 0; way <= int(HexZoneWay::MixedSection); ++way)
  {
    SCOPED_TRACE("way " + std::to_string(way));
    const int fileType = way % 2 == 0 ? CG_FILE_HDF5 : CG_FILE_ADF;
    const std::string fileName = folder / (std::to_string(way) + "-" + std::to_string(fileType) + ".cgns");
    writeHexZones(mesh, fileName, HexZoneWay(way), fileType);
    Reading reading;
    read(reading, fileName);
    ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
    EXPECT_TRUE(reading.warnings.empty()) << reading.warnings[0];
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
    const BlockMesh found = bsv::blockMesh(reading.output, grids);
    ASSERT_EQ(found.blocks.size(), 1u);
    EXPECT_EQ(found.blocks[0].points.size(), 8 * 4 * 3);
    ASSERT_EQ(found.boundaryNames, std::vector<std::string>{ "skin" });
    // A section alone has no type, but a name.
    const bool typed = way != int(HexZoneWay::SectionAlone);
    EXPECT_EQ(found.boundaryTypes,
      typed ? std::vector<std::string>{ "BCWall" } : std::vector<std::string>{ "BCTypeUserDefined" });
    const auto quads = boundaries(found);
    ASSERT_EQ(quads.size(), 1u);
    EXPECT_EQ(quads.begin()->second.size(), 7u * 3);
  }
  // Other cells are refused with their place.
  const std::string fileName = folder / "tetra.cgns";
  writeHexZones(mesh, fileName, HexZoneWay::SectionAlone, CG_FILE_HDF5);
  int file = 0;
  int id = 0;
  const cgsize_t tetrahedron[4] = { 1, 2, 3, 40 };
  require(cg_open(fileName.c_str(), CG_MODE_MODIFY, &file));
  require(cg_section_write(file, 1, 2, "rest", CGNS_ENUMV(TETRA_4), 99, 99, 0, tetrahedron, &id));
  require(cg_close(file));
  const std::string text = refusal(fileName);
  for (const char* word : { "zone 'zone 1'", "section 'rest', element 99, is a TETRA_4", "only hexahedra" })
  {
    EXPECT_NE(text.find(word), std::string::npos) << text;
  }
}

//----------------------------------------------------------------------------------------------------------------------
// Neutral maps

namespace
{

std::string replacedAll(std::string text, const std::string& from, const std::string& to)
{
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
  {
    text.replace(at, from.size(), to);
  }
  return text;
}

} // namespace

TEST(MeshFileHabits, NeutralMapsSpellContactsInManyWays)
{
  TemporaryFolder folder;
  MeshCase mesh = meshcases::latticeBlocks(
    { { { 0, 0, 0 }, { 2, 4, 3 } }, { { 2, 0, 0 }, { 5, 2, 3 } }, { { 2, 2, 0 }, { 4, 4, 3 } } }, meshcases::wavy);
  meshcases::shuffle(mesh, 3, true);
  mesh.boundaryNames = { "wall" };
  meshcases::declareAll(mesh, 3);
  const std::string plain = neutralMap(mesh);
  writeFile(folder / "plain.xyz", plot3D(mesh, {}));
  writeFile(folder / "plain.nmf", plain);
  const Result expected = readMesh(folder / "plain.xyz");
  ASSERT_EQ(expected.mesh.interfaces.size(), mesh.interfaces.size());
  for (const char* spelling : { "'one-to-one     '", "one_to_one", "One To One", "ONETOONE", "OneToOne", "'1-to-1'",
         "1-to-1", "1 to 1", "1to1", "1_TO_1", "\"One-To-One\"", "one 2 one", "Abutting1to1" })
  {
    SCOPED_TRACE(spelling);
    for (const char* extension : { "nmf", "NMF", "xyz.nmf" })
    {
      TemporaryFolder other;
      writeFile(other / "mesh.xyz", plot3D(mesh, {}));
      writeFile(other / (std::string("mesh.") + extension), replacedAll(plain, "ONE_TO_ONE", spelling));
      const Result found = readMesh(other / "mesh.xyz");
      EXPECT_EQ(boundaries(found.mesh), boundaries(expected.mesh));
      EXPECT_EQ(found.mesh.interfaces.size(), mesh.interfaces.size());
    }
  }
  // Each contact from both sides.
  MeshCase twice = mesh;
  for (const bsv::Interface& c : mesh.interfaces)
  {
    bsv::Interface back;
    back.blockA = c.blockB;
    back.faceA = c.faceB;
    back.rangeA = c.rangeB();
    back.blockB = c.blockA;
    back.faceB = c.faceA;
    back.originB = c.rangeA.lo;
    back.orientation = bsv::inverseOrientation(c.orientation);
    twice.interfaces.push_back(back);
  }
  writeFile(folder / "plain.nmf", neutralMap(twice));
  EXPECT_EQ(readMesh(folder / "plain.xyz").mesh.interfaces.size(), mesh.interfaces.size());
  // What editors write before the text.
  writeFile(folder / "plain.nmf", "\xef\xbb\xbf" + plain);
  EXPECT_EQ(readMesh(folder / "plain.xyz").mesh.interfaces.size(), mesh.interfaces.size());
  writeFile(folder / "plain.nmf", std::string("\xff\xfe") + "2");
  EXPECT_NE(refusal(folder / "plain.xyz").find("UTF-16"), std::string::npos);
  // Another word between two sides is never a boundary.
  for (const char* word : { "interior", "'block interface'" })
  {
    writeFile(folder / "plain.nmf", replacedAll(plain, "ONE_TO_ONE", word));
    EXPECT_NE(refusal(folder / "plain.xyz").find("two sides"), std::string::npos);
  }
}

TEST(MeshFileHabits, NeutralMapsAreTextsOfAnyProgram)
{
  TemporaryFolder folder;
  MeshCase mesh = meshcases::latticeBlocks(
    { { { 0, 0, 0 }, { 2, 4, 3 } }, { { 2, 0, 0 }, { 5, 2, 3 } }, { { 2, 2, 0 }, { 4, 4, 3 } } }, meshcases::wavy);
  meshcases::shuffle(mesh, 3, true);
  meshcases::declareAll(mesh, 3);
  mesh.boundaryNames = { "wall #2 // upper!" };
  for (bsv::BoundaryPatch& patch : mesh.boundaries)
  {
    patch.tag = 0;
  }
  const std::string plain = neutralMap(mesh);
  writeFile(folder / "mesh.xyz", plot3D(mesh, {}));
  writeFile(folder / "mesh.nmf", plain);
  const Result expected = readMesh(folder / "mesh.xyz");
  ASSERT_EQ(expected.mesh.interfaces.size(), mesh.interfaces.size());
  ASSERT_EQ(expected.mesh.boundaryNames, mesh.boundaryNames);

  std::string lower = plain;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  const std::pair<const char*, std::string> ways[] = { { "carriage returns", replacedAll(plain, "\n", "\r") },
    { "both line ends", replacedAll(plain, "\n", "\r\n") }, { "no last line end", plain.substr(0, plain.size() - 1) },
    { "tabs", replacedAll(plain, "  ", "\t") }, { "lower case", lower },
    { "exclamation marks", replacedAll(replacedAll(plain, "# comment", "! comment"), "# size", "!size") },
    { "slashes", replacedAll(replacedAll(plain, "# comment", "// comment"), "# size", "//size") },
    { "numbers as flags", replacedAll(replacedAll(plain, "TRUE", "1"), "FALSE", "0") },
    { "flags of Fortran", replacedAll(replacedAll(plain, "TRUE", ".true."), "FALSE", ".F.") } };
  for (const auto& [what, text] : ways)
  {
    SCOPED_TRACE(what);
    writeFile(folder / "mesh.nmf", text);
    const Result found = readMesh(folder / "mesh.xyz");
    EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
    EXPECT_EQ(found.mesh.boundaryNames, mesh.boundaryNames);
    EXPECT_EQ(boundaries(found.mesh), boundaries(expected.mesh));
    EXPECT_EQ(found.mesh.interfaces.size(), mesh.interfaces.size());
  }
}

TEST(MeshFileHabits, NeutralMapsWithoutSwapFlags)
{
  TemporaryFolder folder;
  const auto withoutFlags = [](const MeshCase& mesh) {
    return replacedAll(replacedAll(neutralMap(mesh), " TRUE\n", "\n"), " FALSE\n", "\n");
  };
  // Contacts of 3 x 2 cells fit in one way.
  for (unsigned int seed = 1; seed <= 8; ++seed)
  {
    MeshCase mesh = twoBlocks();
    meshcases::shuffle(mesh, seed, true);
    writeFile(folder / "mesh.xyz", plot3D(mesh, {}));
    writeFile(folder / "mesh.nmf", withoutFlags(mesh));
    const Result found = readMesh(folder / "mesh.xyz");
    EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
    EXPECT_EQ(found.mesh.interfaces.size(), mesh.interfaces.size());
  }
  // Those of 2 x 2 cells do not: the points decide.
  MeshCase square = meshcases::cutBox({ 7, 2, 2 }, { { { 4 }, {}, {} } }, meshcases::wavy);
  meshcases::declareAll(square);
  writeFile(folder / "mesh.xyz", plot3D(square, {}));
  writeFile(folder / "mesh.nmf", withoutFlags(square));
  const Result found = readMesh(folder / "mesh.xyz");
  EXPECT_TRUE(mentions(found.warnings, { "swap flag", "line 7" })) << (found.warnings.empty() ? "" : found.warnings[0]);
  EXPECT_TRUE(found.mesh.interfaces.empty());
  const bsv::BlockComplex complex = bsv::buildBlockComplex(found.mesh);
  EXPECT_EQ(
    std::count_if(complex.faces.begin(), complex.faces.end(), [](const auto& f) { return f.uses.size() == 2; }), 1);
}

TEST(MeshFileHabits, NamesBehindBoundariesOfNeutralMaps)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  writeFile(folder / "mesh.xyz", plot3D(mesh, {}));
  const std::string contacts = neutralMap(mesh);
  // Two boundaries of one type, with what may stand behind their ranges.
  const auto read = [&](const std::string& first, const std::string& second) {
    writeFile(
      folder / "mesh.nmf", contacts + "viscous 1 1 1 5 1 4 " + first + "\nviscous 2 1 1 4 1 4 " + second + "\n");
    const Result found = readMesh(folder / "mesh.xyz");
    EXPECT_TRUE(found.warnings.empty()) << found.warnings[0];
    EXPECT_EQ(found.mesh.boundaryTypes, std::vector<std::string>(found.mesh.boundaryNames.size(), "BCWallViscous"));
    return found.mesh.boundaryNames;
  };
  const std::vector<std::string> both{ "wing", "my fuselage" };
  EXPECT_EQ(read("wing", "my fuselage"), both);
  EXPECT_EQ(read("'wing'", "'my fuselage'  # the rest"), both);
  // Flags, numbers and comments are no names.
  for (const char* other : { "", "FALSE", "# wing", "0", "0 0 FALSE" })
  {
    EXPECT_EQ(read(other, other), std::vector<std::string>{ "viscous" }) << other;
  }
}

TEST(MeshFileHabits, PeriodicSidesOfNeutralMapsAreBoundaries)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  writeFile(folder / "mesh.xyz", plot3D(mesh, {}));
  const std::string contacts = neutralMap(mesh);
  // i min of the first block against i max of the second: 3 x 2 cells.
  const std::string sides = " 1 3 1 4 1 3  2 4 1 4 1 3";
  for (const char* word : { "PERIODIC", "periodic", "'one-to-one periodic'", "Cyclic", "translational periodic" })
  {
    for (const char* flag : { "", " FALSE", " TRUE" })
    {
      SCOPED_TRACE(std::string(word) + flag);
      writeFile(folder / "mesh.nmf", contacts + word + sides + flag + "\n");
      const Result found = readMesh(folder / "mesh.xyz");
      ASSERT_EQ(found.mesh.boundaryNames.size(), 1u);
      EXPECT_EQ(boundaries(found.mesh).begin()->second.size(), 12u);
      EXPECT_EQ(found.mesh.interfaces.size(), mesh.interfaces.size());
      EXPECT_EQ(found.warnings.size(), 1u);
      EXPECT_TRUE(mentions(found.warnings, { "periodic sides are not joined", "line 8 of the neutral map" }));
    }
  }
  // One side a row.
  writeFile(folder / "mesh.nmf", contacts + "PERIODIC 1 3 1 4 1 3\nPERIODIC 2 4 1 4 1 3\n");
  const Result found = readMesh(folder / "mesh.xyz");
  EXPECT_TRUE(found.warnings.empty());
  EXPECT_EQ(boundaries(found.mesh).begin()->second.size(), 12u);
}

TEST(MeshFileHabits, FacesThatNeutralMapsDoNotDescribeAreSaid)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  writeFile(folder / "mesh.xyz", plot3D(mesh, {}));
  writeFile(folder / "mesh.nmf", neutralMap(mesh) + "PATCHED 1 3 1 4 1 3\nUNPROCESSED 2 4 1 4 1 3\n");
  const Result found = readMesh(folder / "mesh.xyz");
  EXPECT_EQ(found.warnings.size(), 1u);
  EXPECT_TRUE(mentions(
    found.warnings, { "patched", "line 8 of the neutral map (PATCHED)", "line 9 of the neutral map (UNPROCESSED)" }));
  EXPECT_TRUE(found.mesh.boundaries.empty());
}

TEST(MeshFileHabits, NeutralMapsLeaveOutBoundariesThatDoNotFit)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  writeFile(folder / "mesh.xyz", plot3D(mesh, {}));
  const std::string contacts = neutralMap(mesh);
  // On the contact, beyond the face, of no block, on no face.
  writeFile(folder / "mesh.nmf",
    contacts + "skin 1 4 1 4 1 3\nskin 1 3 1 9 1 3\nskin 7 3 1 4 1 3\nskin 1 8 1 4 1 3\nviscous_solid 1 1 1 5 1 4\n");
  const Result found = readMesh(folder / "mesh.xyz");
  EXPECT_EQ(boundaries(found.mesh)["viscous_solid: BCWallViscous"].size(), 12u);
  EXPECT_EQ(boundaries(found.mesh).size(), 1u);
  EXPECT_TRUE(mentions(found.warnings, { "'skin'", "block 'block 1'", "i max", "interface" }));
  EXPECT_TRUE(mentions(found.warnings, { "mesh.nmf, line", "9 is out of range 1..4", "block 7", "face 8" }));
}

//----------------------------------------------------------------------------------------------------------------------
// PLOT3D

namespace
{

/// A record of integers and reals, in native order between markers of 4 bytes.
std::string record(const std::vector<std::int32_t>& integers, const std::vector<double>& reals)
{
  std::string content;
  for (const std::int32_t value : integers)
  {
    append(content, value, false);
  }
  for (const double value : reals)
  {
    append(content, value, false);
  }
  std::string marker;
  append(marker, std::int32_t(content.size()), false);
  return marker + content + marker;
}

std::string textOf(const std::vector<std::int32_t>& integers, const std::vector<double>& reals)
{
  std::string text;
  for (const std::int32_t value : integers)
  {
    text += std::to_string(value) + " ";
  }
  text += "\n";
  for (const double value : reals)
  {
    text += std::to_string(value) + "\n";
  }
  return text;
}

std::vector<double> someValues(int count)
{
  std::vector<double> values;
  for (int v = 0; v < count; ++v)
  {
    values.push_back(0.25 + v % 17);
  }
  return values;
}

} // namespace

TEST(MeshFileHabits, OtherPlot3DFilesAreNamed)
{
  TemporaryFolder folder;
  struct Kind
  {
    const char* word;
    /// One record after the number of blocks for the counts of two blocks, then those of each block.
    std::vector<std::int32_t> counts;
    std::vector<std::vector<int>> records;
  };
  const std::vector<Kind> kinds = {
    { "two-dimensional grid", { 5, 4, 3, 6 }, { { 40 }, { 36 } } },
    { "solution file", { 5, 4, 3, 2, 3, 4 }, { { 4, 300 }, { 4, 120 } } },
    { "function file", { 5, 4, 3, 2, 2, 3, 4, 2 }, { { 120 }, { 48 } } },
  };
  for (const Kind& kind : kinds)
  {
    SCOPED_TRACE(kind.word);
    std::string fortran = record({ 2 }, {}) + record(kind.counts, {});
    std::vector<std::int32_t> header = kind.counts;
    header.insert(header.begin(), 2);
    std::vector<double> all;
    for (const std::vector<int>& block : kind.records)
    {
      for (const int count : block)
      {
        const std::vector<double> values = someValues(count);
        fortran += record({}, values);
        all.insert(all.end(), values.begin(), values.end());
      }
    }
    writeFile(folder / "fortran.x", fortran);
    writeFile(folder / "text.x", textOf(header, all));
    std::string raw;
    for (const std::int32_t value : header)
    {
      append(raw, value, false);
    }
    for (const double value : all)
    {
      append(raw, value, false);
    }
    writeFile(folder / "raw.x", raw);
    for (const char* name : { "fortran.x", "text.x", "raw.x" })
    {
      EXPECT_NE(refusal(folder / name).find(kind.word), std::string::npos) << name;
    }
  }
}

TEST(MeshFileHabits, OtherGridsAndSolutionsAreNamed)
{
  TemporaryFolder folder;
  // Two-dimensional grids with iblank, of one block and of two.
  const std::vector<double> blanks(20, 1.0);
  const auto joined = [](std::vector<double> a, const std::vector<double>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  };
  const std::vector<double> block = joined(someValues(40), blanks);
  writeFile(folder / "one.x", textOf({ 5, 4 }, block));
  writeFile(folder / "two.x", textOf({ 2, 5, 4, 4, 5 }, joined(block, block)));
  for (const char* name : { "one.x", "two.x" })
  {
    EXPECT_NE(refusal(folder / name).find("two-dimensional grid"), std::string::npos) << refusal(folder / name);
  }
  // The counts of each block before its points, with and without the number of blocks.
  const std::string blocks = textOf({ 3, 4, 2 }, someValues(72)) + textOf({ 2, 3, 2 }, someValues(36));
  writeFile(folder / "counted.x", "2\n" + blocks);
  writeFile(folder / "uncounted.x", blocks);
  for (const char* name : { "counted.x", "uncounted.x" })
  {
    EXPECT_NE(refusal(folder / name).find("counts of each block before its points"), std::string::npos)
      << refusal(folder / name);
  }
  // OVERFLOW: 6 variables and no species; 13 or 16 flow conditions.
  const auto solution = [](int conditions) { return record({}, someValues(conditions)) + record({}, someValues(180)); };
  writeFile(folder / "one.q", record({ 5, 3, 2, 6, 0 }, {}) + solution(16));
  writeFile(folder / "two.q", record({ 2 }, {}) + record({ 5, 3, 2, 2, 3, 5, 6, 0 }, {}) + solution(13) + solution(13));
  for (const char* name : { "one.q", "two.q" })
  {
    EXPECT_NE(refusal(folder / name).find("solution file of OVERFLOW"), std::string::npos) << refusal(folder / name);
  }
}

TEST(MeshFileHabits, PlanesFormatIsNamed)
{
  TemporaryFolder folder;
  const MeshCase mesh = meshcases::cutBox({ 4, 3, 5 }, {}, meshcases::wavy);
  const MeshCase::Block& block = mesh.blocks[0];
  std::vector<double> values;
  std::string fortran = record({ 1 }, {}) + record({ 5, 4, 6 }, {});
  for (int k = 0; k < 6; ++k)
  {
    std::vector<double> plane;
    for (int axis = 0; axis < 3; ++axis)
    {
      for (int j = 0; j < 4; ++j)
      {
        for (int i = 0; i < 5; ++i)
        {
          plane.push_back(block.at({ i, j, k })[axis]);
        }
      }
    }
    fortran += record({}, plane);
    values.insert(values.end(), plane.begin(), plane.end());
  }
  writeFile(folder / "fortran.x", fortran);
  writeFile(folder / "text.x", textOf({ 1, 5, 4, 6 }, values));
  for (const char* name : { "fortran.x", "text.x" })
  {
    EXPECT_NE(refusal(folder / name).find("planes format"), std::string::npos) << name;
  }
}

TEST(MeshFileHabits, PointAfterPointIsNamed)
{
  TemporaryFolder folder;
  const MeshCase mesh = meshcases::cutBox({ 4, 3, 5 }, {}, meshcases::wavy);
  std::vector<double> values;
  for (const bsv::Vec3& point : mesh.blocks[0].points)
  {
    values.insert(values.end(), point.data(), point.data() + 3);
  }
  writeFile(folder / "text.x", textOf({ 1, 5, 4, 6 }, values));
  EXPECT_NE(refusal(folder / "text.x").find("x, y and z of one point after the other"), std::string::npos);
}

TEST(MeshFileHabits, CommentsBeforeThePointsAreLeftOut)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  Plot3DKind ascii;
  ascii.ascii = true;
  ascii.multiBlock = true;
  const std::string plain = plot3D(mesh, ascii);
  writeFile(folder / "plain.xyz", plain);
  const Result expected = readMesh(folder / "plain.xyz");
  const std::string mark = "\xef\xbb\xbf";
  const std::pair<std::string, int> heads[] = { { "# a wing\n", 1 }, { "! 2 blocks\r\n!\r\n", 2 },
    { "\n  // made by hand\n\n", 1 }, { mark + "# \xc3\xbc\n", 1 }, { std::string("/\r") + "% percent\r", 2 },
    { "#" + std::string(900, '-') + "\n", 1 } };
  for (const auto& [head, lines] : heads)
  {
    SCOPED_TRACE(head);
    const std::string text = head.find('\n') == std::string::npos ? replacedAll(plain, "\n", "\r") : plain;
    writeFile(folder / "mesh.xyz", head + text);
    EXPECT_EQ(vtkHexBlockMeshReader::CanReadFile((folder / "mesh.xyz").c_str()), 1);
    const Result found = readMesh(folder / "mesh.xyz");
    EXPECT_EQ(found.warnings.size(), 1u);
    EXPECT_TRUE(mentions(found.warnings,
      { "comments at its beginning", "(" + std::to_string(lines) + (lines == 1 ? " line)" : " lines)") }));
    ASSERT_EQ(found.mesh.blocks.size(), expected.mesh.blocks.size());
    for (std::size_t b = 0; b < expected.mesh.blocks.size(); ++b)
    {
      const bsv::GridView& points = expected.mesh.blocks[b].points;
      ASSERT_EQ(found.mesh.blocks[b].points.counts(), points.counts());
      for (bsv::Index p = 0; p < points.size(); ++p)
      {
        ASSERT_EQ(found.mesh.blocks[b].points.atPlace(p), points.atPlace(p));
      }
    }
  }
  // Lines are counted from the beginning of the file, and comments among the numbers are no numbers.
  writeFile(folder / "mesh.xyz", "# a\n# b\n" + replacedAll(plain, "\n", "\n# c\n"));
  const std::string error = refusal(folder / "mesh.xyz");
  EXPECT_NE(error.find("line 4"), std::string::npos) << error;
  EXPECT_NE(error.find("PLOT3D has no comments"), std::string::npos) << error;
  writeFile(folder / "mesh.xyz", "2 ! blocks\n" + plain);
  EXPECT_NE(refusal(folder / "mesh.xyz").find("line 1"), std::string::npos);
  EXPECT_NE(refusal(folder / "mesh.xyz").find("PLOT3D has no comments"), std::string::npos);
  writeFile(folder / "mesh.xyz", "# nothing else\n");
  EXPECT_NE(refusal(folder / "mesh.xyz").find("the file ends too early"), std::string::npos);
  // A binary file may begin with any of the characters: 35 points along i.
  const MeshCase long_ = meshcases::cutBox({ 34, 9, 1 }, { { {}, {}, {} } }, meshcases::wavy);
  Plot3DKind raw;
  raw.marker = 0;
  raw.multiBlock = false;
  const std::string bytes = plot3D(long_, raw);
  ASSERT_EQ(bytes.substr(0, 5), std::string("#\0\0\0\n", 5));
  writeFile(folder / "mesh.xyz", bytes);
  const Result binary = readMesh(folder / "mesh.xyz");
  EXPECT_TRUE(binary.warnings.empty());
  EXPECT_EQ(binary.mesh.blocks[0].points.counts(), (bsv::Ijk{ 35, 10, 2 }));
}

TEST(MeshFileHabits, DecimalCommasAreNamed)
{
  TemporaryFolder folder;
  std::string text = plot3D(meshcases::cutBox({ 4, 3, 5 }, {}, meshcases::wavy), { true });
  for (std::size_t at = text.find('\n', text.find('\n') + 1); at != std::string::npos; at = text.find(' ', at + 1))
  {
    // Each number with a point that becomes a comma.
    const std::size_t end = text.find_first_of(" \n", at + 1);
    const std::size_t point = text.find('.', at);
    if (point < end)
    {
      text[point] = ',';
    }
    else if (end != std::string::npos && std::isdigit(static_cast<unsigned char>(text[end - 1])))
    {
      text.insert(end, ",0");
    }
  }
  writeFile(folder / "commas.x", text);
  EXPECT_NE(refusal(folder / "commas.x").find("decimal commas"), std::string::npos) << refusal(folder / "commas.x");
}

TEST(MeshFileHabits, EncodingsAndPackedFilesAreNamed)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  const std::string text = plot3D(mesh, { true });
  writeFile(folder / "plain.x", text);
  writeFile(folder / "mark.x", "\xef\xbb\xbf" + text + "\x1a"); // and that of DOS at its end
  EXPECT_EQ(readMesh(folder / "mark.x").mesh.blocks[1].points(2, 1, 1),
    readMesh(folder / "plain.x").mesh.blocks[1].points(2, 1, 1));
  EXPECT_EQ(vtkHexBlockMeshReader::CanReadFile((folder / "mark.x").c_str()), 1);
  std::string wide = "\xff\xfe";
  for (const char c : text)
  {
    wide += c;
    wide += '\0';
  }
  writeFile(folder / "wide.x", wide);
  EXPECT_NE(refusal(folder / "wide.x").find("UTF-16"), std::string::npos);
  writeFile(folder / "packed.x", "\x1f\x8b\x08 and so on");
  EXPECT_NE(refusal(folder / "packed.x").find("gzip"), std::string::npos);
}

TEST(MeshFileHabits, IntegersOfEightBytes)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  for (const int marker : { 0, 4, 8 })
  {
    for (const bool bigEndian : { false, true })
    {
      std::string file;
      std::string content;
      const auto end = [&] {
        std::string mark;
        marker == 4 ? append(mark, std::int32_t(content.size()), bigEndian)
                    : append(mark, std::int64_t(content.size()), bigEndian);
        mark = marker == 0 ? "" : mark;
        file += mark + content + mark;
        content.clear();
      };
      append(content, std::int64_t(mesh.blocks.size()), bigEndian);
      end();
      for (const MeshCase::Block& block : mesh.blocks)
      {
        for (const int count : block.counts)
        {
          append(content, std::int64_t(count), bigEndian);
        }
      }
      end();
      for (const MeshCase::Block& block : mesh.blocks)
      {
        for (int axis = 0; axis < 3; ++axis)
        {
          for (const bsv::Vec3& x : block.points)
          {
            append(content, x[axis], bigEndian);
          }
        }
        for (std::size_t p = 0; p < block.points.size(); ++p)
        {
          append(content, std::int64_t(1), bigEndian);
        }
        end();
      }
      writeFile(folder / "mesh.x", file);
      const Result found = readMesh(folder / "mesh.x");
      EXPECT_TRUE(found.warnings.empty());
      ASSERT_EQ(found.mesh.blocks.size(), mesh.blocks.size());
      EXPECT_EQ(found.mesh.blocks[1].points(3, 2, 1), mesh.blocks[1].at({ 3, 2, 1 }));
    }
  }
}

TEST(MeshFileHabits, BlankedCellsAreCountedAndHidden)
{
  TemporaryFolder folder;
  const MeshCase mesh = twoBlocks();
  Plot3DKind kind;
  kind.iblank = true;
  writeFile(folder / "mesh.x", plot3D(mesh, kind));
  int blanked = 0;
  int interpolated = 0;
  for (const MeshCase::Block& block : mesh.blocks)
  {
    for (std::size_t p = 0; p < block.points.size(); ++p)
    {
      blanked += iblankValue(p) == 0;
      interpolated += iblankValue(p) < 0;
    }
  }
  const Result found = readMesh(folder / "mesh.x");
  EXPECT_TRUE(mentions(found.warnings, { std::to_string(blanked) + " points", std::to_string(interpolated) + " as" }));
  for (const auto& grid : found.grids)
  {
    vtkUnsignedCharArray* ghosts = grid->GetCellGhostArray();
    ASSERT_NE(ghosts, nullptr);
    auto* iblank = grid->GetPointData()->GetArray("IBlank");
    for (vtkIdType cell = 0; cell < grid->GetNumberOfCells(); ++cell)
    {
      vtkNew<vtkIdList> points;
      grid->GetCellPoints(cell, points);
      bool hidden = false;
      for (vtkIdType p = 0; p < points->GetNumberOfIds(); ++p)
      {
        hidden = hidden || iblank->GetComponent(points->GetId(p), 0) == 0.0;
      }
      ASSERT_EQ((ghosts->GetValue(cell) & vtkDataSetAttributes::HIDDENCELL) != 0, hidden);
    }
  }
}

TEST(MeshFileHabits, WhatIsNoFileIsRefusedAtOnce)
{
  TemporaryFolder folder;
  std::filesystem::create_directory(folder / "folder.x");
  EXPECT_NE(refusal(folder / "folder.x").find("not a regular file"), std::string::npos);
  writeFile(folder / "sparse.x", "12");
  std::filesystem::resize_file(folder / "sparse.x", std::uintmax_t(5) << 30);
  EXPECT_FALSE(refusal(folder / "sparse.x").empty());
  EXPECT_FALSE(refusal("/dev/zero").empty());
  for (const char* name : { "folder.x", "sparse.x" })
  {
    EXPECT_EQ(vtkHexBlockMeshReader::CanReadFile((folder / name).c_str()), 0);
  }
}

// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/CGNSTree.h"

#include "Base/Types.h"
#include "Base/UTF8.h"

#include <vtk_cgns.h>
// clang-format off
#include VTK_CGNS(cgnslib.h)
#include VTK_CGNS(cgns_io.h)
// clang-format on
#include <vtk_hdf5.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>
#include <vector>

namespace bsv
{

namespace
{

/// Bytes of a value of the type, 0 for nodes without data, -1 for an unknown type.
int valueSize(const std::string& type)
{
  if (type == "MT" || type == "LK")
  {
    return 0;
  }
  if (type == "C1" || type == "B1" || type == "U1" || type == "I1")
  {
    return 1;
  }
  if (type == "I4" || type == "U4" || type == "R4")
  {
    return 4;
  }
  if (type == "I8" || type == "U8" || type == "R8" || type == "X4")
  {
    return 8;
  }
  return type == "X8" ? 16 : -1;
}

/// The types that the library can read for nodes of a label; it ends the process for some others. Null: any.
const char* typesOf(const std::string& label)
{
  static const std::map<std::string, const char*> types = { { "CGNSLibraryVersion_t", "R4" }, { "CGNSBase_t", "I4" },
    { "Zone_t", "I4 I8" }, { "ZoneType_t", "C1" }, { "GridConnectivity1to1_t", "C1" }, { "GridConnectivity_t", "C1" },
    { "GridConnectivityType_t", "C1" }, { "BC_t", "C1" }, { "FamilyName_t", "C1" }, { "AdditionalFamilyName_t", "C1" },
    { "FamilyBC_t", "C1" }, { "GridLocation_t", "C1" }, { "Descriptor_t", "C1" }, { "DataClass_t", "C1" },
    { "SimulationType_t", "C1" }, { "\"int[IndexDimension]\"", "I4" }, { "IndexRange_t", "I4 I8" },
    { "IndexArray_t", "I4 I8 R4 R8" }, { "Ordinal_t", "I4" }, { "Elements_t", "I4" } };
  const auto found = types.find(label);
  return found == types.end() ? nullptr : found->second;
}

/// The standard nests to about 10; a node that is its own descendant never ends.
constexpr int MaxDepth = 30;

/// Adds the groups below `group` that do not keep in which order their members were made, by their paths, with the
/// number of members that are nodes. @param left groups that may still be looked at: links can go round
void addUnordered(hid_t group, const std::string& path, int depth, int& left, std::map<std::string, int>& found)
{
  std::vector<std::string> nodes;
  H5G_info_t info;
  if (depth > MaxDepth || --left < 0 || H5Gget_info(group, &info) < 0)
  {
    return;
  }
  for (hsize_t n = 0; n < info.nlinks; ++n)
  {
    std::array<char, 1024> name{};
    // What belongs to the node itself begins with a blank.
    if (H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, n, name.data(), name.size(), H5P_DEFAULT) > 0 &&
      name[0] != ' ')
    {
      nodes.emplace_back(name.data());
    }
  }
  const hid_t made = H5Gget_create_plist(group);
  unsigned int order = 0;
  const bool known = H5Pget_link_creation_order(made, &order) >= 0;
  H5Pclose(made);
  if (known && (order & H5P_CRT_ORDER_TRACKED) == 0 && !nodes.empty())
  {
    found.emplace(path, static_cast<int>(nodes.size()));
    return; // one is enough
  }
  for (const std::string& node : nodes)
  {
    const hid_t below = H5Gopen2(group, node.c_str(), H5P_DEFAULT);
    if (below >= 0)
    {
      addUnordered(below, path + "/" + node, depth + 1, left, found);
      H5Gclose(below);
    }
  }
}

/// Some versions of the CGNS library ask HDF5 for the children of a node in the order in which they were made, and see
/// none where HDF5 was not told to keep it: then zones or boundary conditions would be missing without a word.
std::map<std::string, int> unorderedNodes(const std::string& fileName)
{
  H5E_auto2_t report = nullptr;
  void* data = nullptr;
  H5Eget_auto2(H5E_DEFAULT, &report, &data);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  std::map<std::string, int> found;
  const hid_t file = H5Fopen(fileName.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT); // fails for ADF
  const hid_t root = file < 0 ? file : H5Gopen2(file, "/", H5P_DEFAULT);
  // Other files of HDF5 are refused as such.
  if (root >= 0 && H5Lexists(root, "CGNSLibraryVersion", H5P_DEFAULT) > 0)
  {
    constexpr int MostGroups = 1 << 20;
    int left = MostGroups;
    addUnordered(root, "", 0, left, found);
  }
  if (root >= 0)
  {
    H5Gclose(root);
  }
  if (file >= 0)
  {
    H5Fclose(file);
  }
  H5Eset_auto2(H5E_DEFAULT, report, data);
  return found;
}

class TreeCheck
{
public:
  explicit TreeCheck(const std::string& fileName)
    : FileName(fileName)
    , Unordered(unorderedNodes(fileName))
  {
    std::error_code failure;
    this->Bytes = static_cast<Index>(std::filesystem::file_size(fileName, failure));
    this->check(
      failure ? CGIO_ERR_FILE_OPEN : cgio_open_file(fileName.c_str(), CGIO_MODE_READ, CGIO_FILE_NONE, &this->File), "");
    int type = CGIO_FILE_NONE;
    cgio_get_file_type(this->File, &type);
    // HDF5 can compress, at most about a thousandfold.
    this->Limit = type == CGIO_FILE_HDF5 ? 1000 * this->Bytes : this->Bytes;
  }
  ~TreeCheck()
  {
    if (this->File != 0)
    {
      cgio_close_file(this->File);
    }
  }
  TreeCheck(const TreeCheck&) = delete;
  TreeCheck& operator=(const TreeCheck&) = delete;

  std::set<std::string> run()
  {
    double root = 0.0;
    this->check(cgio_get_root_id(this->File, &root), "");
    this->checkChildren(root, "", 0);
    return this->WithoutPoints;
  }

private:
  /// Smallest space of a node in either format.
  static constexpr Index MinNodeBytes = 64;

  [[noreturn]] void fail(const std::string& path, const std::string& what) const
  {
    throw Error(this->FileName + (path.empty() ? "" : ", node " + path) + ": " + what);
  }

  void check(int status, const std::string& path) const
  {
    if (status != CGIO_ERR_NONE)
    {
      std::array<char, 1024> text{};
      cgio_error_message(text.data());
      this->fail(path, std::string("the file cannot be read as CGNS, it is damaged or no such file: ") + text.data());
    }
  }

  void checkChildren(double node, const std::string& path, int depth)
  {
    int children = 0;
    this->check(cgio_number_children(this->File, node, &children), path);
    this->Nodes += children;
    if (children < 0 || this->Nodes > this->Bytes / MinNodeBytes || depth > MaxDepth)
    {
      this->fail(path,
        "there are " + std::to_string(children) + " child nodes at depth " + std::to_string(depth) + ", " +
          std::to_string(this->Nodes) + " nodes so far; the file of " + std::to_string(this->Bytes) +
          " bytes cannot hold them");
    }
    const auto unordered = this->Unordered.find(path);
    if (unordered != this->Unordered.end() && children < unordered->second)
    {
      this->fail(path,
        "the CGNS library finds " + std::to_string(children) + " of its " + std::to_string(unordered->second) +
          " child nodes, since the program that wrote the file did not let HDF5 keep their order; cgnsconvert -h -f " +
          "writes it anew as it should be");
    }
    if (children == 0)
    {
      return;
    }
    std::vector<double> ids(static_cast<std::size_t>(children));
    int found = 0;
    this->check(cgio_children_ids(this->File, node, 1, children, &found, ids.data()), path);
    ids.resize(static_cast<std::size_t>(found));
    for (const double id : ids)
    {
      std::array<char, 1024> name{};
      this->check(cgio_get_name(this->File, id, name.data()), path);
      this->checkNode(id, path + "/" + name.data(), depth + 1);
      cgio_release_id(this->File, id);
    }
  }

  /// Names what a link leads to that is not there, which the library does not.
  void checkLink(double node, const std::string& path) const
  {
    std::array<char, 1024> text{};
    int fileLength = 0;
    int nameLength = 0;
    constexpr int Longest = 1 << 16;
    if (cgio_get_label(this->File, node, text.data()) == CGIO_ERR_NONE ||
      cgio_link_size(this->File, node, &fileLength, &nameLength) != CGIO_ERR_NONE || fileLength < 0 || nameLength < 0 ||
      fileLength > Longest || nameLength > Longest)
    {
      return;
    }
    std::vector<char> file(fileLength + 1, 0);
    std::vector<char> name(nameLength + 1, 0);
    this->check(cgio_get_link(this->File, node, file.data(), name.data()), path);
    this->fail(path,
      "the node is a link to " + validUTF8(name.data()) +
        (fileLength > 0 ? " of the file '" + validUTF8(file.data()) + "'" : "") +
        ", which cannot be found; links without a folder begin at the file itself");
  }

  void checkNode(double node, const std::string& path, int depth)
  {
    int link = 0;
    this->check(cgio_is_link(this->File, node, &link), path);
    if (link < 0)
    {
      this->fail(path, "the node is a link with a name of " + std::to_string(link) + " characters");
    }
    if (link > 0)
    {
      this->checkLink(node, path);
      return;
    }
    std::array<char, 1024> text{};
    this->check(cgio_get_label(this->File, node, text.data()), path);
    const std::string label = text.data();
    if (label == "BC_t")
    {
      this->WithoutPoints.insert(path);
    }
    if (label == "IndexRange_t" || label == "IndexArray_t")
    {
      const std::size_t slash = path.rfind('/');
      const std::string name = path.substr(slash + 1);
      const bool points = name.rfind("Point", 0) == 0 || name.rfind("Element", 0) == 0;
      this->WithoutPoints.erase(points ? path.substr(0, slash) : "");
    }
    this->check(cgio_get_data_type(this->File, node, text.data()), path);
    const std::string type = text.data();
    const int size = valueSize(type);
    if (size < 0)
    {
      this->fail(path, "the data type '" + type.substr(0, 8) + "' is unknown");
    }
    const char* allowed = typesOf(label);
    if (allowed && type != "MT" && type != "LK" && std::string(allowed).find(type) == std::string::npos)
    {
      this->fail(path, "the node of kind " + label + " has data of type " + type + ", not of " + allowed);
    }
    int dimensions = 0;
    std::array<cgsize_t, CGIO_MAX_DIMENSIONS> counts{};
    if (size > 0)
    {
      this->check(cgio_get_dimensions(this->File, node, &dimensions, counts.data()), path);
    }
    dimensions = std::min(dimensions, CGIO_MAX_DIMENSIONS);
    double bytes = size;
    bool inRange = true;
    std::string shape;
    for (int d = 0; d < dimensions; ++d)
    {
      bytes *= double(counts[d]);
      inRange = inRange && counts[d] >= 0 && counts[d] <= this->Limit;
      shape += (d == 0 ? "" : " x ") + std::to_string(counts[d]);
    }
    if (!inRange || bytes > double(this->Limit))
    {
      this->fail(path,
        "the node claims " + shape + " values of type " + type + ", but the file has only " +
          std::to_string(this->Bytes) + " bytes");
    }
    this->checkChildren(node, path, depth);
  }

  std::string FileName;
  const std::map<std::string, int> Unordered;
  int File = 0;
  Index Bytes = 0;
  Index Limit = 0;
  Index Nodes = 0;
  std::set<std::string> WithoutPoints;
};

} // namespace

std::set<std::string> checkCGNSTree(const std::string& fileName)
{
  return TreeCheck(fileName).run();
}

} // namespace bsv

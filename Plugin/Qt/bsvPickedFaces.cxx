// SPDX-License-Identifier: BSD-3-Clause
#include "bsvPickedFaces.h"

#include "pqOutputPort.h"
#include "vtkDataAssembly.h"
#include "vtkDataObject.h"
#include "vtkDataObjectTypes.h"
#include "vtkPVDataInformation.h"
#include "vtkSMOutputPort.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSourceProxy.h"
#include "vtkSelectionNode.h"
#include "vtkType.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <vector>

namespace bsv
{

namespace
{

/// Cells by the number of their block; false if the selection holds anything else.
bool selectedCells(pqOutputPort* mesh, std::map<int, std::vector<vtkIdType>>& cells)
{
  vtkSMSourceProxy* all = mesh->getSelectionInput();
  if (!all || !all->GetProperty("Input"))
  {
    return false;
  }
  vtkSMPropertyHelper inputs(all, "Input");
  for (unsigned int n = 0; n < inputs.GetNumberOfElements(); ++n)
  {
    vtkSMProxy* source = inputs.GetAsProxy(n);
    if (!source || std::strcmp(source->GetXMLName(), "CompositeDataIDSelectionSource") != 0 ||
      vtkSMPropertyHelper(source, "FieldType").GetAsInt() != vtkSelectionNode::CELL)
    {
      return false;
    }
    // Index in the tree, process, cell.
    vtkSMPropertyHelper ids(source, "IDs");
    for (unsigned int i = 0; i + 2 < ids.GetNumberOfElements(); i += 3)
    {
      // The root is 0; every block has a node and below it one with its grid.
      cells[static_cast<int>((ids.GetAsIdType(i) - 1) / 2)].push_back(ids.GetAsIdType(i + 2));
    }
  }
  return !cells.empty();
}

/// Cells per direction of a block.
bool blockSize(pqOutputPort* mesh, int block, std::array<vtkIdType, 3>& size)
{
  vtkDataAssembly* tree = mesh->getDataInformation()->GetDataAssembly("Hierarchy");
  const int root = vtkDataAssembly::GetRootNode();
  if (!tree || block < 0 || block >= tree->GetNumberOfChildren(root))
  {
    return false;
  }
  const std::string path = tree->GetNodePath(tree->GetChild(root, block));
  vtkPVDataInformation* data = mesh->getOutputPortProxy()->GetSubsetDataInformation(path.c_str(), "Hierarchy");
  if (!data || data->GetDataSetType() != VTK_STRUCTURED_GRID)
  {
    return false;
  }
  const int* extent = data->GetExtent();
  for (int d = 0; d < 3; ++d)
  {
    size[d] = extent[2 * d + 1] - extent[2 * d];
  }
  return size[0] > 0 && size[1] > 0 && size[2] > 0;
}

} // namespace

//------------------------------------------------------------------------------
PickedFaces pickedFaces(pqOutputPort* mesh)
{
  PickedFaces result;
  std::map<int, std::vector<vtkIdType>> cells;
  if (mesh->getDataInformation()->GetCompositeDataSetType() != VTK_PARTITIONED_DATA_SET_COLLECTION ||
    !selectedCells(mesh, cells))
  {
    result.problem = "Select cells of the mesh in the view: Select Cells On, and drag a rectangle.";
    return result;
  }
  for (const auto& [block, list] : cells)
  {
    std::array<vtkIdType, 3> size;
    if (!blockSize(mesh, block, size))
    {
      result.problem = "Block " + std::to_string(block) + " is no structured grid.";
      continue;
    }
    std::set<int> chosen;
    std::vector<std::vector<int>> unclear;
    for (const vtkIdType cell : list)
    {
      const std::array<vtkIdType, 3> ijk{ cell % size[0], cell / size[0] % size[1], cell / (size[0] * size[1]) };
      std::vector<int> at;
      for (int d = 0; d < 3; ++d)
      {
        for (int side = 0; side < 2; ++side)
        {
          if (ijk[d] == (side == 0 ? 0 : size[d] - 1))
          {
            at.push_back(2 * d + side);
          }
        }
      }
      if (at.size() == 1)
      {
        chosen.insert(at.front());
      }
      else if (!at.empty())
      {
        unclear.push_back(at);
      }
    }
    const bool clear = std::all_of(unclear.begin(), unclear.end(), [&](const std::vector<int>& at) {
      return std::any_of(at.begin(), at.end(), [&](int face) { return chosen.count(face) > 0; });
    });
    if (!clear || chosen.empty())
    {
      result.problem = "Block " + std::to_string(block) +
        ": the cells lie at an edge of the block, where several faces meet. Select cells inside the face as well.";
    }
    for (const int face : chosen)
    {
      result.faces.insert({ block, face });
    }
  }
  return result;
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
#include "vtkControlNetRepresentation.h"

#include "vtkObjectFactory.h"
#include "vtkProperty.h"

vtkStandardNewMacro(vtkControlNetRepresentation);

//------------------------------------------------------------------------------
vtkControlNetRepresentation::vtkControlNetRepresentation()
{
  this->Property->VertexVisibilityOn();
  // Seen on light and on dark backgrounds, and beside ParaView's colours of blocks.
  this->Property->SetVertexColor(0.85, 0.25, 0.05);
}

//------------------------------------------------------------------------------
void vtkControlNetRepresentation::SetPointSize(double size)
{
  this->Superclass::SetPointSize(PointScale * size);
}

//------------------------------------------------------------------------------
void vtkControlNetRepresentation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "PointScale: " << PointScale << '\n';
}

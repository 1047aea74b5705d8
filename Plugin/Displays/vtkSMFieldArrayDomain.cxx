// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSMFieldArrayDomain.h"

#include "vtkDataObject.h"
#include "vtkObjectFactory.h"
#include "vtkPVDataInformation.h"
#include "vtkPVXMLElement.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMUncheckedPropertyHelper.h"

#include <algorithm>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>

vtkStandardNewMacro(vtkSMFieldArrayDomain);

//------------------------------------------------------------------------------
int vtkSMFieldArrayDomain::ReadXMLAttributes(vtkSMProperty* property, vtkPVXMLElement* element)
{
  const std::pair<const char*, std::string*> attributes[] = { { "present", &this->Present },
    { "absent", &this->Absent } };
  for (const auto& [attribute, name] : attributes)
  {
    const char* value = element->GetAttribute(attribute);
    *name = value ? value : "";
  }
  return this->Superclass::ReadXMLAttributes(property, element);
}

//------------------------------------------------------------------------------
int vtkSMFieldArrayDomain::IsInDomain(vtkSMProperty* property)
{
  vtkSMUncheckedPropertyHelper inputs(property, true);
  for (unsigned int n = 0; n < inputs.GetNumberOfElements(); ++n)
  {
    auto* source = vtkSMSourceProxy::SafeDownCast(inputs.GetAsProxy(n));
    if (!source)
    {
      return NOT_IN_DOMAIN;
    }
    source->CreateOutputPorts();
    vtkPVDataInformation* data = source->GetDataInformation(inputs.GetOutputPort(n));
    const auto has = [&](const std::string& name) {
      return data && data->GetArrayInformation(name.c_str(), vtkDataObject::FIELD);
    };
    std::istringstream names(this->Present);
    using Name = std::istream_iterator<std::string>;
    const bool present = this->Present.empty() || std::any_of(Name(names), Name(), has);
    if (!present || (!this->Absent.empty() && has(this->Absent)))
    {
      return NOT_IN_DOMAIN;
    }
  }
  return inputs.GetNumberOfElements() > 0 ? IN_DOMAIN : NOT_IN_DOMAIN;
}

//------------------------------------------------------------------------------
void vtkSMFieldArrayDomain::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Present: " << this->Present << '\n';
  os << indent << "Absent: " << this->Absent << '\n';
}

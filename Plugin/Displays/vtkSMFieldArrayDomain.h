// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkSMFieldArrayDomain
 * @brief   input properties that take only data with some field data array, and without another
 *
 * `<FieldArrayDomain name="nurbs" present="KnotsV" absent="KnotsW"/>`: NURBS surfaces, but no volumes. Of several
 * arrays, with blanks between their names, one must be present. Only what is
 * known of the data without fetching it is looked at, so that drop-downs of inputs offer the right ones also of a
 * remote server. Sources that were not yet executed are not in the domain.
 */
#ifndef vtkSMFieldArrayDomain_h
#define vtkSMFieldArrayDomain_h

#include "BSplineVolumeDisplaysModule.h" // For export macro
#include "vtkSMDomain.h"

#include <string> // For the names

class BSPLINEVOLUMEDISPLAYS_EXPORT vtkSMFieldArrayDomain : public vtkSMDomain
{
public:
  static vtkSMFieldArrayDomain* New();
  vtkTypeMacro(vtkSMFieldArrayDomain, vtkSMDomain);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  int IsInDomain(vtkSMProperty* property) override;

protected:
  vtkSMFieldArrayDomain() = default;
  ~vtkSMFieldArrayDomain() override = default;

  int ReadXMLAttributes(vtkSMProperty* property, vtkPVXMLElement* element) override;

private:
  vtkSMFieldArrayDomain(const vtkSMFieldArrayDomain&) = delete;
  void operator=(const vtkSMFieldArrayDomain&) = delete;

  std::string Present;
  std::string Absent;
};

#endif

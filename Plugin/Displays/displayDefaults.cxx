// SPDX-License-Identifier: BSD-3-Clause
#include "displayDefaults.h"

#include "vtkProcessModule.h"
#include "vtkResourceFileLocator.h"
#include "vtkSMSettings.h"

#include <vtksys/SystemTools.hxx>

#include <string>

// The locator looks symbols up by their plain names.
extern "C" BSPLINEVOLUMEDISPLAYS_EXPORT void bsvDisplaysLibrary() {}

namespace bsv
{

void loadDisplayDefaults()
{
  const auto process = vtkProcessModule::GetProcessType();
  if (process != vtkProcessModule::PROCESS_CLIENT && process != vtkProcessModule::PROCESS_BATCH)
  {
    return;
  }
  const std::string folder = vtksys::SystemTools::GetFilenamePath(vtkGetLibraryPathForSymbol(bsvDisplaysLibrary));
  const std::string settings = folder + "/BSplineVolumeSettings.json";
  if (vtksys::SystemTools::FileExists(settings))
  {
    // Those of the site have priority 1, those of the user 2.
    vtkSMSettings::GetInstance()->AddCollectionFromFile(settings, 0.5);
  }
}

} // namespace bsv

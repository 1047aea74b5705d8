// SPDX-License-Identifier: BSD-3-Clause
#include "displayDefaults.h"

#include "vtkNew.h"
#include "vtkPVPluginLoader.h"
#include "vtkProcessModule.h"
#include "vtkResourceFileLocator.h"
#include "vtkSMSettings.h"

#include <vtksys/SystemTools.hxx>

#include <string>

#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif

extern "C" BSPLINEVOLUMEDISPLAYS_EXPORT void bsvDisplaysLibrary() {}

namespace bsv
{

namespace
{

std::string libraryFolder()
{
#ifdef _WIN32
  return vtksys::SystemTools::GetFilenamePath(vtkGetLibraryPathForSymbol(bsvDisplaysLibrary));
#else
  // By its address: names are found only in libraries that were opened for all.
  Dl_info here;
  return dladdr(reinterpret_cast<const void*>(&bsvDisplaysLibrary), &here)
    ? vtksys::SystemTools::GetFilenamePath(vtksys::SystemTools::CollapseFullPath(here.dli_fname))
    : std::string();
#endif
}

/// Whether this process has ParaView's Qt application, which none of our libraries here links.
bool hasQtApplication()
{
#ifdef _WIN32
  return GetModuleHandleA("pqCore.dll") != nullptr;
#else
  // pqApplicationCore::instance()
  void* instance = dlsym(RTLD_DEFAULT, "_ZN17pqApplicationCore8instanceEv");
  using Instance = void* (*)();
  return instance && reinterpret_cast<Instance>(instance)() != nullptr;
#endif
}

} // namespace

void loadDisplayDefaults()
{
  const auto process = vtkProcessModule::GetProcessType();
  if (process != vtkProcessModule::PROCESS_CLIENT && process != vtkProcessModule::PROCESS_BATCH)
  {
    return;
  }
  const std::string settings = libraryFolder() + "/BSplineVolumeSettings.json";
  if (vtksys::SystemTools::FileExists(settings))
  {
    // Those of the site have priority 1, those of the user 2.
    vtkSMSettings::GetInstance()->AddCollectionFromFile(settings, 0.5);
  }
}

void loadQtPart()
{
  if (vtkProcessModule::GetProcessType() != vtkProcessModule::PROCESS_CLIENT || !hasQtApplication())
  {
    return;
  }
#ifdef _WIN32
  const char* extension = ".dll";
#else
  const char* extension = ".so";
#endif
  const std::string library = libraryFolder() + "/BSplineVolumeQt/BSplineVolumeQt" + extension;
  if (vtksys::SystemTools::FileExists(library))
  {
    vtkNew<vtkPVPluginLoader> loader;
    loader->LoadPlugin(library.c_str());
  }
}

} // namespace bsv

// SPDX-License-Identifier: BSD-3-Clause
#include "displayDefaults.h"

#include "vtkCallbackCommand.h"
#include "vtkNew.h"
#include "vtkPVPluginLoader.h"
#include "vtkPVXMLElement.h"
#include "vtkProcessModule.h"
#include "vtkResourceFileLocator.h"
#include "vtkSMProxy.h"
#include "vtkSMProxyManager.h"
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

bool isClient()
{
  const auto process = vtkProcessModule::GetProcessType();
  return process == vtkProcessModule::PROCESS_CLIENT || process == vtkProcessModule::PROCESS_BATCH;
}

void updateInformation(vtkObject* proxy, unsigned long, void*, void*)
{
  static_cast<vtkSMProxy*>(proxy)->UpdatePropertyInformation();
}

/// A proxy was registered, or got another name.
void observeUpdates(vtkObject*, unsigned long, void*, void* registered)
{
  const auto* information = static_cast<vtkSMProxyManager::RegisteredProxyInformation*>(registered);
  vtkSMProxy* proxy = information ? information->Proxy : nullptr;
  vtkPVXMLElement* hints = proxy ? proxy->GetHints() : nullptr;
  static vtkNew<vtkCallbackCommand> command;
  if (!hints || !hints->FindNestedElementByName("InformationAfterUpdate") ||
    proxy->HasObserver(vtkCommand::UpdateDataEvent, command))
  {
    return;
  }
  command->SetCallback(updateInformation);
  proxy->AddObserver(vtkCommand::UpdateDataEvent, command);
}

} // namespace

void keepInformationUpToDate()
{
  if (isClient())
  {
    vtkNew<vtkCallbackCommand> command;
    command->SetCallback(observeUpdates);
    vtkSMProxyManager::GetProxyManager()->AddObserver(vtkCommand::RegisterEvent, command);
  }
}

void loadDisplayDefaults()
{
  if (!isClient())
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

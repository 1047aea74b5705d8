// SPDX-License-Identifier: BSD-3-Clause
// The library that users load, BSplineVolume.so. It links nothing of ParaView, so that every ParaView can open it. The
// plugin itself lies beside it as BSV_PLUGIN_FILE and is loaded by the ParaView that it was built for; others get one
// sentence instead of the name of a missing library, or of two VTKs in one process.
#include <dlfcn.h>
#include <link.h>

#include <cstdio>
#include <cstring>
#include <string>

#define BSV_EXPORT extern "C" __attribute__((visibility("default")))

namespace
{

/// Version of the ParaView that runs here, "5.11", by the name of its library of VTK; nothing if it has no such
/// library.
std::string runningParaView()
{
  std::string version;
  dl_iterate_phdr(
    [](dl_phdr_info* object, std::size_t, void* found) {
      static const char* const library = "/libvtkCommonCore-pv";
      const char* name = std::strstr(object->dlpi_name, library);
      if (name)
      {
        name += std::strlen(library);
        static_cast<std::string*>(found)->assign(name, std::strcspn(name, "s") - 1); // 5.11.so.1
      }
      return name ? 1 : 0;
    },
    &version);
  return version;
}

/// The plugin itself, or nullptr after the reason was printed.
void* plugin()
{
  static void* const handle = [] {
    const std::string running = runningParaView();
    std::string reason;
    if (running.empty() || running == BSV_PARAVIEW_SERIES)
    {
      Dl_info here;
      dladdr(reinterpret_cast<const void*>(&plugin), &here);
      const std::string path = here.dli_fname;
      void* const library = dlopen((path.substr(0, path.rfind('/') + 1) + BSV_PLUGIN_FILE).c_str(), RTLD_LAZY);
      if (library)
      {
        return library;
      }
      reason = std::string("which cannot load it here: ") + dlerror();
    }
    else
    {
      reason = "not for ParaView " + running;
    }
    std::fprintf(
      stderr, "BSplineVolume " BSV_VERSION " was built for ParaView " BSV_PARAVIEW_VERSION ", %s.\n", reason.c_str());
    return static_cast<void*>(nullptr);
  }();
  return handle;
}

/// A function of the plugin itself, or nullptr.
template <typename Function>
Function pluginFunction(const char* name)
{
  return plugin() ? reinterpret_cast<Function>(dlsym(plugin(), name)) : nullptr;
}

} // namespace

/// ParaViews that ask for this text compare it with their own.
BSV_EXPORT const char* pv_plugin_query_verification_data()
{
  const auto query = pluginFunction<const char* (*)()>("pv_plugin_query_verification_data");
  return query ? query() : "BSplineVolume " BSV_VERSION " was built for ParaView " BSV_PARAVIEW_VERSION;
}

/// The vtkPVPlugin, or nullptr, which ParaView reports as a plugin that cannot be loaded.
BSV_EXPORT void* pv_plugin_instance()
{
  const auto instance = pluginFunction<void* (*)()>("pv_plugin_instance");
  return instance ? instance() : nullptr;
}

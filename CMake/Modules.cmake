# SPDX-License-Identifier: BSD-3-Clause
# The VTK modules, their Python package and the ParaView plugin.
# Modules, each built on those before it.
set(bsv_wrapped_modules
  BSplineVolume::BSplineVolumeFilters
  BSplineVolume::BSplineVolumeReaders
  BSplineVolume::BSplineVolumeWriters)
set(bsv_display_modules)
set(bsv_display_files)
if (BSPLINEVOLUME_BUILD_PARAVIEW_PLUGIN)
  set(bsv_display_modules BSplineVolume::BSplineVolumeDisplays)
  set(bsv_display_files "${PROJECT_SOURCE_DIR}/Plugin/Displays/vtk.module")
endif ()

# bsv_add_library_process(<name> <module>): the program <name>.cxx of a module, which runs third-party libraries in a
# process of their own. Beside the module's library, which looks for it there.
function (bsv_add_library_process name module)
  add_executable("${name}" "${name}.cxx")
  target_include_directories("${name}" PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}" "${CMAKE_CURRENT_BINARY_DIR}")
  target_link_libraries("${name}" PRIVATE "BSplineVolume::${module}" BSplineVolumeBuildFlags)
  set_target_properties("${name}" PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${CMAKE_LIBRARY_OUTPUT_DIRECTORY}")
  install(TARGETS "${name}" RUNTIME DESTINATION "${bsv_plugin_dir}")
endfunction ()

vtk_module_scan(
  MODULE_FILES
    "${PROJECT_SOURCE_DIR}/Filters/Core/vtk.module"
    "${PROJECT_SOURCE_DIR}/Filters/vtk.module"
    "${PROJECT_SOURCE_DIR}/Readers/vtk.module"
    "${PROJECT_SOURCE_DIR}/Writers/vtk.module"
    ${bsv_display_files}
  REQUEST_MODULES ${bsv_wrapped_modules} ${bsv_display_modules}
  PROVIDES_MODULES bsv_modules
  REQUIRES_MODULES bsv_required_modules
  HIDE_MODULES_FROM_CACHE ON)
vtk_module_build(
  MODULES ${bsv_modules}
  UTILITY_TARGET BSplineVolumeBuildFlags
  PACKAGE BSplineVolume
  INSTALL_EXPORT BSplineVolume
  HEADERS_COMPONENT Development
  HEADERS_DESTINATION "${bsv_header_dir}"
  TEST_DIRECTORY_NAME NONE
  LIBRARY_DESTINATION "${bsv_plugin_dir}"
  ARCHIVE_DESTINATION "${bsv_plugin_dir}"
  CMAKE_DESTINATION "${bsv_package_dir}"
  HIERARCHY_DESTINATION "${CMAKE_INSTALL_LIBDIR}/vtk/hierarchy/BSplineVolume")

if (BSPLINEVOLUME_WRAP_PYTHON)
  vtk_module_wrap_python(
    MODULES ${bsv_wrapped_modules}
    TARGET BSplineVolume::BSplineVolumePython
    PYTHON_PACKAGE bsplinevolume
    INSTALL_HEADERS OFF
    MODULE_DESTINATION "${bsv_plugin_dir}"
    LIBRARY_DESTINATION "${bsv_plugin_dir}")
  set(init "# SPDX-License-Identifier: BSD-3-Clause\n")
  string(APPEND init "\"\"\"B-spline volumes from block-structured hexahedral meshes.\"\"\"\n")
  set(built_for "VTK ${VTK_VERSION}")
  if (BSPLINEVOLUME_BUILD_PARAVIEW_PLUGIN)
    set(built_for "ParaView ${ParaView_VERSION}")
  endif ()
  string(APPEND init "try:\n")
  foreach (module IN LISTS bsv_wrapped_modules)
    string(REPLACE "BSplineVolume::" "" name "${module}")
    string(APPEND init "    from .${name} import *\n")
  endforeach ()
  string(APPEND init
    "except ImportError as error:\n"
    "    raise ImportError(f\"bsplinevolume ${PROJECT_VERSION} was built for the Python of ${built_for}: {error}\") from None\n")
  string(APPEND init
    "from .pipeline import Error\n"
    "from .volume import Block, Volume, convert, read\n\n"
    "__version__ = \"${PROJECT_VERSION}\"\n")
  file(GENERATE OUTPUT "${CMAKE_BINARY_DIR}/${bsv_plugin_dir}/bsplinevolume/__init__.py" CONTENT "${init}")
  set(bsv_python_files __main__.py display.py pipeline.py report.py volume.py)
  foreach (file IN LISTS bsv_python_files)
    configure_file("${PROJECT_SOURCE_DIR}/Filters/Python/${file}"
      "${CMAKE_BINARY_DIR}/${bsv_plugin_dir}/bsplinevolume/${file}" COPYONLY)
    install(FILES "${PROJECT_SOURCE_DIR}/Filters/Python/${file}" DESTINATION "${bsv_plugin_dir}/bsplinevolume")
  endforeach ()
  install(FILES "${CMAKE_BINARY_DIR}/${bsv_plugin_dir}/bsplinevolume/__init__.py"
    DESTINATION "${bsv_plugin_dir}/bsplinevolume")
  # The command lies where programs are, the package where the plugin is.
  file(RELATIVE_PATH bsv_package_of_command "/${CMAKE_INSTALL_BINDIR}" "/${bsv_plugin_dir}")
  configure_file("${CMAKE_CURRENT_LIST_DIR}/bsplinevolume.in" "${CMAKE_BINARY_DIR}/${CMAKE_INSTALL_BINDIR}/bsplinevolume" @ONLY)
  install(PROGRAMS "${CMAKE_BINARY_DIR}/${CMAKE_INSTALL_BINDIR}/bsplinevolume" DESTINATION "${CMAKE_INSTALL_BINDIR}")
endif ()

if (BSPLINEVOLUME_BUILD_PARAVIEW_PLUGIN)
  unset(CMAKE_LIBRARY_OUTPUT_DIRECTORY) # paraview_plugin_build() chooses the same folder
  unset(CMAKE_ARCHIVE_OUTPUT_DIRECTORY)
  # The scanned file must not be the one at the top level: the folder that holds it is added as a subdirectory.
  # Plugin/paraview.plugin is a link to it.
  paraview_plugin_scan(
    PLUGIN_FILES "${PROJECT_SOURCE_DIR}/Plugin/paraview.plugin"
    PROVIDES_PLUGINS bsv_plugins
    ENABLE_BY_DEFAULT ON
    HIDE_PLUGINS_FROM_CACHE ON)
  paraview_plugin_build(
    PLUGINS ${bsv_plugins}
    INSTALL_HEADERS OFF
    LIBRARY_DESTINATION "${CMAKE_INSTALL_LIBDIR}")
  # Which the readers and writers look for beside their libraries.
  add_dependencies(BSplineVolume BSplineVolumeReadFile BSplineVolumeWriteFile)
  # The part that needs Qt lies in the folder of the plugin that loads it.
  option(BSPLINEVOLUME_BUILD_QT "Build the part of the plugin for ParaView's window" "${PARAVIEW_USE_QT}")
  if (BSPLINEVOLUME_BUILD_QT)
    paraview_plugin_scan(
      PLUGIN_FILES "${PROJECT_SOURCE_DIR}/Plugin/Qt/paraview.plugin"
      PROVIDES_PLUGINS bsv_qt_plugins
      ENABLE_BY_DEFAULT ON
      HIDE_PLUGINS_FROM_CACHE ON)
    paraview_plugin_build(
      PLUGINS ${bsv_qt_plugins}
      INSTALL_HEADERS OFF
      LIBRARY_SUBDIRECTORY BSplineVolume
      LIBRARY_DESTINATION "${CMAKE_INSTALL_LIBDIR}")
  endif ()
endif ()

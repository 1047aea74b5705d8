# SPDX-License-Identifier: BSD-3-Clause
# find_package(BSplineVolume) for other projects, and packages by cpack.
include(CMakePackageConfigHelpers)
configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/BSplineVolumeConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/CMakeFiles/BSplineVolumeConfig.cmake"
  INSTALL_DESTINATION "${bsv_package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/CMakeFiles/BSplineVolumeConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)
install(
  FILES
    "${PROJECT_BINARY_DIR}/CMakeFiles/BSplineVolumeConfig.cmake"
    "${PROJECT_BINARY_DIR}/CMakeFiles/BSplineVolumeConfigVersion.cmake"
  DESTINATION "${bsv_package_dir}"
  COMPONENT Development)

set(CPACK_GENERATOR TGZ DEB)
set(CPACK_PACKAGE_VENDOR "BSplineVolume")
set(CPACK_PACKAGE_CONTACT "BSplineVolume developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Block-structured hexahedral meshes to B-spline volumes in ParaView and VTK")
set(CPACK_RESOURCE_FILE_LICENSE "${PROJECT_SOURCE_DIR}/LICENSE")
set(CPACK_RESOURCE_FILE_README "${PROJECT_SOURCE_DIR}/README.md")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PACKAGE_NAME "bsplinevolume")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION "science")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${PROJECT_BINARY_DIR}/${bsv_plugin_dir}")
if (BSPLINEVOLUME_BUILD_PARAVIEW_PLUGIN)
  set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-paraview")
endif ()
set(CPACK_PACKAGING_INSTALL_PREFIX "/usr")
include(CPack)

# Installs the program, the library, its headers and a CMake package: find_package(lumisweep CONFIG), lumisweep::lumisweep.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS lumisweep EXPORT lumisweepTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
if(LUMISWEEP_CLI)
  install(TARGETS lumisweep_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/lumisweep DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/lumisweep)
install(EXPORT lumisweepTargets NAMESPACE lumisweep:: DESTINATION ${package_dir})
if(NOT BUILD_SHARED_LIBS)
  set(BUILD_SHARED_LIBS OFF)
endif()
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/lumisweepConfig.cmake.in
  ${PROJECT_BINARY_DIR}/lumisweepConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/lumisweepConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/lumisweepConfig.cmake ${PROJECT_BINARY_DIR}/lumisweepConfigVersion.cmake
  DESTINATION ${package_dir})

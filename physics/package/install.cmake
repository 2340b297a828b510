# `cmake --install`, find_package(skerry), pkg-config and CPack.
#
#   find_package(skerry)                              # skerry::physics, and skerry::render where it was built
#   target_link_libraries(app PRIVATE skerry::physics)
include(CMakePackageConfigHelpers)
set(SKERRY_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/skerry)
set(SKERRY_INCLUDE_DIR ${CMAKE_INSTALL_INCLUDEDIR}/skerry)

# The .pc files find the tree from where they lie, wherever `cmake --install --prefix` puts it.
file(RELATIVE_PATH SKERRY_PREFIX_FROM_PC /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)

# Limit loads bring their linear programming library along.
set(SKERRY_WITH_CLP FALSE)
set(SKERRY_PC_LP "")
if(SKERRY_CLP AND CLP_FOUND)
  set(SKERRY_WITH_CLP TRUE)
  set(SKERRY_PC_LP clp)
endif()

# skerry_install_library(NAME): the library, its headers below include/skerry/NAME, its targets file, its .pc file.
function(skerry_install_library name)
  set_target_properties(skerry_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_include_directories(skerry_${name} INTERFACE $<INSTALL_INTERFACE:${SKERRY_INCLUDE_DIR}>)
  install(TARGETS skerry_${name} EXPORT skerry_${name} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
  install(EXPORT skerry_${name} NAMESPACE skerry:: FILE skerry-${name}-targets.cmake
          DESTINATION ${SKERRY_CMAKE_DIR} COMPONENT dev)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${name} DESTINATION ${SKERRY_INCLUDE_DIR} COMPONENT dev
          FILES_MATCHING PATTERN "*.h" PATTERN package EXCLUDE)
  configure_file(${PROJECT_SOURCE_DIR}/physics/package/skerry-${name}.pc.in
                 ${PROJECT_BINARY_DIR}/package/skerry-${name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/package/skerry-${name}.pc
          DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)
endfunction()

# delassus.h shows Eigen's sparse matrices; in the tree Eigen is a system include of the target.
target_link_libraries(skerry_physics INTERFACE $<INSTALL_INTERFACE:Eigen3::Eigen>)
skerry_install_library(physics)
if(SKERRY_RENDER)
  # What users of render/ui_host.h compile against comes from the system, as here.
  target_compile_features(skerry_render PUBLIC cxx_std_20)
  skerry_install_library(render)
  install(TARGETS skerry RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/demos DESTINATION ${CMAKE_INSTALL_DATADIR}/skerry COMPONENT program
          FILES_MATCHING PATTERN "*.lua" PATTERN "README.md")
endif()

configure_package_config_file(${PROJECT_SOURCE_DIR}/physics/package/skerry-config.cmake.in
  ${PROJECT_BINARY_DIR}/package/skerry-config.cmake INSTALL_DESTINATION ${SKERRY_CMAKE_DIR}
  NO_SET_AND_CHECK_MACRO)
# Before 1.0 a minor version may break what was built for the last one.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/skerry-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/package/skerry-config.cmake
  ${PROJECT_BINARY_DIR}/package/skerry-config-version.cmake DESTINATION ${SKERRY_CMAKE_DIR} COMPONENT dev)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT dev)

# `cpack -G DEB` in the build folder: one package with the program, the demos and the libraries; it brings what
# building against skerry::physics needs.
set(CPACK_PACKAGE_NAME skerry)
set(CPACK_PACKAGE_CONTACT "the Skerry authors <skerry@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_GENERATOR "DEB;TGZ")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "libeigen3-dev (>= 3.4)")
if(SKERRY_WITH_CLP)
  # clp.pc names libz.so, whose package that of Clp does not bring along.
  string(APPEND CPACK_DEBIAN_PACKAGE_DEPENDS ", coinor-libclp-dev, zlib1g-dev")
endif()
if(SKERRY_RENDER)
  # skerry::render is for fewer, and needs more.
  set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libepoxy-dev, libimgui-dev, libstb-dev, libdeflate-dev, libglfw3-dev, \
libavcodec-dev, libavformat-dev, libavutil-dev")
endif()
include(CPack)

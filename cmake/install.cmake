# What is installed where: the components runtime, development and debug, the package files of CMake
# and pkg-config.

install(FILES include/catamaran.h include/catamaran.hpp include/catamaran.f90
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
install(DIRECTORY include/catamaran
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development FILES_MATCHING PATTERN "*.hpp")
if(CATAMARAN_MPI)
  install(FILES include/catamaran_mpi.h
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
endif()
install(TARGETS catamaran_shared
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT development)
install(FILES "${installed_static}" DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
install(FILES $<TARGET_FILE:catamaran_shared>.debug
  DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT debug EXCLUDE_FROM_ALL)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/catamaran)
configure_package_config_file(cmake/catamaranConfig.cmake.in catamaranConfig.cmake
  INSTALL_DESTINATION ${package_dir} PATH_VARS CMAKE_INSTALL_INCLUDEDIR CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(catamaranConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/catamaranConfig.cmake"
  "${CMAKE_CURRENT_BINARY_DIR}/catamaranConfigVersion.cmake"
  DESTINATION ${package_dir} COMPONENT development)

# The prefix is found from the .pc file's own place, so that `cmake --install --prefix` is right.
file(RELATIVE_PATH pc_prefix "/prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/prefix")
string(REGEX REPLACE "/$" "" pc_prefix "${pc_prefix}")
set(pc_private_libs ${private_dirs})
list(TRANSFORM pc_private_libs PREPEND "-L")
list(TRANSFORM private_libs PREPEND "-l" OUTPUT_VARIABLE pc_private_names)
list(APPEND pc_private_libs ${pc_private_names})
list(JOIN pc_private_libs " " pc_private_libs)
configure_file(cmake/catamaran.pc.in catamaran.pc @ONLY)
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/catamaran.pc"
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

if(CATAMARAN_BLAS)
  install(PROGRAMS "${blas}" DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime)
  install(FILES "${blas}.debug"
    DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT debug EXCLUDE_FROM_ALL)
  configure_file(cmake/catamaran-blas.pc.in catamaran-blas.pc @ONLY)
  install(FILES "${CMAKE_CURRENT_BINARY_DIR}/catamaran-blas.pc"
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
endif()

# The licenses, those of the packages that are linked in too.
install(FILES LICENSE-APACHE LICENSE-MIT NOTICE
  DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)

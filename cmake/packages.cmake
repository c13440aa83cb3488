# Debian packages, by `cpack` in the build directory: the library, and what programs are compiled
# with. Configure with the preset deb, so that files go where Debian has them. scripts/test-deb
# checks the packages by lintian.

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME libcatamaran)
set(CPACK_PACKAGE_VENDOR Catamaran)
# The project has no address. Distributors set their own.
set(CPACK_PACKAGE_CONTACT "The Catamaran authors <catamaran@example.org>" CACHE STRING
  "maintainer of the packages, as NAME <ADDRESS>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
# The debug information is ten times the rest.
set(CPACK_COMPONENTS_ALL runtime development)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)

# As Debian does it: libraries of several ABIs can be installed at a time, so the name has the ABI;
# there is one of the headers.
set(runtime_package libcatamaran${CATAMARAN_SOVERSION})
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME ${runtime_package})
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
set(about "Catamaran computes products A^T A, covariances, least squares, principal
components, orthogonal bases and eigenpairs of sparse matrices. It also
processes meshes: repair, decimation, distances, spectra, curves.")
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION "A^T A, spectra and geometry at scale: shared library
${about}
.
This package contains the shared library.")
# Depends, from the libraries that are linked; and what packages of programs shall depend on.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA "${CMAKE_CURRENT_SOURCE_DIR}/cmake/debian/triggers")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libcatamaran-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "A^T A, spectra and geometry at scale: development files
${about}
.
This package contains the headers for C and C++, the module of Fortran, the
static library, and the files for CMake and pkg-config.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${runtime_package} (= ${PROJECT_VERSION})")
# A static library has no list of what it needs.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)

# What each package has in its folder of documents, in the formats of Debian.
if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  file(READ LICENSE-MIT mit)
  string(STRIP "${mit}" mit)
  string(REGEX REPLACE "\n\n" "\n.\n" mit "${mit}")
  string(REGEX REPLACE "\n" "\n " mit " ${mit}")
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
  set(documents "${CMAKE_CURRENT_BINARY_DIR}/debian")
  configure_file(cmake/debian/copyright.in "${documents}/copyright" @ONLY)
  configure_file(cmake/debian/changelog.in "${documents}/changelog" @ONLY)
  execute_process(COMMAND gzip -9nc "${documents}/changelog"
    OUTPUT_FILE "${documents}/changelog.gz" RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "gzip -9nc ${documents}/changelog: ${status}")
  endif()
  install(FILES "${documents}/copyright" "${documents}/changelog.gz"
    DESTINATION share/doc/${runtime_package} COMPONENT runtime)
  install(FILES "${documents}/copyright" "${documents}/changelog.gz"
    DESTINATION share/doc/libcatamaran-dev COMPONENT development)
endif()
include(CPack)

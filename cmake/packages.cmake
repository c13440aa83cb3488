# Debian packages, by `cpack` in the build directory: the library, and what programs are compiled
# with. Configure with the preset deb, so that files go where Debian has them (scripts/test-deb).

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME libcatamaran)
set(CPACK_PACKAGE_VENDOR Catamaran)
set(CPACK_PACKAGE_CONTACT "the authors of Catamaran <catamaran@localhost>")
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
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "A^T A, spectra and geometry at scale: shared library")
# Depends, from the libraries that are linked; and what packages of programs shall depend on.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libcatamaran-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
  "A^T A, spectra and geometry at scale: headers, static library, files of CMake and pkg-config")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${runtime_package} (= ${PROJECT_VERSION})")
# A static library has no list of what it needs.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)
include(CPack)

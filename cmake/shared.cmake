# catamaran::catamaran, the shared library, linked from the static one by the C compiler.
#
# Not as a cdylib of rustc: that comes with a version script of its own, which has no version, and
# GNU ld refuses a second one, while lld takes it and leaves the symbols without a version.

set(node CATAMARAN_${CATAMARAN_SOVERSION})
set(version_script "${CMAKE_CURRENT_BINARY_DIR}/catamaran.map")
set(no_source "${CMAKE_CURRENT_BINARY_DIR}/shared.c")
# Written when they differ only, or everything would be linked again after every configuration.
# tests/c/symbols.sh compares what the pattern exports to the functions of the header.
file(GENERATE OUTPUT "${version_script}" CONTENT "${node} {\n  global: cata_*;\n  local: *;\n};\n")
file(GENERATE OUTPUT "${no_source}"
  CONTENT "/* All comes from libcatamaran.a; CMake wants a source. */\ntypedef int catamaran_none;\n")

add_library(catamaran_shared SHARED "${no_source}")
add_library(catamaran::catamaran ALIAS catamaran_shared)
add_dependencies(catamaran_shared catamaran_cargo)
set_target_properties(catamaran_shared PROPERTIES
  OUTPUT_NAME catamaran
  VERSION ${PROJECT_VERSION}
  SOVERSION ${CATAMARAN_SOVERSION}
  LIBRARY_OUTPUT_DIRECTORY "${lib_dir}"
  LINK_DEPENDS "${static};${version_script}")
target_include_directories(catamaran_shared INTERFACE "${CMAKE_CURRENT_SOURCE_DIR}/include")
target_link_libraries(catamaran_shared PRIVATE
  -Wl,--whole-archive "${static}" -Wl,--no-whole-archive ${link_libs})
# What no exported function reaches is left out (gc-sections), which is most of the whole archive.
target_link_options(catamaran_shared PRIVATE
  "LINKER:--version-script=${version_script}" LINKER:--gc-sections LINKER:--as-needed
  LINKER:-z,defs LINKER:-z,relro,-z,now)

# Debuggers and backtraces find the debug information beside the library, through the link in it.
add_custom_command(TARGET catamaran_shared POST_BUILD
  COMMAND ${CMAKE_OBJCOPY} --only-keep-debug
    $<TARGET_FILE:catamaran_shared> $<TARGET_FILE:catamaran_shared>.debug
  COMMAND ${CMAKE_OBJCOPY} --strip-unneeded
    --add-gnu-debuglink=$<TARGET_FILE:catamaran_shared>.debug $<TARGET_FILE:catamaran_shared>
  VERBATIM)

# What is installed of the static library: two thirds of it are debug information.
set(installed_static "${CMAKE_CURRENT_BINARY_DIR}/installed/libcatamaran.a")
add_custom_command(TARGET catamaran_shared POST_BUILD
  COMMAND ${CMAKE_COMMAND} -E make_directory "${CMAKE_CURRENT_BINARY_DIR}/installed"
  COMMAND ${CMAKE_OBJCOPY} --strip-debug "${static}" "${installed_static}"
  VERBATIM)

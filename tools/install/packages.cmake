# cpack -G DEB, in a tree that was configured with -DCMAKE_INSTALL_PREFIX=/usr on Debian (docs/packages.md;
# tools/install/deb does all of it): a package for each component.
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL library development python)
if(PLANISH_PROGRAM)
  list(APPEND CPACK_COMPONENTS_ALL program)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_NAME planish)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE
  GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(PLANISH_MAINTAINER "planish authors <planish@packages.invalid>" CACHE STRING
  "Who answers for packages: Name <address>")
set(CPACK_PACKAGE_CONTACT ${PLANISH_MAINTAINER})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SOURCE planish)
set(FULL_VERSION ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
set(ABOUT "planish moves the nodes of meshes of triangles, tetrahedra and elements
of other types. Inverted elements become valid where that is possible, and
no element gets worse than the worst was. Connectivity and all else in a
file stay as they are. The result has the same bits for any number of
threads.
")

# planish_package COMPONENT NAME SECTION SUMMARY WHAT: what all packages have.
macro(planish_package COMPONENT NAME SECTION SUMMARY WHAT)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME ${NAME})
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_SECTION ${SECTION})
  set(CPACK_DEBIAN_${COMPONENT}_DESCRIPTION "${SUMMARY}\n${ABOUT}\n${WHAT}")
endmacro()

planish_package(PROGRAM planish math "smooth and untangle meshes in files"
  "This package has the program, which reads and writes the formats of many\nmesh generators.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)

planish_package(LIBRARY libplanish${PLANISH_ABI} libs "smooth and untangle meshes: shared libraries"
  "This package has the library for arrays of the caller, and the one for\nfiles of meshes.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_SOURCE_DIR}/debian/triggers)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})

planish_package(DEVELOPMENT libplanish-dev libdevel "smooth and untangle meshes: development files"
  "This package has headers, static libraries, and what CMake and pkg-config\nneed.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libplanish${PLANISH_ABI} (= ${FULL_VERSION})")
# Static libraries alone need these.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS
  "libhwloc-dev, libexpat1-dev, zlib1g-dev, liblz4-dev, liblzma-dev, libhdf5-dev")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS pkg-config)

planish_package(PYTHON python3-planish python "smooth and untangle meshes: Python module"
  "This package has the module, for arrays of numpy and meshes of meshio and\npyvista.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "libplanish${PLANISH_ABI} (>= ${PROJECT_VERSION}), python3, python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS python3-meshio)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
  ${CMAKE_CURRENT_SOURCE_DIR}/debian/postinst ${CMAKE_CURRENT_SOURCE_DIR}/debian/prerm)

# The time of the source: all files of packages have it, so that their bytes say nothing of the build.
set(SOURCE_TIME $ENV{SOURCE_DATE_EPOCH})
if(IS_DEBIAN AND NOT SOURCE_TIME)
  execute_process(COMMAND git log -1 --format=%ct WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    OUTPUT_VARIABLE SOURCE_TIME ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
endif()
if(NOT SOURCE_TIME) # the archive of a release has it
  file(TIMESTAMP ${PROJECT_SOURCE_DIR}/CHANGELOG.md SOURCE_TIME %s UTC)
endif()
configure_file(debian/cpack.cmake.in cpack.cmake @ONLY)
set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_CURRENT_BINARY_DIR}/cpack.cmake)
set(CPACK_PLANISH_SOURCE ${PROJECT_SOURCE_DIR})
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_SOURCE_DIR}/debian/finish.cmake)
set(CPACK_POST_BUILD_SCRIPTS ${CMAKE_CURRENT_SOURCE_DIR}/debian/repack.cmake)

# The linker looks there anyway, and the folder of the build is to leave no trace.
if(IS_DEBIAN)
  foreach(library planish_shared planish_io_shared)
    if(TARGET ${library})
      set_target_properties(${library} PROPERTIES INSTALL_RPATH "" BUILD_WITH_INSTALL_RPATH ON)
    endif()
  endforeach()
endif()
include(CPack)

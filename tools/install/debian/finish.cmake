# Run by cpack on the folders of packages before it packs them: what Debian wants in each of them.
if(NOT CPACK_GENERATOR STREQUAL "DEB")
  return()
endif()

# compress FILE: to FILE.gz, without name and time in it.
function(compress FILE)
  execute_process(COMMAND gzip -9nf ${FILE} RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "gzip failed for ${FILE}")
  endif()
endfunction()

# add_documents COMPONENT: licence and changes. The packages have the changes of Debian, which are the
# packages, and those of the project.
function(add_documents COMPONENT)
  string(TOUPPER ${COMPONENT} upper)
  set(name ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(folder ${CPACK_TEMPORARY_DIRECTORY}/${COMPONENT}/usr/share/doc/${name})
  file(MAKE_DIRECTORY ${folder})
  configure_file(${CMAKE_CURRENT_LIST_DIR}/copyright ${folder}/copyright COPYONLY)
  configure_file(${CPACK_PLANISH_SOURCE}/CHANGELOG.md ${folder}/changelog COPYONLY)
  string(TIMESTAMP PLANISH_DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/changelog.in ${folder}/changelog.Debian @ONLY)
  file(CHMOD ${folder}/copyright ${folder}/changelog ${folder}/changelog.Debian
    PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
  compress(${folder}/changelog)
  compress(${folder}/changelog.Debian)
endfunction()

foreach(component ${CPACK_COMPONENTS_ALL})
  add_documents(${component})
endforeach()
# They are in copyright and changelog.gz.
file(REMOVE ${CPACK_TEMPORARY_DIRECTORY}/program/usr/share/doc/planish/LICENSE
  ${CPACK_TEMPORARY_DIRECTORY}/program/usr/share/doc/planish/CHANGELOG.md)
file(GLOB_RECURSE pages ${CPACK_TEMPORARY_DIRECTORY}/*/usr/share/man/*.[1-9])
foreach(page ${pages})
  compress(${page})
endforeach()

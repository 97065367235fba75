# Copies the shared libraries of the installed program beside it, into lib/surveymc: all but those of glibc, which every system
# has and which must fit its kernel and loader. Run by cpack in the folder that becomes the tarball.
set(prefix ${CPACK_TEMPORARY_INSTALL_DIRECTORY})
file(GLOB programs "${prefix}/bin/surveymc")
if(NOT programs)
  message(FATAL_ERROR "bundle_libraries.cmake: no program in ${prefix}/bin")
endif()
file(GET_RUNTIME_DEPENDENCIES EXECUTABLES ${programs} RESOLVED_DEPENDENCIES_VAR libraries UNRESOLVED_DEPENDENCIES_VAR missing
  POST_EXCLUDE_REGEXES "/(ld-linux[^/]*|lib(c|m|dl|rt|pthread|resolv|util|nsl))[.]so")
if(missing)
  message(FATAL_ERROR "bundle_libraries.cmake: not found: ${missing}")
endif()
foreach(library ${libraries})
  file(COPY ${library} DESTINATION "${prefix}/lib/surveymc" FOLLOW_SYMLINK_CHAIN)
endforeach()
# ... and their licences beside those of what is compiled in.
include(${CMAKE_CURRENT_LIST_DIR}/licences.cmake)
copy_licences("${prefix}/share/doc/surveymc/licences" "brought along in lib/surveymc" ${libraries})

# cmake --install build --prefix FOLDER: the program, its man page and completions, the Python package and the scripts, and
# all configs and pages. share/surveymc has the folders configs/ and scripts/ as the source tree has them.
include(GNUInstallDirs)
# Installing and packing need the programs, not the tests: cpack does not build everything first.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)

install(TARGETS surveymc RUNTIME)
if(TARGET surveymc-mpi)
  install(TARGETS surveymc-mpi RUNTIME OPTIONAL)  # all of a build need not be built
endif()

# The manual pages and the completions of bash are made by the program that is installed, when it is: they cannot be of another one.
set(made ${PROJECT_BINARY_DIR}/made_by_program)
install(CODE "
  file(MAKE_DIRECTORY ${made}/man)
  execute_process(COMMAND $<TARGET_FILE:surveymc> man -o ${made}/man COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND $<TARGET_FILE:surveymc> completion bash OUTPUT_FILE ${made}/bash COMMAND_ERROR_IS_FATAL ANY)")
install(DIRECTORY ${made}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${made}/bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME surveymc)

set(share ${CMAKE_INSTALL_DATADIR}/surveymc)
install(DIRECTORY configs DESTINATION ${share})
# Scripts of users; those that build and check the project stay behind.
install(DIRECTORY scripts DESTINATION ${share} USE_SOURCE_PERMISSIONS
  PATTERN __pycache__ EXCLUDE PATTERN build EXCLUDE PATTERN "*.egg-info" EXCLUDE
  REGEX "/scripts/(bootstrap|quickstart|test|build_docs|docs_site|draw_[a-z]+|run_all|sanitize|cross_[a-z]+|check_[a-z]+)[.](sh|py)$" EXCLUDE)
install(FILES LICENSE CITATION.cff README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES cmake/debian/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES third_party/elementary/COPYRIGHT DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME COPYRIGHT.elementary)
# Licences of what is compiled in; a tarball adds those of the libraries that it brings along.
set(contained "")
foreach(header Eigen/Core boost/version.hpp CLI/CLI.hpp Random123/philox.h fmt/format.h toml++/toml.h xxhash.h)
  unset(found)
  find_file(found ${header} PATH_SUFFIXES eigen3 NO_CACHE)
  if(found)
    list(APPEND contained ${found})
  endif()
endforeach()
set(static_libraries ${HDF5_LIBRARIES})
list(FILTER static_libraries INCLUDE REGEX "^/.*/libhdf5.*[.]a$")
list(APPEND contained ${static_libraries})
install(CODE "
  include(\"${PROJECT_SOURCE_DIR}/cmake/licences.cmake\")
  set(folder \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DOCDIR}/licences\")
  file(REMOVE_RECURSE \"\${folder}\")
  file(WRITE \"\${folder}/README.txt\" \"Licences of what surveymc contains; common-licenses has the texts that they cite.\\nIts own is in ../LICENSE, that of third_party/elementary in ../COPYRIGHT.elementary.\\n\\n\")
  copy_licences(\"\${folder}\" \"compiled into the program\" ${contained})")
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN conf.py EXCLUDE PATTERN site.css EXCLUDE PATTERN claims EXCLUDE)

# The package where Debian's Python looks for it (for prefix /usr; others: PYTHONPATH): a link, so that there is one copy of
# each file; relative, so that the whole can be moved. The program finds scripts/surveymc by itself.
set(SURVEYMC_PYTHON_DIR lib/python3/dist-packages CACHE STRING "where Python packages are installed, below the prefix")
file(RELATIVE_PATH target /${SURVEYMC_PYTHON_DIR} /${share}/scripts/surveymc)
install(CODE "
  set(folder \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${SURVEYMC_PYTHON_DIR}\")
  file(MAKE_DIRECTORY \"\${folder}\")
  file(REMOVE \"\${folder}/surveymc\")
  file(CREATE_LINK ${target} \"\${folder}/surveymc\" SYMBOLIC)
  list(APPEND CMAKE_INSTALL_MANIFEST_FILES \"\${CMAKE_INSTALL_PREFIX}/${SURVEYMC_PYTHON_DIR}/surveymc\")")

# cpack: a .deb, whose libraries the system's packages have, and a .tar.gz that brings its libraries along
# (cmake/bundle_libraries.cmake). RPATH, not RUNPATH: the libraries that are brought along find each other by it, too.
# The built program has the path of the installed one: what CMake else puts there, to be replaced, ends with an empty folder
# name, and the loader takes that for the working folder: a file libfmt.so.9 beside somebody's data would be run.
set_target_properties(surveymc PROPERTIES INSTALL_RPATH "\$ORIGIN/../lib/surveymc")
foreach(program surveymc surveymc-mpi)
  if(TARGET ${program})
    set_target_properties(${program} PROPERTIES BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH_USE_LINK_PATH ON)
  endif()
endforeach()
target_link_options(surveymc PRIVATE -Wl,--disable-new-dtags)
set(CPACK_GENERATOR DEB TGZ)
set(CPACK_PACKAGE_NAME surveymc)
set(CPACK_PACKAGE_VENDOR "The surveymc authors")
set(CPACK_PACKAGE_CONTACT "The surveymc authors <surveymc@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Monte-Carlo research workbench for wellbore directional surveying")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/cmake/cpack_project.cmake)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# Matplotlib's fonttools want SciPy or munkres: SciPy would bring Pythran, and that a C++ compiler and 600 MB.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "python3, python3-numpy, python3-munkres, python3-h5py, python3-matplotlib, python3-pandas, python3-xarray, python3-jinja2, python3-xxhash")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libjs-three, python3-lxml, python3-openpyxl")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/debian/prerm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_VERBATIM_VARIABLES ON)
include(CPack)

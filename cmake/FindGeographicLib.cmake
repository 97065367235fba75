# GeographicLib::GeographicLib. Debian's package has a find module without a target, in a folder that CMake does not look
# in; later releases have a config file under two spellings. What all of them have is looked for: a header, a library.
find_path(GeographicLib_INCLUDE_DIR GeographicLib/Config.h)
find_library(GeographicLib_LIBRARY NAMES GeographicLib Geographic)
if(GeographicLib_INCLUDE_DIR)
  file(STRINGS ${GeographicLib_INCLUDE_DIR}/GeographicLib/Config.h version_line REGEX "GEOGRAPHICLIB_VERSION_STRING")
  string(REGEX MATCH "[0-9.]+" GeographicLib_VERSION "${version_line}")
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(GeographicLib REQUIRED_VARS GeographicLib_LIBRARY GeographicLib_INCLUDE_DIR
  VERSION_VAR GeographicLib_VERSION)
mark_as_advanced(GeographicLib_INCLUDE_DIR GeographicLib_LIBRARY)
if(GeographicLib_FOUND AND NOT TARGET GeographicLib::GeographicLib)
  add_library(GeographicLib::GeographicLib UNKNOWN IMPORTED)
  set_target_properties(GeographicLib::GeographicLib PROPERTIES IMPORTED_LOCATION ${GeographicLib_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${GeographicLib_INCLUDE_DIR})
endif()

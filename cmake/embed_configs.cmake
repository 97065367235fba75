# configs/ becomes strings in the program: `surveymc keys` reads them to see every key. Sets SURVEYMC_CONFIGS_CPP, the source
# that has them. Those for users first, whose values are the best examples. Error models are embedded apart.
set(SURVEYMC_CONFIGS "")
foreach(folder new examples *)
  file(GLOB embedded_files CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}
       ${PROJECT_SOURCE_DIR}/configs/${folder}/*.toml ${PROJECT_SOURCE_DIR}/configs/${folder}/*.csv
       ${PROJECT_SOURCE_DIR}/configs/${folder}/models/*.toml)
  list(FILTER embedded_files EXCLUDE REGEX "^configs/(error_models|bench)/")
  foreach(file ${embedded_files})
    if(file IN_LIST embedded)
      continue()
    endif()
    list(APPEND embedded ${file})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${file})
    file(READ ${PROJECT_SOURCE_DIR}/${file} text)
    string(APPEND SURVEYMC_CONFIGS "      {\"${file}\", R\"toml(${text})toml\"},\n")
  endforeach()
endforeach()
set(SURVEYMC_CONFIGS_CPP ${PROJECT_BINARY_DIR}/shipped_configs.cpp)
configure_file(${PROJECT_SOURCE_DIR}/lib/config/shipped_configs.cpp.in ${SURVEYMC_CONFIGS_CPP} @ONLY)

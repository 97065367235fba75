# configs/error_models/*.toml become strings in the program, so that their names work in any folder. Sets
# SURVEYMC_ERROR_MODELS_CPP, the source that has them. A model that changes, comes or goes makes it anew.
file(GLOB error_model_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/configs/error_models/*.toml)
set(SURVEYMC_ERROR_MODELS "")
foreach(file ${error_model_files})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  get_filename_component(name ${file} NAME_WLE)
  file(READ ${file} text)
  string(APPEND SURVEYMC_ERROR_MODELS "      {\"${name}\", R\"toml(${text})toml\"},\n")
endforeach()
set(SURVEYMC_ERROR_MODELS_CPP ${PROJECT_BINARY_DIR}/shipped_error_models.cpp)
configure_file(${PROJECT_SOURCE_DIR}/lib/config/shipped_error_models.cpp.in ${SURVEYMC_ERROR_MODELS_CPP} @ONLY)

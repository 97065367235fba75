# lib/earth/wmm2025.cof becomes a string in the program, so that its fields are known in any folder and after an install.
# Sets SURVEYMC_GEOMAGNETIC_MODELS_CPP, the source that has it. A change of the file makes it anew.
set(wmm2025_file ${PROJECT_SOURCE_DIR}/lib/earth/wmm2025.cof)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${wmm2025_file})
file(READ ${wmm2025_file} SURVEYMC_WMM2025)
set(SURVEYMC_GEOMAGNETIC_MODELS_CPP ${PROJECT_BINARY_DIR}/shipped_geomagnetic_models.cpp)
configure_file(${PROJECT_SOURCE_DIR}/lib/earth/shipped_geomagnetic_models.cpp.in ${SURVEYMC_GEOMAGNETIC_MODELS_CPP} @ONLY)

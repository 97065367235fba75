// surveymc_precompiled has a source so that CMake builds its header.

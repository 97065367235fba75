# cmake --install build --prefix FOLDER: the program, its man page and completions, and what a user copies and edits.
include(GNUInstallDirs)

install(TARGETS surveymc RUNTIME)
if(TARGET surveymc-mpi)
  install(TARGETS surveymc-mpi RUNTIME OPTIONAL)  # all of a build need not be built
endif()
install(FILES docs/man/surveymc.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)

# Completions are made by the program that is installed, when it is: they cannot be of another one.
set(completions ${PROJECT_BINARY_DIR}/completions)
install(CODE "
  file(MAKE_DIRECTORY ${completions})
  foreach(shell bash zsh fish)
    execute_process(COMMAND $<TARGET_FILE:surveymc> completion \${shell} OUTPUT_FILE ${completions}/\${shell}
                    COMMAND_ERROR_IS_FATAL ANY)
  endforeach()")
install(FILES ${completions}/bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME surveymc)
install(FILES ${completions}/zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions RENAME _surveymc)
install(FILES ${completions}/fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d RENAME surveymc.fish)

set(share ${CMAKE_INSTALL_DATADIR}/surveymc)
install(DIRECTORY configs/error_models configs/examples DESTINATION ${share})
install(FILES LICENSE CITATION.cff CHANGELOG.md README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

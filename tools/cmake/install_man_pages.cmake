# Runs when the build is installed: manual pages are made of the help texts of the programs.
#   maker, programs, scratch    tools/cmake/man_pages, what it asks, and a folder to write to
#   CMAKE_INSTALL_MANDIR        below the prefix
find_program(HELP2MAN help2man)
if(NOT HELP2MAN)
  message(STATUS "No manual pages: help2man is missing (apt-get install help2man)")
  return()
endif()
# Again only when a program has changed: this is most of the time that an installation takes.
set(stamp ${scratch}/man1.made)
foreach(program ${programs} ${maker})
  if(${program} IS_NEWER_THAN ${stamp})
    file(REMOVE_RECURSE ${scratch}/man1)
    execute_process(COMMAND ${maker} ${scratch}/man1 ${programs} COMMAND_ERROR_IS_FATAL ANY)
    file(TOUCH ${stamp})
    break()
  endif()
endforeach()
file(INSTALL ${scratch}/man1 DESTINATION ${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_MANDIR})

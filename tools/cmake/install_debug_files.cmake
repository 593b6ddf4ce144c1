# Runs when the build is installed: the debug information of programs and libraries is moved to files of its
# own, where debuggers and our crash reports find it by build id. An installation without lib/debug/ is small,
# and still reports the names of exported functions.
#   files                  installed programs and libraries, below the prefix
find_program(OBJCOPY objcopy REQUIRED)
find_program(READELF readelf REQUIRED)
set(root $ENV{DESTDIR}${CMAKE_INSTALL_PREFIX})
set(folder ${root}/lib/debug/.build-id)
foreach(file ${files})
  set(file ${root}/${file})
  execute_process(COMMAND ${READELF} -n ${file} OUTPUT_VARIABLE notes COMMAND_ERROR_IS_FATAL ANY)
  if(NOT notes MATCHES "Build ID: ([0-9a-f][0-9a-f])([0-9a-f]+)")
    message(FATAL_ERROR "${file} has no build id: link with --build-id")
  endif()
  set(debug ${folder}/${CMAKE_MATCH_1}/${CMAKE_MATCH_2}.debug)
  file(MAKE_DIRECTORY ${folder}/${CMAKE_MATCH_1})
  execute_process(COMMAND ${OBJCOPY} --only-keep-debug --compress-debug-sections ${file} ${debug}
                  COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${OBJCOPY} --strip-unneeded ${file} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
message(STATUS "Debug information: ${folder}")

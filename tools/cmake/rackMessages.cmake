# rack_message_file(NAME HEADER thermometer.h CLASS kThermometerClass): describes the messages of a
# class of one's own for programs that were not built with it. A small program is built with the
# header, which has the structs and the table (rack::ClassInfo) CLASS; what it writes is installed as
# share/rack/messages/NAME.json, where timsctl and DatalogRec look.
# Before it is installed: RACK_MESSAGES=<build>/share/rack/messages.
include(GNUInstallDirs)

function(rack_message_file name)
  cmake_parse_arguments(arg "" "HEADER;CLASS" "" ${ARGN})
  get_filename_component(header ${arg_HEADER} ABSOLUTE)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}_messages.cpp)
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT [[
#include <cstdio>
#include <fstream>

#include "@header@"

int main(int argc, char** argv) {
  const auto text = rack::message_file(@arg_CLASS@);
  if (text && argc == 2 && std::ofstream(argv[1]) << *text << std::flush) return 0;
  std::fprintf(stderr, "%s\n", text ? "cannot be written" : text.error().detail().c_str());
  return 1;
}
]])
  add_executable(${name}_messages ${source})
  target_link_libraries(${name}_messages PRIVATE rack::proxies)
  set(file ${CMAKE_CURRENT_BINARY_DIR}/share/rack/messages/${name}.json)
  add_custom_command(OUTPUT ${file} DEPENDS ${name}_messages VERBATIM
    COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_CURRENT_BINARY_DIR}/share/rack/messages
    COMMAND ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:${name}_messages> ${file})
  add_custom_target(${name}_message_file ALL DEPENDS ${file})
  install(FILES ${file} DESTINATION ${CMAKE_INSTALL_DATADIR}/rack/messages)
endfunction()

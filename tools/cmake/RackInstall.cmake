# The kit for other people's components: librack.so (messages, proxies, the runtime of a component)
# with headers, find_package(rack) and pkg-config; it needs libtims, as installed, and fmt, whose core
# header the one of log texts includes.
include(TimsInstall)

# rack_install_library(targets...): one librack out of the objects of these static libraries, with
# what they need of others behind NEEDS.
function(rack_install_library)
  if(TIMS_SANITIZE)
    return()  # nobody installs these builds
  endif()
  cmake_parse_arguments(arg "" "" "NEEDS" ${ARGN})
  set(objects ${arg_UNPARSED_ARGUMENTS})
  list(TRANSFORM objects PREPEND "$<TARGET_OBJECTS:")
  list(TRANSFORM objects APPEND ">")
  set(exports ${CMAKE_SOURCE_DIR}/tools/cmake/librack.map)

  add_library(rack_shared SHARED ${objects})
  set_target_properties(rack_shared PROPERTIES OUTPUT_NAME rack EXPORT_NAME rack
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    LINKER_LANGUAGE CXX LINK_DEPENDS ${exports} INSTALL_RPATH "$ORIGIN"
    LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
  target_link_options(rack_shared PRIVATE LINKER:--version-script=${exports} LINKER:-z,defs)
  # Of tims_os what libtims keeps to itself: it has no state.
  target_link_libraries(rack_shared PUBLIC tims_shared fmt::fmt PRIVATE tims_os ${arg_NEEDS})
  target_include_directories(rack_shared INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)

  # What users name. Both are in one library; a component is built with frame pointers, by which it
  # reports where it was not in real time.
  add_library(rack_proxies INTERFACE)
  target_link_libraries(rack_proxies INTERFACE rack_shared)
  set_target_properties(rack_proxies PROPERTIES EXPORT_NAME proxies)
  add_library(rack_runtime INTERFACE)
  target_link_libraries(rack_runtime INTERFACE rack_shared)
  target_compile_options(rack_runtime INTERFACE -fno-omit-frame-pointer)
  set_target_properties(rack_runtime PROPERTIES EXPORT_NAME runtime)

  install(TARGETS rack_shared rack_proxies rack_runtime EXPORT rack)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/proxies/include/
                    ${CMAKE_SOURCE_DIR}/components/runtime/include/ TYPE INCLUDE)
  install_cmake_package(rack)
  install(FILES ${CMAKE_SOURCE_DIR}/tools/cmake/rackMessages.cmake
          DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/rack)
  install_pkg_config(rack)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/components/template/
          DESTINATION ${CMAKE_INSTALL_DATADIR}/rack/template)
endfunction()

# The kit for other people's components: librack.so (messages, proxies, the runtime of a component) and
# librack-devices.so (what drivers and emulators of devices are made of) with headers, find_package(rack) and
# pkg-config. They need libtims, as installed, and fmt, whose core header the one of log texts includes.
include(TimsInstall)

# rack_shared_library(name targets... [NEEDS targets...] [USES targets...]): lib/librack.so or
# librack-devices.so out of the objects of these static libraries, showing what lib*.map lists. NEEDS: what
# they need of others; USES: libraries that its users link, too.
function(rack_shared_library target name)
  cmake_parse_arguments(arg "" "" "NEEDS;USES" ${ARGN})
  set(objects ${arg_UNPARSED_ARGUMENTS})
  list(TRANSFORM objects PREPEND "$<TARGET_OBJECTS:")
  list(TRANSFORM objects APPEND ">")
  set(exports ${CMAKE_SOURCE_DIR}/tools/cmake/lib${name}.map)

  add_library(${target} SHARED ${objects})
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${name} EXPORT_NAME ${name}
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    LINKER_LANGUAGE CXX LINK_DEPENDS ${exports} INSTALL_RPATH "$<$<NOT:$<BOOL:${TIMS_PACKAGED}>>:$ORIGIN>"
    LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
  target_link_options(${target} PRIVATE LINKER:--version-script=${exports} LINKER:-z,defs)
  target_link_libraries(${target} PUBLIC ${arg_USES} PRIVATE ${arg_NEEDS})
  target_include_directories(${target} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
endfunction()

# rack_install_library(targets...): one librack out of the objects of these static libraries, with
# what they need of others behind NEEDS.
function(rack_install_library)
  if(TIMS_SANITIZE)
    return()  # nobody installs these builds
  endif()
  # At the end of NEEDS: of tims_os what libtims keeps to itself; it has no state.
  rack_shared_library(rack_shared rack ${ARGN} tims_os USES tims_shared fmt::fmt)

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

# rack_install_devices(targets... NEEDS ...): librack-devices, for drivers and emulators of devices.
function(rack_install_devices)
  if(TIMS_SANITIZE)
    return()
  endif()
  rack_shared_library(rack_devices_shared rack-devices ${ARGN} USES rack_shared)
  add_library(rack_devices INTERFACE)
  target_link_libraries(rack_devices INTERFACE rack_devices_shared rack_runtime)
  set_target_properties(rack_devices PROPERTIES EXPORT_NAME devices)
  install(TARGETS rack_devices_shared rack_devices EXPORT rack)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/components/devices/include/ TYPE INCLUDE)
  install_pkg_config(rack-devices)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/components/devices/template/
          DESTINATION ${CMAKE_INSTALL_DATADIR}/rack/driver)
endfunction()

# What an installation consists of: libtims for other people's programs (static and shared, headers,
# find_package and pkg-config), the programs, and the files of the host.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(TIMS_UNIT_DIR lib/systemd/system CACHE STRING "for systemd units, below the prefix")
set(TIMS_SYSUSERS_DIR lib/sysusers.d CACHE STRING "for sysusers.d files, below the prefix")
option(TIMS_DEBUG_FILES "move debug information to files of its own, in lib/debug/, when installing" ON)
set(TIMS_UDEV_DIR lib/udev/rules.d CACHE STRING "for rules of udev, below the prefix")

# tims_install_library(targets...): one libtims out of the objects of these static libraries.
# tims::tims is the shared, tims::tims_static the static one.
function(tims_install_library)
  if(TIMS_SANITIZE)
    return()  # nobody installs these builds
  endif()
  set(objects ${ARGN})
  list(TRANSFORM objects PREPEND "$<TARGET_OBJECTS:")
  list(TRANSFORM objects APPEND ">")
  set(exports ${CMAKE_SOURCE_DIR}/tools/cmake/libtims.map)

  add_library(tims_shared SHARED ${objects})
  set_target_properties(tims_shared PROPERTIES VERSION ${PROJECT_VERSION} EXPORT_NAME tims
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} LINK_DEPENDS ${exports})
  target_link_options(tims_shared PRIVATE LINKER:--version-script=${exports} LINKER:-z,defs)
  add_library(tims_static STATIC ${objects})
  foreach(library tims_shared tims_static)
    set_target_properties(${library} PROPERTIES OUTPUT_NAME tims LINKER_LANGUAGE CXX
      LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
    target_include_directories(${library} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
    target_compile_features(${library} INTERFACE cxx_std_20)
    target_link_libraries(${library} PUBLIC Threads::Threads)
  endforeach()

  install(TARGETS tims_shared tims_static EXPORT tims)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/libtims/include/ TYPE INCLUDE)
  install_cmake_package(tims)
  install_pkg_config(tims)
endfunction()

# programs_of(VARIABLE FOLDER): the programs that are made there, without tests.
function(programs_of variable folder)
  get_property(targets DIRECTORY ${CMAKE_SOURCE_DIR}/${folder} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    if(NOT type STREQUAL "EXECUTABLE" OR target MATCHES "_test$")
      list(REMOVE_ITEM targets ${target})
    endif()
  endforeach()
  set(${variable} ${targets} PARENT_SCOPE)
endfunction()

# tims_install_host(programs...): what runs on a robot besides the library, and all drivers of
# devices. Called when all targets are known: cmake_language(DEFER ...).
function(tims_install_host)
  if(TIMS_LIBRARY_ONLY OR TIMS_SANITIZE)
    return()
  endif()
  programs_of(drivers components/devices/drivers)
  # None without OpenCV.
  programs_of(vision components/vision)
  programs_of(markers tools/marker_print)
  programs_of(calibration tools/camera_calibrate)
  programs_of(maps tools/map_maker)
  set(programs rack-emulate World ${drivers} ${vision} ${markers} ${calibration} ${maps} ${ARGN})
  # Found from a program's own place, so that an installation may be moved; and by the whole path for
  # programs with file capabilities, for which the dynamic linker ignores $ORIGIN. What a package installs
  # is never moved.
  set(common ${CMAKE_INSTALL_LIBDIR}/tims)
  set(own timsctl-deploy timsctl-robot timsctl-sim tims-crash-report tims-router-dds)  # not for users
  if(TARGET rack-video-reader)
    list(APPEND own rack-video-reader)
  endif()
  install(TARGETS tims_common DESTINATION ${common})
  if(TARGET rack_pictures)
    install(TARGETS rack_pictures rack_world_camera DESTINATION ${common})
    set(pictures ${common}/$<TARGET_FILE_NAME:rack_pictures> ${common}/$<TARGET_FILE_NAME:rack_world_camera>)
  endif()
  set(places ${CMAKE_INSTALL_FULL_LIBDIR}/tims)
  if(NOT TIMS_PACKAGED)
    list(PREPEND places $ORIGIN/../${common} $ORIGIN/../../${common})
  endif()
  set_target_properties(${programs} ${own} PROPERTIES INSTALL_RPATH "${places}")
  install(TARGETS ${programs})
  install(FILES ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/tims_router_tcp TYPE BIN)  # a link
  # What timsctl becomes for some of its verbs, and what a component starts when it crashes.
  install(TARGETS ${own} DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/tims)
  set(deploy ${CMAKE_SOURCE_DIR}/deploy)
  install(FILES ${deploy}/systemd/tims.sysusers DESTINATION ${TIMS_SYSUSERS_DIR} RENAME tims.conf)
  install(FILES ${deploy}/udev/60-rack.rules DESTINATION ${TIMS_UDEV_DIR})
  install(DIRECTORY ${deploy}/fleets ${deploy}/policies ${deploy}/robots ${deploy}/routes ${deploy}/worlds
    DESTINATION ${CMAKE_INSTALL_DATADIR}/tims FILES_MATCHING PATTERN *.toml PATTERN *.dxf PATTERN *.txt)
  # Units and settings are a component: they alone differ between two places.
  foreach(name TIMS_UNIT_DIR CMAKE_INSTALL_BINDIR CMAKE_INSTALL_MANDIR)
    install(CODE "set(${name} \"${${name}}\")" COMPONENT services)
  endforeach()
  install(CODE "set(deploy \"${deploy}\")\nset(scratch \"${CMAKE_CURRENT_BINARY_DIR}\")" COMPONENT services)
  install(SCRIPT ${CMAKE_SOURCE_DIR}/tools/cmake/install_services.cmake COMPONENT services)
  if(TIMS_DEBUG_FILES)
    set(files ${programs})
    list(TRANSFORM files PREPEND ${CMAKE_INSTALL_BINDIR}/)
    list(TRANSFORM own PREPEND ${CMAKE_INSTALL_LIBEXECDIR}/tims/)
    install(CODE "set(files ${common}/$<TARGET_FILE_NAME:tims_common> ${pictures} ${CMAKE_INSTALL_LIBDIR}/$<TARGET_FILE_NAME:tims_shared>
      ${CMAKE_INSTALL_LIBDIR}/$<TARGET_FILE_NAME:rack_shared>
      ${CMAKE_INSTALL_LIBDIR}/$<TARGET_FILE_NAME:rack_devices_shared> ${own} ${files})")
    install(SCRIPT ${CMAKE_SOURCE_DIR}/tools/cmake/install_debug_files.cmake)
  endif()
  list(TRANSFORM programs PREPEND ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/)
  install(CODE "set(maker \"${CMAKE_SOURCE_DIR}/tools/cmake/man_pages\")\nset(programs \"${programs}\")")
  install(SCRIPT ${CMAKE_SOURCE_DIR}/tools/cmake/install_man_pages.cmake)
endfunction()

# find_package(NAME): a version of the same minor number, as long as the major is 0.
function(install_cmake_package name)
  set(folder ${CMAKE_INSTALL_LIBDIR}/cmake/${name})
  install(EXPORT ${name} NAMESPACE ${name}:: FILE ${name}Targets.cmake DESTINATION ${folder})
  configure_package_config_file(${CMAKE_SOURCE_DIR}/tools/cmake/${name}Config.cmake.in
    ${name}Config.cmake INSTALL_DESTINATION ${folder})
  write_basic_package_version_file(${name}ConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}Config.cmake
                ${CMAKE_CURRENT_BINARY_DIR}/${name}ConfigVersion.cmake DESTINATION ${folder})
endfunction()

# The prefix is found from the file's own place: an installation may be moved, and DESTDIR works.
function(install_pkg_config name)
  file(RELATIVE_PATH TIMS_PREFIX_FROM_PC ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig
       ${CMAKE_INSTALL_PREFIX})
  configure_file(${CMAKE_SOURCE_DIR}/tools/cmake/${name}.pc.in ${name}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()

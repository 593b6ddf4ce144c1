# Runs when the build is installed, not when it is configured: only now is the prefix known for which
# `cmake --install --prefix P` was called, and the units name programs and settings below it.
#   deploy, scratch        folders: of the templates, and to write to
#   TIMS_UNIT_DIR, CMAKE_INSTALL_BINDIR    below the prefix
set(TIMS_BINDIR ${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR})
if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")  # whose settings are in /etc (GNU, FHS)
  set(TIMS_SYSCONFDIR /etc)
else()
  set(TIMS_SYSCONFDIR ${CMAKE_INSTALL_PREFIX}/etc)
endif()

foreach(service tims-router tims-robot@ tims-agent tims-keys gdos-log)
  configure_file(${deploy}/systemd/${service}.service.in ${scratch}/${service}.service @ONLY)
  file(INSTALL ${scratch}/${service}.service
       DESTINATION ${CMAKE_INSTALL_PREFIX}/${TIMS_UNIT_DIR})
endforeach()

file(INSTALL ${deploy}/systemd/tims-router.socket
     DESTINATION ${CMAKE_INSTALL_PREFIX}/${TIMS_UNIT_DIR})

# The settings of this host are its owner's: what is there already stays as it is.
if(EXISTS $ENV{DESTDIR}${TIMS_SYSCONFDIR}/tims/router.toml)
  message(STATUS "Kept: $ENV{DESTDIR}${TIMS_SYSCONFDIR}/tims/router.toml")
else()
  file(INSTALL ${deploy}/router.toml DESTINATION ${TIMS_SYSCONFDIR}/tims)
endif()

# Compiles for the architecture that `dpkg-architecture -a ARCH` has put into the environment.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR $ENV{DEB_HOST_GNU_CPU})
set(CMAKE_LIBRARY_ARCHITECTURE $ENV{DEB_HOST_MULTIARCH})
set(CMAKE_C_COMPILER $ENV{DEB_HOST_GNU_TYPE}-gcc)
set(CMAKE_CXX_COMPILER $ENV{DEB_HOST_GNU_TYPE}-g++)
set(ENV{PKG_CONFIG_LIBDIR} /usr/lib/$ENV{DEB_HOST_MULTIARCH}/pkgconfig:/usr/share/pkgconfig)

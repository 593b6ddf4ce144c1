# The project's functions that add targets. Every target gets the same warnings and sanitizers.
include(GNUInstallDirs)
find_package(Threads REQUIRED)

# Elsewhere, libraries are found from the place of the file that needs them, so that an installation may be moved.
option(TIMS_PACKAGED "for packages of a distribution: what they install is never moved" OFF)

# What every line of this process must be compiled with: also the Boost that is used as source.
add_library(tims_sanitizers INTERFACE)
if(TIMS_SANITIZE)
  target_compile_options(tims_sanitizers INTERFACE -fsanitize=${TIMS_SANITIZE}
                         -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(tims_sanitizers INTERFACE -fsanitize=${TIMS_SANITIZE})
  # The sanitizer calls dlopen() for the program: only a DT_RPATH of the program counts then.
  target_link_options(tims_sanitizers INTERFACE LINKER:--disable-new-dtags)
  # The first of these checks looks at an object through a pipe: a router without free descriptors
  # would be ended by it. What the next two see, the address sanitizer sees, too. They are a fifth of what
  # a file costs to compile.
  target_compile_options(tims_sanitizers INTERFACE -fno-sanitize=vptr,null,object-size)
  # These would be half of it with g++, and are left to clang, which the fuzzers are built with.
  set(gnu $<COMPILE_LANG_AND_ID:CXX,GNU>)
  target_compile_options(tims_sanitizers INTERFACE
                         $<${gnu}:-fno-sanitize=alignment,pointer-overflow,nonnull-attribute,returns-nonnull-attribute>
                         $<${gnu}:-fno-sanitize-address-use-after-scope>)
  # g++ 12 sees what is not there in instrumented code; the release build keeps these warnings.
  # "tsan" is about the fences of Boost.Asio, which stand beside its mutexes.
  target_compile_options(tims_sanitizers INTERFACE -Wno-maybe-uninitialized -Wno-array-bounds
                         $<${gnu}:-Wno-restrict;-Wno-stringop-overflow;-Wno-stringop-overread>
                         $<${gnu}:-Wno-mismatched-new-delete;-Wno-tsan>)
endif()
add_library(tims_tsan STATIC EXCLUDE_FROM_ALL ${CMAKE_SOURCE_DIR}/tests/support/tsan_clocklock.cpp
            ${CMAKE_SOURCE_DIR}/tests/support/tsan_suppressions.cpp)
if(TIMS_SANITIZE MATCHES "thread")
  target_link_libraries(tims_sanitizers INTERFACE tims_tsan)
  # Only the sanitizer and shared libraries ask for these: by name, so that they are linked.
  target_link_options(tims_sanitizers INTERFACE LINKER:-u,__tsan_default_suppressions
                      LINKER:-u,pthread_mutex_clocklock)
endif()

option(TIMS_WERROR "warnings are errors; OFF for compilers that nobody has tried yet" ON)
add_library(tims_options INTERFACE)
target_compile_options(tims_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                       $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor;-Wold-style-cast> $<$<BOOL:${TIMS_WERROR}>:-Werror>)
target_include_directories(tims_options INTERFACE ${CMAKE_SOURCE_DIR})
if(CMAKE_SIZEOF_VOID_P EQUAL 4)  # recordings and memory of more than 2 GiB
  target_compile_definitions(tims_options INTERFACE _FILE_OFFSET_BITS=64)
endif()
target_link_libraries(tims_options INTERFACE tims_sanitizers)

# Several sources of a target are compiled as one: half of what a source costs is its headers. tools/check
# compiles changed sources one by one (TIMS_UNITY=OFF), so that a missing include is found.
option(TIMS_UNITY "compile several sources of a target as one" ON)

# Common headers are compiled once. g++ accepts a precompiled header only with the options it was made
# with, so there is one for libraries, one for programs and one for tests. The release build does without:
# with them g++ reports faults inside std::string that do not exist.
set(TIMS_COMMON_HEADERS <algorithm> <array> <chrono> <cmath> <cstring> <fstream> <functional> <map> <memory>
    <optional> <span> <string> <string_view> <vector>)
file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/precompiled.cpp CONTENT "int main() {}\n")
if(TIMS_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(tims_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-fpch-preprocess>)  # for ccache
  add_library(libraries_precompiled STATIC ${CMAKE_BINARY_DIR}/precompiled.cpp)
  add_executable(programs_precompiled ${CMAKE_BINARY_DIR}/precompiled.cpp)
  foreach(precompiled libraries_precompiled programs_precompiled)
    target_link_libraries(${precompiled} PRIVATE tims_options)
    target_precompile_headers(${precompiled} PRIVATE ${TIMS_COMMON_HEADERS})
  endforeach()
endif()

# tims_reuse(name precompiled): compiles a target with it, in the builds that have it.
function(tims_reuse name precompiled)
  if(TARGET ${precompiled})
    target_precompile_headers(${name} REUSE_FROM ${precompiled})
  endif()
endfunction()

# tims_compile(name precompiled): how every target of this project is compiled.
function(tims_compile name precompiled)
  tims_reuse(${name} ${precompiled})
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${TIMS_UNITY} UNITY_BUILD_BATCH_SIZE 12)
  if(TIMS_UNITY)  # g++ takes a source that another one includes for a header
    target_compile_options(${name} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()

# tims_library(name SOURCES... [LINK targets...]): a static library of this project.
function(tims_library name)
  cmake_parse_arguments(arg "" "" "LINK" ${ARGN})
  add_library(${name} STATIC ${arg_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PUBLIC ${arg_LINK} PRIVATE $<BUILD_INTERFACE:tims_options>)
  tims_compile(${name} libraries_precompiled)
endfunction()

# tims_program(name SOURCES... [LINK targets...]): a program in bin/.
function(tims_program name)
  cmake_parse_arguments(arg "" "" "LINK" ${ARGN})
  add_executable(${name} ${arg_UNPARSED_ARGUMENTS})
  tims_compile(${name} programs_precompiled)
  if(NOT CMAKE_CURRENT_SOURCE_DIR MATCHES "/tests(/|$)")
    set_property(GLOBAL APPEND PROPERTY TIMS_PROGRAMS ${name})
    target_link_libraries(${name} PRIVATE tims_common)  # first: see there
  endif()
  target_link_libraries(${name} PRIVATE ${arg_LINK} tims_options)
endfunction()

# tims_common_library(targets... NEEDS libraries...): what most programs link, as one shared library of
# theirs, so that dozens of programs are small and linked at once. It is built from the objects of static
# libraries. A program names it before those: the linker takes from an archive only what is still missing.
# It promises nothing to other people's programs, which get libtims and librack.
function(tims_common_library)
  cmake_parse_arguments(arg "" "" "NEEDS" ${ARGN})
  set(objects ${arg_UNPARSED_ARGUMENTS})
  list(TRANSFORM objects PREPEND "$<TARGET_OBJECTS:")
  list(TRANSFORM objects APPEND ">")
  add_library(tims_common SHARED ${objects})
  set_target_properties(tims_common PROPERTIES OUTPUT_NAME rack-common-${PROJECT_VERSION} LINKER_LANGUAGE CXX
                        LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
  target_link_options(tims_common PRIVATE LINKER:-Bsymbolic-functions)  # calls inside it stay direct
  target_link_libraries(tims_common PRIVATE ${arg_NEEDS})
  if(TIMS_SANITIZE)  # what tims_sanitizers adds belongs into programs only
    target_link_options(tims_common PRIVATE -fsanitize=${TIMS_SANITIZE})
  else()
    target_link_options(tims_common PRIVATE LINKER:-z,defs)
  endif()
endfunction()

# tims_loaded_library(target NAME name OBJECTS targets... [LINK libraries...]): a library that programs load when
# they need it (components/files/loaded_library.h): it is built from the objects of static libraries, and what it
# has in common with the program is that of the program.
function(tims_loaded_library target)
  cmake_parse_arguments(arg "" "NAME" "OBJECTS;LINK" ${ARGN})
  list(TRANSFORM arg_OBJECTS PREPEND "$<TARGET_OBJECTS:")
  list(TRANSFORM arg_OBJECTS APPEND ">")
  add_library(${target} MODULE ${arg_OBJECTS})
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${arg_NAME}-${PROJECT_VERSION} LINKER_LANGUAGE CXX
                        LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib
                        INSTALL_RPATH $<IF:$<BOOL:${TIMS_PACKAGED}>,${CMAKE_INSTALL_FULL_LIBDIR}/tims,$ORIGIN>)
  # Needed by the archives behind it only, it would be passed over, and they would bring copies.
  target_link_libraries(${target} PRIVATE -Wl,--no-as-needed tims_common -Wl,--as-needed ${arg_LINK})
  if(TIMS_SANITIZE)  # what tims_sanitizers adds belongs into programs only
    target_link_options(${target} PRIVATE -fsanitize=${TIMS_SANITIZE})
  else()
    target_link_options(${target} PRIVATE LINKER:-z,defs)
  endif()
endfunction()

# programs_named_in(VARIABLE FILES...): the programs that robot files start.
function(programs_named_in variable)
  set(names "")
  foreach(file ${ARGN})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
    file(STRINGS ${file} lines REGEX "^ *program *=")
    foreach(line ${lines})
      string(REGEX REPLACE ".*\"([A-Za-z0-9-]+)\".*" "\\1" name "${line}")
      list(APPEND names ${name})
    endforeach()
  endforeach()
  list(REMOVE_DUPLICATES names)
  if(NOT RACK_WITH_OPENCV)
    list(REMOVE_ITEM names CameraV4l ObjRecogMarkers)
  endif()
  set(${variable} ${names} PARENT_SCOPE)
endfunction()

# tims_program_groups(): targets of what a verb of tools/dev needs, so that nobody waits for the rest.
# programs: all that is installed or judges algorithms, and the console. demo_programs: what deploy/fleets/demo.toml starts.
# bench_programs: tims-bench and what it measures. Called when all targets are known.
function(tims_program_groups)
  get_property(programs GLOBAL PROPERTY TIMS_PROGRAMS)
  add_custom_target(programs DEPENDS ${programs})
  foreach(more tims_shared tims_static rack_shared rack_devices_shared console)
    if(TARGET ${more})
      add_dependencies(programs ${more})
    endif()
  endforeach()

  set(robots ${CMAKE_SOURCE_DIR}/deploy/robots)
  programs_named_in(started ${robots}/sim.toml ${robots}/recorder.toml ${robots}/emulated.toml ${robots}/dora-base.toml
                    ${robots}/dora-drive.toml ${robots}/dora-laser.toml ${robots}/dora-nav.toml)
  add_custom_target(demo_programs DEPENDS ${started} tims-router timsctl timsctl-deploy timsctl-robot timsctl-sim tims-demo
                                          tims-crash-report World)
  foreach(more tims-replay console)
    if(TARGET ${more})
      add_dependencies(demo_programs ${more})
    endif()
  endforeach()
  if(TARGET tims-bench)
    add_custom_target(bench_programs DEPENDS tims-bench tims-router timsctl $<TARGET_NAME_IF_EXISTS:CameraV4l> ChassisSim ClockSystem
                                             LadarSickCola LadarSickLms200 LadarSim OdometryChassis Position Scan2d Scan2dSim)
  endif()
endfunction()

# Tests (not what they test) are compiled with less optimisation, which together with the precompiled
# is half of what a test costs.
if(TIMS_TESTS)
  set(TIMS_TEST_OPTIONS  # -fpch-preprocess is for ccache
      $<$<CONFIG:RelWithDebInfo>:-O1> $<$<CONFIG:Debug>:-O0>
      $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess;-Wno-array-bounds;-Wno-restrict;-Wno-stringop-overflow;-Wno-stringop-overread>)
  add_executable(tests_precompiled ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(tests_precompiled PRIVATE tims_options GTest::gtest GTest::gmock)
  target_precompile_headers(tests_precompiled PRIVATE ${TIMS_COMMON_HEADERS} <gmock/gmock.h> <gtest/gtest.h>)
  target_compile_options(tests_precompiled PRIVATE ${TIMS_TEST_OPTIONS})
endif()

# tims_test(name SOURCES... [LINK targets...] [DEFINE NAME=value...] [LABELS labels...] [PROCESSORS n]): a GoogleTest
# program; each TEST becomes a ctest test. Calls with the same name, in one or several folders, make one
# program: its start, its link and its headers are most of what a small test costs. Label vm: it needs what
# only tools/dev vm-test's kernel has, and is skipped elsewhere.
function(tims_test name)
  if(NOT TIMS_TESTS)
    return()
  endif()
  cmake_parse_arguments(arg "IN_SHARDS" "PROCESSORS" "LINK;DEFINE;LABELS" ${ARGN})
  if(NOT TARGET ${name})
    tims_test_program(${name})
  endif()
  target_sources(${name} PRIVATE ${arg_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PRIVATE ${arg_LINK})
  target_compile_definitions(${name} PRIVATE ${arg_DEFINE})
endfunction()

# tims_test_program(name): uses the options of the calling tims_test().
function(tims_test_program name)
  add_executable(${name})
  target_link_libraries(${name} PRIVATE tims_options GTest::gtest GTest::gmock GTest::gtest_main)
  target_compile_options(${name} PRIVATE ${TIMS_TEST_OPTIONS})
  tims_compile(${name} tests_precompiled)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if(arg_IN_SHARDS AND TIMS_SANITIZE)
    tims_test_shards(${name})
    return()
  endif()
  set(properties TIMEOUT 300)
  if(NOT arg_PROCESSORS AND "real_time" IN_LIST arg_LABELS)
    set(arg_PROCESSORS 3)  # robots that drive: beside a browser and compilers they would be late
  endif()
  if(arg_PROCESSORS)
    list(APPEND properties PROCESSORS ${arg_PROCESSORS})
  endif()
  if(arg_LABELS)
    list(APPEND properties LABELS "${arg_LABELS}" RESOURCE_LOCK "${arg_LABELS}")  # one kernel for all
  endif()
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES ${properties})
endfunction()

# tims_test_shards(name): the tests of a program in a few ctest tests. Instrumented, most of the time of
# a small test would be the start of the program.
function(tims_test_shards name)
  set(shards 4)
  foreach(shard RANGE 1 ${shards})
    math(EXPR index "${shard} - 1")
    add_test(NAME ${name}-${shard} COMMAND ${name} --gtest_brief=1)
    set_tests_properties(${name}-${shard} PROPERTIES TIMEOUT 1200
                         ENVIRONMENT "GTEST_TOTAL_SHARDS=${shards};GTEST_SHARD_INDEX=${index}")
  endforeach()
endfunction()

# tims_pure_test(...): the same for code without threads, where the thread sanitizer has nothing to find.
function(tims_pure_test)
  if(NOT TIMS_SANITIZE MATCHES "thread")
    tims_test(${ARGN} IN_SHARDS)
  endif()
endfunction()

# The project's ways to make a target. Every target gets the same warnings and sanitizers.
include(GNUInstallDirs)
find_package(Threads REQUIRED)

# What every line of this process must be compiled with: also the Boost that is used as source.
add_library(tims_sanitizers INTERFACE)
if(TIMS_SANITIZE)
  target_compile_options(tims_sanitizers INTERFACE -fsanitize=${TIMS_SANITIZE}
                         -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(tims_sanitizers INTERFACE -fsanitize=${TIMS_SANITIZE})
  # This check looks at an object through a pipe: a router without free descriptors would be ended by
  # it.
  target_compile_options(tims_sanitizers INTERFACE -fno-sanitize=vptr)
  # g++ 12 sees what is not there in instrumented code; the release build keeps these warnings.
  # "tsan" is about the fences of Boost.Asio, which stand beside its mutexes.
  target_compile_options(tims_sanitizers INTERFACE -Wno-maybe-uninitialized
                         $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-mismatched-new-delete;-Wno-tsan>)
endif()
add_library(tims_tsan STATIC EXCLUDE_FROM_ALL ${CMAKE_SOURCE_DIR}/tests/support/tsan_clocklock.cpp
            ${CMAKE_SOURCE_DIR}/tests/support/tsan_suppressions.cpp)
if(TIMS_SANITIZE MATCHES "thread")
  target_link_libraries(tims_sanitizers INTERFACE tims_tsan)
  # Nobody but the sanitizer asks for it: by name, so that it is linked.
  target_link_options(tims_sanitizers INTERFACE LINKER:-u,__tsan_default_suppressions)
endif()

add_library(tims_options INTERFACE)
target_compile_options(tims_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                       -Wnon-virtual-dtor -Wold-style-cast -Werror)
target_include_directories(tims_options INTERFACE ${CMAKE_SOURCE_DIR})
target_link_libraries(tims_options INTERFACE tims_sanitizers)

# tims_library(name SOURCES... [LINK targets...]): a static library of this project.
function(tims_library name)
  cmake_parse_arguments(arg "" "" "LINK" ${ARGN})
  add_library(${name} STATIC ${arg_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PUBLIC ${arg_LINK} PRIVATE $<BUILD_INTERFACE:tims_options>)
endfunction()

# tims_program(name SOURCES... [LINK targets...]): a program in bin/.
function(tims_program name)
  cmake_parse_arguments(arg "" "" "LINK" ${ARGN})
  add_executable(${name} ${arg_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PRIVATE ${arg_LINK} tims_options)
endfunction()

# What every test includes is compiled once, and tests (not what they test) with less optimisation:
# half of what a test costs to compile. g++ takes the precompiled only with the options it was made
# with, so it is made for an executable. It then sees faults inside of std::string that are not there;
# the product, which is compiled without, keeps those warnings.
if(TIMS_TESTS)
  set(TIMS_TEST_OPTIONS  # -fpch-preprocess is for ccache
      $<$<CONFIG:RelWithDebInfo>:-O1>
      $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess;-Wno-array-bounds;-Wno-restrict;-Wno-stringop-overflow;-Wno-stringop-overread>)
  file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/precompiled.cpp CONTENT "int main() {}\n")
  add_executable(tests_precompiled ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(tests_precompiled PRIVATE tims_options GTest::gtest GTest::gmock)
  target_precompile_headers(tests_precompiled PRIVATE <algorithm> <chrono> <functional> <memory> <optional>
                            <span> <string> <vector> <gmock/gmock.h> <gtest/gtest.h>)
  target_compile_options(tests_precompiled PRIVATE ${TIMS_TEST_OPTIONS})
endif()

# tims_test(name SOURCES... [LINK targets...] [DEFINE NAME=value...] [LABELS labels...]): a GoogleTest
# binary; each TEST becomes a ctest test. Label vm: it needs what only tools/dev vm-test's kernel has,
# and is skipped elsewhere.
function(tims_test name)
  if(NOT TIMS_TESTS)
    return()
  endif()
  cmake_parse_arguments(arg "" "" "LINK;DEFINE;LABELS" ${ARGN})
  add_executable(${name} ${arg_UNPARSED_ARGUMENTS})
  target_link_libraries(${name} PRIVATE ${arg_LINK} tims_options GTest::gtest GTest::gmock
                        GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE ${arg_DEFINE})
  target_compile_options(${name} PRIVATE ${TIMS_TEST_OPTIONS})
  target_precompile_headers(${name} REUSE_FROM tests_precompiled)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  set(properties TIMEOUT 300)
  if(arg_LABELS)
    list(APPEND properties LABELS "${arg_LABELS}" RESOURCE_LOCK "${arg_LABELS}")  # one kernel for all
  endif()
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES ${properties})
endfunction()

# tims_pure_test(...): the same for code that knows no threads, where the thread sanitizer has nothing
# to see.
function(tims_pure_test)
  if(NOT TIMS_SANITIZE MATCHES "thread")
    tims_test(${ARGN})
  endif()
endfunction()

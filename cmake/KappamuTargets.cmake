# Settings shared by every target, and the two functions that make one.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# The Python package is a shared object made of the same static libraries. Without interposition their own calls are
# still inlined.
set(CMAKE_POSITION_INDEPENDENT_CODE ${KAPPAMU_PYTHON})
if(KAPPAMU_PYTHON AND CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  add_compile_options(-fno-semantic-interposition)
endif()

# What whoever includes our headers needs, here or after installation: headers name each other from the
# root of the tree, others name them as <kappamu/...>.
add_library(kappamu_headers INTERFACE)
target_include_directories(kappamu_headers INTERFACE $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>
  $<INSTALL_INTERFACE:include> $<INSTALL_INTERFACE:include/kappamu>)
target_compile_features(kappamu_headers INTERFACE cxx_std_20)

add_library(kappamu_settings INTERFACE)
target_link_libraries(kappamu_settings INTERFACE kappamu_headers)
target_compile_options(kappamu_settings INTERFACE -Wall -Wextra -Wpedantic -Wshadow)
# Fused multiply-adds would make the serial reference differ between compilers.
target_compile_options(kappamu_settings INTERFACE -ffp-contract=off)
# GCC 12 sees overlapping copies where std::string is assigned or added: https://gcc.gnu.org/PR105651.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 12
   AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(kappamu_settings INTERFACE -Wno-restrict)
endif()
if(KAPPAMU_WERROR)
  target_compile_options(kappamu_settings INTERFACE -Werror)
endif()

# For code that computes nothing (commands, tests): headers such as CLI11's cost half as much to compile so.
add_library(kappamu_light INTERFACE)
target_compile_options(kappamu_light INTERFACE $<$<CONFIG:Release>:-O1>)

# kappamu_unity(target): each folder of its sources compiles as one, which reads headers once; the whole takes a third of the
# time. Who edits and rebuilds single files turns it off: -DKAPPAMU_UNITY=OFF.
function(kappamu_unity target)
  if(NOT KAPPAMU_UNITY)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    get_filename_component(folder ${source} DIRECTORY)
    file(RELATIVE_PATH folder ${CMAKE_CURRENT_SOURCE_DIR} ${folder})
    string(MAKE_C_IDENTIFIER "in_${folder}" group)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
endfunction()

# Behind a precompiled header GCC 12 warns of std::string's and std::vector's own code.
set(KAPPAMU_PRECOMPILED_WARNINGS "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow>")
# What most sources read, read once for all libraries: a tenth of the time. Headers that only some of them need are named
# by PRECOMPILE below, for that library alone.
set(KAPPAMU_COMMON_HEADERS <Eigen/Core> <Eigen/Geometry> <algorithm> <array> <cmath> <filesystem> <functional> <map> <memory>
    <optional> <span> <string> <vector>)
function(kappamu_precompile target)
  if(ARGN)
    target_precompile_headers(${target} PRIVATE ${KAPPAMU_COMMON_HEADERS} ${ARGN})
  elseif(target STREQUAL kappamu_core)
    target_precompile_headers(${target} PRIVATE ${KAPPAMU_COMMON_HEADERS})
  else()
    target_precompile_headers(${target} REUSE_FROM kappamu_core)
  endif()
  target_compile_options(${target} PRIVATE ${KAPPAMU_PRECOMPILED_WARNINGS})
endfunction()

# kappamu_library(core DEPS ... PRIVATE_DEPS ... PRECOMPILE ...): the folder's .cpp files as one static library.
function(kappamu_library name)
  cmake_parse_arguments(ARG "" "" "DEPS;PRIVATE_DEPS;PRECOMPILE" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  # Needs MPI and PETSc: a library of its own (forward/distributed/CMakeLists.txt).
  list(FILTER sources EXCLUDE REGEX "^${CMAKE_CURRENT_SOURCE_DIR}/distributed/")
  if(NOT sources)
    add_library(kappamu_${name} INTERFACE)
    target_link_libraries(kappamu_${name} INTERFACE kappamu_headers ${ARG_DEPS})
    return()
  endif()
  add_library(kappamu_${name} STATIC ${sources})
  kappamu_unity(kappamu_${name})
  target_link_libraries(kappamu_${name} PUBLIC kappamu_headers ${ARG_DEPS}
                        PRIVATE $<BUILD_INTERFACE:kappamu_settings> ${ARG_PRIVATE_DEPS})
  kappamu_precompile(kappamu_${name} ${ARG_PRECOMPILE})
  kappamu_install(${name})
endfunction()

# kappamu_install(core): the library as kappamu::core and its headers under include/kappamu/core.
function(kappamu_install name)
  set_target_properties(kappamu_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS kappamu_${name} EXPORT kappamu ARCHIVE DESTINATION lib)
  install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} DESTINATION include/kappamu
          FILES_MATCHING PATTERN "*.h" PATTERN "*.inc")
endfunction()

# kappamu_test(core DEPS ... SLOW ... TOGETHER ...): tests/<name>/*_test.cpp as one GoogleTest program, each case in
# CTest; SLOW names, as GoogleTest filters, the statistical and other long ones, whose label then ends in `-slow`;
# TOGETHER names suites whose cases share a long set-up, and therefore a process.
function(kappamu_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "DEPS;SLOW;TOGETHER" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.cpp)
  if(NOT sources)
    return()
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_executable(${name}_test ${sources})
  target_link_libraries(${name}_test PRIVATE kappamu_settings kappamu_light ${ARG_DEPS} GTest::gmock GTest::gtest_main)
  # One for all test programs.
  if(name STREQUAL core)
    target_precompile_headers(core_test PRIVATE ${KAPPAMU_COMMON_HEADERS} <gmock/gmock.h> <gtest/gtest.h>)
  else()
    target_precompile_headers(${name}_test REUSE_FROM core_test)
  endif()
  target_compile_options(${name}_test PRIVATE ${KAPPAMU_PRECOMPILED_WARNINGS})
  target_compile_definitions(${name}_test PRIVATE KAPPAMU_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  kappamu_discover(${name}_test ${name} ${ARG_TIMEOUT} "${ARG_SLOW}" ${ARG_TOGETHER})
endfunction()

# kappamu_discover(core_test core 300 "Slow.*;Other.*" [Suite ...]): the cases of a program in CTest, those of the suites
# together.
function(kappamu_discover program label timeout slow)
  set(common DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 120 TEST_PREFIX ${label}.)
  if(slow)
    list(JOIN slow ":" filter)
    gtest_discover_tests(${program} ${common} TEST_FILTER ${filter} TEST_LIST ${program}_slow
                         PROPERTIES TIMEOUT ${timeout} LABELS ${label}-slow)
  endif()
  foreach(suite ${ARGN})
    add_test(NAME ${label}.${suite} COMMAND ${program} --gtest_filter=${suite}.*)
    set_tests_properties(${label}.${suite} PROPERTIES TIMEOUT ${timeout} LABELS ${label})
  endforeach()
  list(TRANSFORM ARGN APPEND ".*" OUTPUT_VARIABLE together)
  set(apart ${slow} ${together})
  list(JOIN apart ":" filter)
  gtest_discover_tests(${program} ${common} TEST_FILTER -${filter} PROPERTIES TIMEOUT ${timeout} LABELS ${label})
endfunction()

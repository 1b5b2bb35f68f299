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

add_library(kappamu_settings INTERFACE)
target_include_directories(kappamu_settings INTERFACE ${CMAKE_SOURCE_DIR})
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

# kappamu_library(core DEPS ... PRIVATE_DEPS ...): the folder's .cpp files as one static library.
function(kappamu_library name)
  cmake_parse_arguments(ARG "" "" "DEPS;PRIVATE_DEPS" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  if(NOT sources)
    add_library(kappamu_${name} INTERFACE)
    target_link_libraries(kappamu_${name} INTERFACE kappamu_settings ${ARG_DEPS})
    return()
  endif()
  add_library(kappamu_${name} STATIC ${sources})
  target_link_libraries(kappamu_${name} PUBLIC kappamu_settings ${ARG_DEPS} PRIVATE ${ARG_PRIVATE_DEPS})
endfunction()

# kappamu_test(core DEPS ...): tests/<name>/*_test.cpp as one GoogleTest program, each case in CTest.
function(kappamu_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "DEPS" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.cpp)
  if(NOT sources)
    return()
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_executable(${name}_test ${sources})
  target_link_libraries(${name}_test PRIVATE kappamu_light ${ARG_DEPS} GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name}_test PRIVATE KAPPAMU_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  gtest_discover_tests(${name}_test TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST
                       PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS ${name})
endfunction()

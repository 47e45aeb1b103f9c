# How tests are built and registered: one program per room of the tree, all with the same support
# and the same precompiled headers of the test libraries.
#
# A test carries one label: short (less than 5 s of processor time; all of them less than a minute),
# medium, or long, which ./check leaves out. tools/test_seconds proves it. No test depends on what
# else the machine does: its limits count processor time, and OCTAVO_TEST_TIMEOUT only ends what
# hangs.

find_package(GTest REQUIRED)
find_package(rapidcheck REQUIRED)
find_package(Python3 REQUIRED COMPONENTS Interpreter)

set(OCTAVO_TEST_TIMEOUT 3600)

add_library(octavo_test_flags INTERFACE)
target_include_directories(octavo_test_flags INTERFACE ${CMAKE_SOURCE_DIR}/tests)
target_link_libraries(octavo_test_flags INTERFACE octavo_flags GTest::gtest rapidcheck)
# What is tested is optimized, the tests are not: optimizing them would take longer than they run.
target_compile_options(octavo_test_flags INTERFACE $<$<CONFIG:Release>:-O1>)

file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/test_headers.cpp CONTENT "")
add_library(octavo_test_headers OBJECT ${CMAKE_BINARY_DIR}/test_headers.cpp)
target_link_libraries(octavo_test_headers PRIVATE octavo_test_flags)
# Compilers only take headers that were compiled as the programs are.
set_target_properties(octavo_test_headers PROPERTIES POSITION_INDEPENDENT_CODE OFF)
target_compile_options(octavo_test_headers PRIVATE ${CMAKE_CXX_COMPILE_OPTIONS_PIE})
target_precompile_headers(octavo_test_headers PRIVATE
  <gtest/gtest.h> <rapidcheck.h> <algorithm> <array> <cstdint> <map> <random> <span> <string>
  <vector>)

# octavo_add_test(NAME TIER COMMAND...): exit status 77 skips. The short ones run last, so that no
# core waits for a long one at the end.
function(octavo_add_test name tier)
  add_test(NAME ${name} COMMAND ${ARGN})
  set(cost 2)
  if(tier STREQUAL short)
    set(cost 1)
  endif()
  set_tests_properties(${name} PROPERTIES
    LABELS ${tier} COST ${cost} TIMEOUT ${OCTAVO_TEST_TIMEOUT} SKIP_RETURN_CODE 77)
endfunction()

# octavo_test(NAME TIER SOURCES a.cpp ... USES octavo_core ... [MEDIUM FILTERS...] [FULL])
# One gtest program. What matches one of FILTERS is left out of the test NAME and is the test
# NAME_medium. FULL adds the test NAME_long, all of it in the form of tools/nightly.
function(octavo_test name tier)
  cmake_parse_arguments(arg "FULL" "" "SOURCES;USES;LINKS;MEDIUM" ${ARGN})
  list(JOIN arg_MEDIUM ":" medium)
  add_executable(test_${name} ${arg_SOURCES})
  target_link_libraries(test_${name}
    PRIVATE ${arg_USES} ${arg_LINKS} octavo_source_folder octavo_test_flags GTest::gtest_main)
  octavo_unity(test_${name} 16)
  if(NOT CMAKE_CXX_COMPILER_LAUNCHER)
    target_precompile_headers(test_${name} REUSE_FROM octavo_test_headers)
  endif()
  octavo_add_test(${name} ${tier} test_${name} --gtest_filter=-${medium})
  if(medium)
    octavo_add_test(${name}_medium medium test_${name} --gtest_filter=${medium})
  endif()
  if(arg_FULL)
    octavo_add_test(${name}_long long test_${name})
    set_tests_properties(${name}_long PROPERTIES ENVIRONMENT OCTAVO_NIGHTLY_SHARE=1)
  endif()
endfunction()

# octavo_script(NAME TIER SCRIPT ARGUMENTS...): a Python script of this folder.
function(octavo_script name tier script)
  octavo_add_test(${name} ${tier}
    ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/${script} ${ARGN})
endfunction()

# How tests are built: one program per room of the tree, all with the same support and the same
# precompiled headers of the test libraries.

find_package(GTest REQUIRED)
find_package(rapidcheck REQUIRED)

add_library(octavo_test_flags INTERFACE)
target_include_directories(octavo_test_flags INTERFACE ${CMAKE_SOURCE_DIR}/tests)
target_link_libraries(octavo_test_flags INTERFACE octavo_flags GTest::gtest rapidcheck)

file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/test_headers.cpp CONTENT "")
add_library(octavo_test_headers OBJECT ${CMAKE_BINARY_DIR}/test_headers.cpp)
target_link_libraries(octavo_test_headers PRIVATE octavo_test_flags)
target_precompile_headers(octavo_test_headers PRIVATE
  <gtest/gtest.h> <rapidcheck.h> <algorithm> <array> <cstdint> <map> <random> <span> <string>
  <vector>)

# octavo_test(NAME TIER SOURCES a.cpp ... USES octavo_core ...): one gtest program, one ctest label.
function(octavo_test name tier)
  cmake_parse_arguments(arg "" "" "SOURCES;USES;LINKS" ${ARGN})
  add_executable(test_${name} ${arg_SOURCES})
  target_link_libraries(test_${name}
    PRIVATE ${arg_USES} ${arg_LINKS} octavo_source_folder octavo_test_flags GTest::gtest_main)
  if(NOT CMAKE_CXX_COMPILER_LAUNCHER)
    target_precompile_headers(test_${name} REUSE_FROM octavo_test_headers)
  endif()
  add_test(NAME ${name} COMMAND test_${name})
  set_tests_properties(${name} PROPERTIES LABELS ${tier} TIMEOUT 600)
endfunction()

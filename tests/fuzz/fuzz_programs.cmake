# octavo_fuzz_target(NAME LIBRARIES...)
function(octavo_fuzz_target target)
  add_executable(fuzz_${target} fuzz_${target}.cpp ${sources_${target}})
  target_include_directories(fuzz_${target} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  target_link_libraries(fuzz_${target} PRIVATE ${ARGN} octavo_flags ${octavo_fuzz_engine})
  add_dependencies(fuzz_programs fuzz_${target})
endfunction()

add_custom_target(fuzz_programs)
foreach(target ${reading_targets})
  octavo_fuzz_target(${target} octavo_read)
endforeach()
add_subdirectory(${CMAKE_SOURCE_DIR}/src/octavo/core ${CMAKE_BINARY_DIR}/core)
octavo_fuzz_target(metadata octavo_core)

# The others need libraries of the system, which do not go with an engine that brings its own
# standard library.
if(OCTAVO_FUZZING_ENGINE)
  return()
endif()

find_library(HIGHWAY_LIBRARY hwy REQUIRED)
octavo_decoders(portable ${decoder_sources})
set(simd_sources ${OCTAVO_READ_SIMD_SOURCES})
list(FILTER simd_sources EXCLUDE REGEX /file/)
octavo_decoders(simd ${simd_sources})
# One instruction set: with sanitizers, each one more takes clang many minutes.
target_compile_options(decoders_simd PRIVATE -O1 -march=haswell)
target_compile_definitions(decoders_simd PRIVATE HWY_COMPILE_ONLY_STATIC)
target_link_libraries(decoders_simd PRIVATE ${HIGHWAY_LIBRARY})
octavo_fuzz_target(simd decoders_portable decoders_simd)

# The building half.
foreach(module octree planes codec file builder dist)
  add_subdirectory(${CMAKE_SOURCE_DIR}/src/octavo/${module} ${CMAKE_BINARY_DIR}/${module})
endforeach()
target_compile_options(octavo_codec PRIVATE -O1 -march=haswell)
target_compile_definitions(octavo_codec PRIVATE HWY_COMPILE_ONLY_STATIC)
set(sources_round_trip ../support/memory_storage.cpp)
octavo_fuzz_target(round_trip octavo_builder)
set(sources_part ../support/memory_storage.cpp)
octavo_fuzz_target(part octavo_dist)
octavo_fuzz_target(plan octavo_dist)

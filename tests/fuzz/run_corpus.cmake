# run_corpus TARGET FOLDER...: without an engine and without clang.
set(targets ${reading_targets} metadata simd round_trip plan part mesh)
set(names)
add_executable(run_corpus run_corpus.cpp)
foreach(target ${targets})
  target_sources(run_corpus PRIVATE fuzz_${target}.cpp)
  set_source_files_properties(fuzz_${target}.cpp
    PROPERTIES COMPILE_DEFINITIONS LLVMFuzzerTestOneInput=fuzz_${target})
  string(APPEND names "X(${target})")
  string(REPLACE simd brick corpus ${target})
  octavo_add_test(fuzz_corpus_${target} medium
    run_corpus ${target} ${CMAKE_CURRENT_SOURCE_DIR}/corpus/${corpus})
endforeach()

# fuzz_simd holds portable decoders against those of this build.
octavo_decoders(portable ${decoder_sources})
octavo_unity(decoders_portable 32)
target_compile_options(decoders_portable PRIVATE $<$<CONFIG:Release>:-O1>)
set_property(SOURCE fuzz_simd.cpp APPEND PROPERTY COMPILE_DEFINITIONS octavo_simd=octavo)
target_sources(run_corpus PRIVATE decoded_brick.cpp)
set_source_files_properties(run_corpus.cpp PROPERTIES COMPILE_DEFINITIONS FUZZ_TARGETS=${names})
target_link_libraries(run_corpus
  PRIVATE octavo_test_support decoders_portable octavo_dist octavo_builder octavo_mesh octavo_file
  octavo_codec octavo_test_flags)

# octavo_embed(TARGET SYMBOL FILE): makes the bytes of FILE a part of a library, as
#
#     namespace octavo {
#     extern const unsigned char SYMBOL[];
#     extern const unsigned long SYMBOL_size;
#     }
function(octavo_embed target symbol file)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${symbol}.cpp)
  set(script ${CMAKE_SOURCE_DIR}/cmake/embed_file.cmake)
  add_custom_command(OUTPUT ${source}
    COMMAND ${CMAKE_COMMAND} -D symbol=${symbol} -D source=${CMAKE_CURRENT_SOURCE_DIR}/${file}
      -D output=${source} -P ${script}
    DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${file} ${script}
    VERBATIM)
  target_sources(${target} PRIVATE ${source})
endfunction()

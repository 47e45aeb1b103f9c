# octavo_highway_headers(TARGET...): the headers of Highway for targets of another machine, out of
# those of the building machine and without the other headers beside them.
#
# Highway 1.0 keeps two instructions of WebAssembly switched off, for a browser of 2021: bytes
# looked up in a vector (i8x16.swizzle) and the bits of a mask (bitmask) go through memory one by
# one. Here they are switched on; later versions have them, and stay as they are.
function(octavo_highway_headers)
  find_path(HIGHWAY_INCLUDE hwy/highway.h PATHS /usr/include REQUIRED NO_CMAKE_FIND_ROOT_PATH)
  set(folder ${CMAKE_BINARY_DIR}/include)
  if(IS_SYMLINK ${folder}/hwy)
    file(REMOVE ${folder}/hwy)
  endif()
  file(COPY ${HIGHWAY_INCLUDE}/hwy DESTINATION ${folder} PATTERN wasm_128-inl.h EXCLUDE)
  file(READ ${HIGHWAY_INCLUDE}/hwy/ops/wasm_128-inl.h text)
  string(REPLACE "#if 0\n  return Vec128<TI, NI>{wasm_i8x16_swizzle"
    "#if 1\n  return Vec128<TI, NI>{wasm_i8x16_swizzle" text "${text}")
  string(REPLACE "  const __i32x4 mask_i = static_cast<__i32x4>(mask.raw);
  const __i32x4 slice = wasm_i32x4_make(1, 2, 4, 8);
  const __i32x4 sliced_mask = wasm_v128_and(mask_i, slice);
  alignas(16) uint32_t lanes[4];
  wasm_v128_store(lanes, sliced_mask);
  return lanes[0] | lanes[1] | lanes[2] | lanes[3];"
    "  return static_cast<uint64_t>(wasm_i32x4_bitmask(mask.raw));" text "${text}")
  string(REPLACE "  alignas(16) uint64_t lanes[2];
  wasm_v128_store(lanes, mask.raw);

  constexpr uint64_t kMagic = 0x103070F1F3F80ULL;
  const uint64_t lo = ((lanes[0] * kMagic) >> 56);
  const uint64_t hi = ((lanes[1] * kMagic) >> 48) & 0xFF00;
  return (hi + lo);"
    "  return static_cast<uint64_t>(wasm_i8x16_bitmask(mask.raw));" text "${text}")
  file(CONFIGURE OUTPUT ${folder}/hwy/ops/wasm_128-inl.h CONTENT "${text}" @ONLY)
  foreach(target ${ARGN})
    target_include_directories(${target} SYSTEM PRIVATE ${folder})
  endforeach()
endfunction()

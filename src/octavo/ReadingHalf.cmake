# octavo::read: the reading half on its own. Bytes in, voxels out: no third-party code, no threads,
# no files, no writes. It is what is fuzzed and what a browser runs. tools/check_includes.py proves
# the promise for every header these sources reach.
set(OCTAVO_READ_SOURCES
  core/crc32c.cpp
  core/error.cpp
  core/geometry.cpp
  core/json_number.cpp
  core/json_reader.cpp
  core/json_text.cpp
  core/label_color.cpp
  core/label_names.cpp
  core/levels.cpp
  core/made_by.cpp
  core/metadata_reading.cpp
  core/place_known.cpp
  core/powers_of_ten.cpp
  core/sample_coding.cpp
  core/sha256.cpp
  core/url_text.cpp
  core/utf8.cpp
  core/volume.cpp
  core/voxel_type.cpp
  core/work_part.cpp
  octree/label_words.cpp
  octree/o_code.cpp
  codec/brick_codec.cpp
  codec/codec_of_kind.cpp
  codec/exact/absent_samples.cpp
  codec/exact/exact_codec.cpp
  codec/exact/float_bins.cpp
  codec/exact/float_codes.cpp
  codec/exact/float_places.cpp
  codec/exact/plain_floats.cpp
  codec/grey/edge_pairs.cpp
  codec/grey/grey_brick.cpp
  codec/grey/grey_codec.cpp
  codec/grey/grey_corrections.cpp
  codec/grey/grey_decoder.cpp
  codec/grey/grey_interpolation.cpp
  codec/grey/grey_model.cpp
  codec/grey/grey_parts.cpp
  codec/grey/grey_stage_dispatch_portable.cpp
  codec/grey/grey_stage_portable.cpp
  codec/grey/octant_transform.cpp
  codec/grey/residual_coder.cpp
  codec/grey/value_map.cpp
  codec/label/label_contexts.cpp
  codec/label/label_decoder.cpp
  codec/label/label_encoder.cpp
  codec/label/label_grid.cpp
  codec/label/label_model.cpp
  codec/label/label_net.cpp
  codec/label/label_octant.cpp
  codec/label/label_pyramid.cpp
  codec/label/label_start_weights.cpp
  codec/label/label_stored.cpp
  codec/label/label_walk_dispatch_portable.cpp
  codec/label/label_walk_portable.cpp
  codec/label/label_word_bricks.cpp
  file/bit_flip.cpp
  file/box_plan.cpp
  file/brick_check.cpp
  file/damage.cpp
  file/directory.cpp
  file/fixed_png.cpp
  file/index.cpp
  file/index_lengths.cpp
  file/index_root.cpp
  file/layer_order.cpp
  file/layout.cpp
  file/open_file.cpp
  file/part_reader.cpp
  file/pieces.cpp
  file/plane_digests.cpp
  file/reader.cpp
  file/slab_trailer.cpp
  file/storage/byte_range.cpp
  file/storage/byte_source.cpp
  file/storage/sparse_source.cpp
  file/thumbnail.cpp
  file/thumbnail_check.cpp
  file/verified_part.cpp
  file/verify.cpp
)
list(TRANSFORM OCTAVO_READ_SOURCES PREPEND ${CMAKE_CURRENT_LIST_DIR}/)

# The same with vectorized decoders, for those who have Highway.
set(OCTAVO_READ_SIMD_SOURCES
  codec/grey/grey_stage_simd.cpp codec/highway_targets.cpp codec/label/label_walk_simd.cpp
  codec/simd_level.cpp)
list(TRANSFORM OCTAVO_READ_SIMD_SOURCES PREPEND ${CMAKE_CURRENT_LIST_DIR}/)
list(APPEND OCTAVO_READ_SIMD_SOURCES ${OCTAVO_READ_SOURCES})
list(FILTER OCTAVO_READ_SIMD_SOURCES EXCLUDE REGEX _dispatch_portable)

# octavo_read_library(SOURCES...): octavo::read of these, or of what rooms compiled of them.
function(octavo_read_library)
  add_library(octavo_read STATIC ${ARGN})
  target_include_directories(octavo_read PUBLIC
    $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/src> $<INSTALL_INTERFACE:include>)
  target_link_libraries(octavo_read PRIVATE $<BUILD_INTERFACE:octavo_flags>)
  target_compile_features(octavo_read PUBLIC cxx_std_20)
  set_target_properties(octavo_read PROPERTIES EXPORT_NAME read)
  octavo_unity(octavo_read)
  add_library(octavo::read ALIAS octavo_read)
  install(TARGETS octavo_read EXPORT octavoReadTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
endfunction()

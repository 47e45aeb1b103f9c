# How every module of src/octavo is built: one static library per folder, the same warnings for all.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

add_library(octavo_flags INTERFACE)
target_compile_options(octavo_flags INTERFACE
  -Wall -Wextra $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> -Wshadow -Wconversion -Wsign-conversion
  # -Wrestrict: GCC 12 warns of overlaps inside its own std::string.
  # Where sizes have 32 bits, files still have 64.
  $<$<AND:$<CXX_COMPILER_ID:Clang>,$<EQUAL:${CMAKE_SIZEOF_VOID_P},4>>:-Wno-shorten-64-to-32>
  # The model's floating-point training must give the same bytes on every machine.
  -ffp-contract=off)

# Masks are counted bit by bit all the time. Every x86-64 processor since 2008 has the instruction;
# the program says so where one lacks it.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$" AND NOT EMSCRIPTEN)
  target_compile_options(octavo_flags INTERFACE -mpopcnt)
endif()

# Hardening of everything that is optimized and carries no sanitizer, which brings its own checks;
# WebAssembly is a sandbox of its own.
include(CheckPIESupported)
check_pie_supported()
if(EMSCRIPTEN OR OCTAVO_BUILD_WEB)
  set(octavo_hardened 0)
else()
  set(octavo_hardened $<CONFIG:Release>)
endif()
set(octavo_checks
  -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2 -D_GLIBCXX_ASSERTIONS -fstack-protector-strong)
target_compile_options(octavo_flags INTERFACE "$<${octavo_hardened}:${octavo_checks}>")
target_link_options(octavo_flags INTERFACE
  "$<${octavo_hardened}:LINKER:-z,relro,-z,now,-z,noexecstack>")

include(GNUInstallDirs)
# Libraries that are loaded when they are needed, and how an installed program finds them.
set(OCTAVO_LIBRARY_FOLDER ${CMAKE_INSTALL_LIBDIR}/octavo)
file(RELATIVE_PATH octavo_library_path
  /${CMAKE_INSTALL_BINDIR} /${OCTAVO_LIBRARY_FOLDER})
set(OCTAVO_PROGRAM_RPATH $ORIGIN/${octavo_library_path})
# A build folder may be moved, or seen by another path.
set(CMAKE_BUILD_RPATH_USE_ORIGIN ON)

# Half of a compiler's time goes into headers that every source of a target reads again, and into
# what their templates become.
option(OCTAVO_UNITY "Compile sooner: many sources of a target at a time" OFF)

# octavo_optimized(TARGET ROOM): in the wheel, which everybody downloads, rooms without loops over
# voxels, and the builder, which leaves them to the codec, are compiled for size, and others without
# what makes code long for a few percent. Compiled for size the mesh room takes twice as long.
set(octavo_rooms_for_size builder dist io tasks)
# Sources of other rooms that are compiled for size, too, at next to no cost; and which are not.
set(octavo_sources_for_size
  "^core/|^file/|^mesh/formats/|^planes/|\
^render/(animated|annotation|color_scale|label_color|numbers|view)")
set(octavo_sources_for_speed
  "^core/(crc32c|sha256)|^planes/between/|\
^file/(brick_check|index|layer_order|layout|open_file|part_reader|pieces|plane_digests|reader)")
# Where sources are compiled together, what leaves loops over voxels to others costs a third less
# without what takes the compiler longest.
set(octavo_targets_for_time octavo_builder octavo_dist octavo_file octavo_io octavo_tasks)
function(octavo_optimized target room)
  if(OCTAVO_WHEEL)
    if(room IN_LIST octavo_rooms_for_size)
      target_compile_options(${target} PRIVATE -Os)
    else()
      target_compile_options(${target} PRIVATE -O2)
    endif()
    target_compile_options(${target} PRIVATE -ffunction-sections -fdata-sections)
  elseif(OCTAVO_UNITY AND target IN_LIST octavo_targets_for_time)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
endfunction()

# octavo_take_small(TARGET ROOM VARIABLE [LIBRARY ...]): in the wheel, takes the sources that are
# compiled for size out of VARIABLE, which holds absolute paths and gets their objects instead. They
# become an object library beside the target, which sees the libraries.
function(octavo_take_small target room variable)
  if(NOT OCTAVO_WHEEL OR room IN_LIST octavo_rooms_for_size)
    return()
  endif()
  set(taken)
  set(left)
  foreach(source ${${variable}})
    file(RELATIVE_PATH place ${CMAKE_SOURCE_DIR}/src/octavo ${source})
    if(place MATCHES "${octavo_sources_for_size}"
       AND NOT place MATCHES "${octavo_sources_for_speed}")
      list(APPEND taken ${source})
    else()
      list(APPEND left ${source})
    endif()
  endforeach()
  if(taken)
    add_library(${target}_small OBJECT ${taken})
    target_include_directories(${target}_small PRIVATE ${CMAKE_SOURCE_DIR}/src)
    target_link_libraries(${target}_small PRIVATE octavo_flags ${ARGN})
    target_compile_options(${target}_small PRIVATE -Os -ffunction-sections -fdata-sections)
    octavo_unity(${target}_small)
    set(${target}_small_objects $<TARGET_OBJECTS:${target}_small> PARENT_SCOPE)
  endif()
  set(${variable} ${left} PARENT_SCOPE)
endfunction()

# octavo_unity(TARGET [COUNT]): compiles so many sources at a time, where that is asked for; if
# nothing is said about 30, at most 36, and no small rest, as three of them cost what ten do. Names
# in anonymous namespaces are unique within the target.
function(octavo_unity target)
  set(count ${ARGN})
  if(NOT count)
    get_target_property(sources ${target} SOURCES)
    list(LENGTH sources length)
    math(EXPR batches "(${length} + 35) / 36")
    math(EXPR count "(${length} + ${batches} - 1) / ${batches}")
  endif()
  set_target_properties(${target} PROPERTIES
    UNITY_BUILD ${OCTAVO_UNITY} UNITY_BUILD_BATCH_SIZE ${count})
  # GCC takes the sources for headers of the one that lists them. It collects garbage from 128 MiB
  # on, a tenth of its time here; from 512 MiB on it takes up to half more memory, 1.4 GB at most.
  if(OCTAVO_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE
      -Wno-subobject-linkage --param=ggc-min-heapsize=524288)
  endif()
endfunction()

# octavo_module_read(NAME VARIABLE [LIBRARY ...]): takes the sources of the reading half out of
# VARIABLE, which gets their objects instead. octavo::read has the same ones, so that each is
# compiled once.
function(octavo_module_read name variable)
  list(TRANSFORM ${variable} PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE sources)
  set(shared)
  set(others)
  foreach(source ${sources})
    if(source IN_LIST OCTAVO_READ_SOURCES)
      list(APPEND shared ${source})
    else()
      list(APPEND others ${source})
    endif()
  endforeach()
  octavo_take_small(octavo_${name}_read ${name} shared)
  octavo_take_small(octavo_${name} ${name} others ${ARGN})
  list(APPEND others ${octavo_${name}_read_small_objects} ${octavo_${name}_small_objects})
  if(shared)
    add_library(octavo_${name}_read OBJECT ${shared})
    target_include_directories(octavo_${name}_read PRIVATE ${CMAKE_SOURCE_DIR}/src)
    target_link_libraries(octavo_${name}_read PRIVATE octavo_flags)
    octavo_unity(octavo_${name}_read)
    octavo_optimized(octavo_${name}_read ${name})
    list(APPEND others $<TARGET_OBJECTS:octavo_${name}_read>)
  endif()
  set(${variable} ${others} PARENT_SCOPE)
endfunction()

# octavo_module(NAME SOURCES a.cpp ... [USES octavo_core ...] [LINKS TBB::tbb ...])
# Others see the library as octavo::NAME, in this build and after installation.
function(octavo_module name)
  cmake_parse_arguments(arg "" "" "SOURCES;USES;LINKS" ${ARGN})
  octavo_module_read(${name} arg_SOURCES ${arg_USES} ${arg_LINKS})
  add_library(octavo_${name} STATIC ${arg_SOURCES})
  target_include_directories(octavo_${name} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/src> $<INSTALL_INTERFACE:include>)
  target_link_libraries(octavo_${name}
    PUBLIC ${arg_USES} PRIVATE $<BUILD_INTERFACE:octavo_flags> ${arg_LINKS})
  target_compile_features(octavo_${name} PUBLIC cxx_std_20)
  set_target_properties(octavo_${name} PROPERTIES EXPORT_NAME ${name})
  octavo_unity(octavo_${name})
  octavo_optimized(octavo_${name} ${name})
  add_library(octavo::${name} ALIAS octavo_${name})
  install(TARGETS octavo_${name} EXPORT octavoTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
endfunction()

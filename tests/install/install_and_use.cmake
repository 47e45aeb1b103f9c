# Run by ctest; see CMakeLists.txt beside it.
set(prefix ${work_folder}/prefix)
file(REMOVE_RECURSE ${work_folder})
file(MAKE_DIRECTORY ${work_folder})

function(run)
  execute_process(COMMAND ${ARGN}
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nended with ${result}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install ${build_folder} --prefix ${prefix})
foreach(example read_box build_from_array measure_mask)
  set(folder ${work_folder}/${example})
  run(${CMAKE_COMMAND} -G Ninja -S ${source_folder}/examples/${example} -B ${folder}
    -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_CXX_COMPILER=${compiler} "-DCMAKE_CXX_FLAGS=${flags}"
    -D CMAKE_BUILD_TYPE=Release)
  run(${CMAKE_COMMAND} --build ${folder})
endforeach()

function(expect words)
  if(NOT output MATCHES "${words}")
    message(FATAL_ERROR "expected ${words}, found: ${output}")
  endif()
endfunction()

# What is loaded when it is needed is where the program looks for it, and does not start with it.
run(readelf -d ${prefix}/bin/octavo)
expect("\\$ORIGIN/\\.\\./[a-z0-9_/-]+/octavo\\]")
if(output MATCHES "libgdcm|octavo_gdcm|libcurl")
  message(FATAL_ERROR "loaded at the start:\n${output}")
endif()
run(${prefix}/bin/octavo phantom --size 64 -o ${work_folder}/phantom.8vo)
run(${work_folder}/read_box/read_box ${work_folder}/phantom.8vo)
expect("^32768 voxels from ")

run(${work_folder}/build_from_array/build_from_array ${work_folder}/ball.8vo)
expect("^524288 bytes of voxels in a file of ")
run(${prefix}/bin/octavo verify ${work_folder}/ball.8vo)

run(${work_folder}/measure_mask/measure_mask
  ${work_folder}/ball.8vo 0 ${work_folder}/mask.8vo ${work_folder}/labels.8vo)
expect("^1 parts, 1 kept\nlabel 1: 57747 voxels, 7218[.]38 mm3\n$")

foreach(file share/man/man1/octavo.1 share/man/man1/octavo-build.1
    share/bash-completion/completions/octavo share/zsh/site-functions/_octavo
    share/fish/vendor_completions.d/octavo.fish
    share/doc/octavo/format-labels.md share/doc/octavo/label_start_weights.inc)
  if(NOT EXISTS ${prefix}/${file})
    message(FATAL_ERROR "not installed: ${file}")
  endif()
endforeach()
foreach(file share/man/man1/octavo-mpi.1 share/man/man1/octavo-mpi-build.1
    share/bash-completion/completions/octavo-mpi share/zsh/site-functions/_octavo-mpi
    share/fish/vendor_completions.d/octavo-mpi.fish)
  if(EXISTS ${prefix}/bin/octavo-mpi AND NOT EXISTS ${prefix}/${file})
    message(FATAL_ERROR "not installed: ${file}")
  endif()
endforeach()

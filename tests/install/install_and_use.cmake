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
run(${CMAKE_COMMAND} -G Ninja -S ${source_folder}/examples/read_box -B ${work_folder}/example
  -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_CXX_COMPILER=${compiler} "-DCMAKE_CXX_FLAGS=${flags}"
  -D CMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${work_folder}/example)

run(${prefix}/bin/octavo phantom --size 64 -o ${work_folder}/phantom.8vo)
run(${work_folder}/example/read_box ${work_folder}/phantom.8vo)
if(NOT output MATCHES "^32768 voxels from ")
  message(FATAL_ERROR "read_box printed: ${output}")
endif()

foreach(file share/man/man1/octavo.1 share/man/man1/octavo-build.1
    share/bash-completion/completions/octavo share/zsh/site-functions/_octavo
    share/fish/vendor_completions.d/octavo.fish)
  if(NOT EXISTS ${prefix}/${file})
    message(FATAL_ERROR "not installed: ${file}")
  endif()
endforeach()

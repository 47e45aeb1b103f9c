# octavo::octavo, the library as one target, and what `cmake --install` puts where.

include(CMakePackageConfigHelpers)

# The program is the target `octavo`, so the library's own name differs until it is exported.
add_library(octavo_library INTERFACE)
set_target_properties(octavo_library PROPERTIES EXPORT_NAME octavo)
foreach(module core octree planes codec file builder dist io ops render mesh tasks)
  if(TARGET octavo_${module})
    target_link_libraries(octavo_library INTERFACE octavo_${module})
  endif()
endforeach()
add_library(octavo::octavo ALIAS octavo_library)

# What a static library of ours needs where it is linked.
set(OCTAVO_DEPENDENCIES Threads TBB TIFF PNG Freetype ZLIB OpenSSL GDCM fmt meshoptimizer)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/octavo)
install(TARGETS octavo_library EXPORT octavoTargets)
install(EXPORT octavoTargets NAMESPACE octavo:: DESTINATION ${package_folder})
install(EXPORT octavoReadTargets NAMESPACE octavo:: DESTINATION ${package_folder})
install(FILES
  ${CMAKE_SOURCE_DIR}/docs/format.md ${CMAKE_SOURCE_DIR}/docs/format-grey.md
  ${CMAKE_SOURCE_DIR}/docs/format-labels.md ${CMAKE_SOURCE_DIR}/docs/registry.md
  ${CMAKE_SOURCE_DIR}/src/octavo/codec/label/label_start_weights.inc
  DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY ${CMAKE_SOURCE_DIR}/src/octavo DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.h")
if(TARGET octavo-mpi)
  install(TARGETS octavo-mpi RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
if(TARGET octavo)
  install(TARGETS octavo RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  if(NOT CMAKE_CROSSCOMPILING)
    set(pages ${CMAKE_BINARY_DIR}/share)
    # The page of the viewer, which tools/build_web puts there.
    install(DIRECTORY ${pages}/octavo/web DESTINATION ${CMAKE_INSTALL_DATADIR}/octavo OPTIONAL)
    install(DIRECTORY ${pages}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
    set(completed octavo)
    if(TARGET octavo-mpi)
      list(APPEND completed octavo-mpi)
    endif()
    foreach(program ${completed})
      install(FILES ${pages}/completion/${program}
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
      install(FILES ${pages}/completion/_${program}
        DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
      install(FILES ${pages}/completion/${program}.fish
        DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
    endforeach()
  endif()
endif()

configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/octavoConfig.cmake.in
  ${CMAKE_BINARY_DIR}/octavoConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/octavoConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/octavoConfig.cmake ${CMAKE_BINARY_DIR}/octavoConfigVersion.cmake
  DESTINATION ${package_folder})

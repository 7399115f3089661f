# What `cmake --install` puts where: the program, the libraries with their public headers, and how others find them (docs/library.md).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# From above to below, as the linker wants them; the tracker's folder is called by its work.
set(libraries pipeline connect smooth calibrate corner ceiling overhead estimate ranging observation imaging site geometry base)
set_target_properties(roomfix_usage PROPERTIES EXPORT_NAME usage)
set(targets roomfix_usage)
set(archives "")
foreach(library ${libraries})
  set_target_properties(roomfix_${library} PROPERTIES EXPORT_NAME ${library})
  list(APPEND targets roomfix_${library})
  string(APPEND archives " -lroomfix_${library}")
endforeach()
set_target_properties(roomfix_estimate PROPERTIES EXPORT_NAME tracker)
install(TARGETS ${targets} EXPORT roomfix-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)

# Public headers: these, and what they include. Everything else may change at any time.
set(public_headers base/worker_pool connect/frame_source imaging/load_luma pipeline/background_source pipeline/fix_file pipeline/page_sink pipeline/replay pipeline/single_shot
                   pipeline/source_runner site/load_site site/site_text)
set(pending "")
foreach(header ${public_headers})
  list(APPEND pending roomfix/${header}.hpp)
endforeach()
set(installed "")
while(pending)
  list(POP_FRONT pending header)
  if(NOT header IN_LIST installed)
    list(APPEND installed ${header})
    file(STRINGS ${PROJECT_SOURCE_DIR}/src/${header} lines REGEX "^#include \"roomfix/")
    foreach(line ${lines})
      string(REGEX REPLACE "^#include \"(.*)\".*" "\\1" included "${line}")
      list(APPEND pending ${included})
    endforeach()
  endif()
endwhile()
foreach(header ${installed})
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${PROJECT_SOURCE_DIR}/src/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder} COMPONENT development)
endforeach()
install(FILES ${PROJECT_BINARY_DIR}/include/roomfix/version.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/roomfix COMPONENT development)

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/roomfix)
install(EXPORT roomfix-targets NAMESPACE roomfix:: DESTINATION ${package} COMPONENT development)
configure_package_config_file(cmake/roomfix-config.cmake.in roomfix-config.cmake INSTALL_DESTINATION ${package})
# Before 1.0 a new minor version may change what is public.
write_basic_package_version_file(roomfix-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/roomfix-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/roomfix-config-version.cmake cmake/opencv.cmake
        DESTINATION ${package} COMPONENT development)

set(opencv_archives "")
foreach(module aruco calib3d videoio imgcodecs imgproc core)
  if(TARGET roomfix_opencv::${module})
    string(APPEND opencv_archives " -lopencv_${module}")
  endif()
endforeach()
set(optional_requirements "")
if(ROOMFIX_MOSQUITTO_FOUND)
  string(APPEND optional_requirements " libmosquitto")
endif()
file(RELATIVE_PATH up /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)  # so that an installed tree may be moved
configure_file(cmake/roomfix.pc.in roomfix.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/roomfix.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

install(TARGETS roomfix RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)

# Manual pages, where help2man makes them of the program's own help (target `man`).
find_program(HELP2MAN help2man)
if(HELP2MAN)
  add_custom_target(man COMMAND ${PROJECT_SOURCE_DIR}/packaging/man_pages.sh $<TARGET_FILE:roomfix> ${PROJECT_BINARY_DIR}/man DEPENDS roomfix VERBATIM)
endif()
install(DIRECTORY ${PROJECT_BINARY_DIR}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program OPTIONAL)

# What roomfix connects to by libraries that it can do without: each is an option, on where its library is found. Without it the site file's output of that
# kind is an error that says so.
set(roomfix_connections "")      # those that are built
set(roomfix_connection_packages "")  # their pkg-config modules

# roomfix_connection(NAME MODULE DEBIAN_PACKAGE WHAT): option ROOMFIX_NAME; where it is on and found, PkgConfig::ROOMFIX_NAME.
macro(roomfix_connection name module package what)
  option(ROOMFIX_${name} "${what}, where ${module} is found" ON)
  if(ROOMFIX_${name})
    pkg_check_modules(ROOMFIX_${name} QUIET IMPORTED_TARGET GLOBAL ${module})
    if(ROOMFIX_${name}_FOUND)
      list(APPEND roomfix_connections ${name})
      string(REGEX REPLACE "[<>=].*" "" bare ${module})
      string(APPEND roomfix_connection_packages " ${bare}")
    else()
      message(STATUS "${module} was not found: built without ${what} (${package})")
    endif()
  endif()
endmacro()

roomfix_connection(MQTT libmosquitto>=2 libmosquitto-dev "MQTT")
roomfix_connection(FOXGLOVE libwebsockets>=4.1 libwebsockets-dev "Foxglove's server")
roomfix_connection(POSTGRESQL libpqxx>=6 libpqxx-dev "a history in PostgreSQL")

# Fast DDS comes with CMake's files only.
option(ROOMFIX_ROS2 "ROS 2 topics over DDS, where Fast DDS is found" ON)
if(ROOMFIX_ROS2)
  find_package(fastrtps 2.9 QUIET)
  if(fastrtps_FOUND)
    list(APPEND roomfix_connections ROS2)
  else()
    message(STATUS "Fast DDS was not found: built without ROS 2 topics (libfastrtps-dev)")
  endif()
endif()

# The library `target` gets ROOMFIX_WITH_NAME and what it needs for each.
function(roomfix_link_connections target)
  foreach(name ${roomfix_connections})
    target_compile_definitions(${target} PRIVATE ROOMFIX_WITH_${name})
    if(name STREQUAL "ROS2")
      target_link_libraries(${target} PRIVATE fastrtps)
    else()
      target_link_libraries(${target} PRIVATE PkgConfig::ROOMFIX_${name})
    endif()
  endforeach()
endfunction()

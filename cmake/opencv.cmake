# OpenCV's modules as imported targets. Debian's OpenCVConfig.cmake comes only with libopencv-dev, which pulls in every
# module and VTK; the few modules used here have packages of their own. aruco has none and may be missing. The names are
# ours, so that whoever uses OpenCV's own configuration beside this has no clash.
find_path(OPENCV_INCLUDE opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
function(opencv_module name)
  find_library(OPENCV_${name}_LIBRARY opencv_${name} REQUIRED)
  if(TARGET roomfix_opencv::${name})
    return()
  endif()
  add_library(roomfix_opencv::${name} UNKNOWN IMPORTED GLOBAL)
  set_target_properties(roomfix_opencv::${name} PROPERTIES IMPORTED_LOCATION ${OPENCV_${name}_LIBRARY}
                        INTERFACE_INCLUDE_DIRECTORIES ${OPENCV_INCLUDE})
endfunction()
function(opencv_module_if_found name)
  find_library(OPENCV_${name}_LIBRARY opencv_${name})
  if(OPENCV_${name}_LIBRARY)
    opencv_module(${name})
  else()
    message(STATUS "OpenCV's ${name} module was not found: built without what needs it")
  endif()
endfunction()

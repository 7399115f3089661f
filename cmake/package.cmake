# Debian packages: `./dev package`. The program, what is needed to build against the library, and the Python module.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME roomfix)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "roomfix developers <developers@roomfix.invalid>")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program development)
if(TARGET roomfix_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME roomfix)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "finds robots indoors with ordinary cameras
 Cameras on the wall or on the robot, ultrasonic or radio ranges and wheel
 odometry become one pose per robot with an honest covariance, on a map in the
 browser or in a file.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libroomfix-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
string(JOIN ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS libeigen3-dev libceres-dev libopencv-core-dev libopencv-imgproc-dev libopencv-imgcodecs-dev
       libopencv-calib3d-dev libopencv-videoio-dev libopencv-contrib-dev libhwy-dev libjpeg62-turbo-dev libyaml-cpp-dev libfmt-dev libcpp-httplib-dev libssl-dev
       libapriltag-dev libassimp-dev libtinyxml2-dev libmosquitto-dev libwebsockets-dev libavformat-dev libavcodec-dev libavutil-dev libsqlite3-dev libpqxx-dev libfastrtps-dev)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "roomfix as a C++ library
 Static libraries, public headers, and what CMake and pkg-config need to find
 them.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-roomfix)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "roomfix as a Python module
 Sites, single pictures as numpy arrays, the tracker, recorded sessions.")
include(CPack)

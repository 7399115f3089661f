# What nearly every file includes is read once and not once per file: two thirds of a build went into reading Eigen and our own geometry again and again.
# No file relies on it: the presets debug and lint do without, so that each file must include what it uses.
set(standard_headers <algorithm> <array> <atomic> <cmath> <cstdint> <deque> <filesystem> <fstream> <functional> <map> <memory> <mutex> <numbers> <numeric>
                     <optional> <set> <span> <sstream> <string> <string_view> <thread> <utility> <variant> <vector>
                     <Eigen/Core> <Eigen/Geometry> <fmt/format.h> ${PROJECT_SOURCE_DIR}/src/roomfix/base/decompositions.hpp)
set(site_headers ${standard_headers} ${PROJECT_SOURCE_DIR}/src/roomfix/geometry/view.hpp ${PROJECT_SOURCE_DIR}/src/roomfix/observation/fix.hpp
                 ${PROJECT_SOURCE_DIR}/src/roomfix/site/site.hpp)

# A target that others name in `target_precompile_headers(... REUSE_FROM ...)`; they must be compiled with the same options.
function(roomfix_precompiled name)
  cmake_parse_arguments(ARG "" "" "HEADERS;USES;OPTIONS" ${ARGN})
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp "// Empty: this library is its precompiled header.\n")
  add_library(${name} STATIC ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PUBLIC roomfix_options ${ARG_USES})
  target_compile_options(${name} PRIVATE ${ARG_OPTIONS})
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
endfunction()

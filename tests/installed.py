"""Installs the built program and library into an empty folder and builds the examples in examples/cpp against it, outside the source tree: by CMake,
by pkg-config, and as a subdirectory of another project. Usage: installed.py BUILD_FOLDER"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

build = pathlib.Path(sys.argv[1]).resolve()
source = pathlib.Path(__file__).resolve().parents[1]


def run(*command, **more):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **more)
    if done.returncode != 0:
        sys.exit(f"failed: {' '.join(str(word) for word in command)}\n{done.stdout}\n{done.stderr}")
    return done.stdout


def check(holds, what, output):
    if not holds:
        sys.exit(f"{what}\n{output}")


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    prefix = folder / "usr"
    run("cmake", "--install", build, "--prefix", prefix)
    library = next(prefix.glob("lib/**/libroomfix_pipeline.a")).parent
    check(not (prefix / "include/roomfix/estimate/tracker.hpp").exists(), "a private header was installed", "")

    shutil.copytree(source / "examples/cpp", folder / "cpp")
    run("cmake", "-S", folder / "cpp", "-B", folder / "out", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_CXX_FLAGS=-march=native")
    run("cmake", "--build", folder / "out")

    program = prefix / "bin/roomfix"
    session = folder / "session"
    run(program, "simulate", "li2014", "-o", session, "--duration", "2")
    fixes = run(folder / "out/own_source_and_sink", session).splitlines()
    check(fixes[0] == "time,robot,x,y,yaw" and len(fixes) > 5, "the own source and sink gave too few fixes", fixes)
    camera = sorted((session / "frames").iterdir())[0].name
    pictures = sorted((session / "frames" / camera).iterdir())
    found = run(folder / "out/find_robots", session, camera, *pictures[:3])
    check(" one sigma " in found, "no robot was found in the pictures", found)
    tracked = run(folder / "out/feed_tracker").splitlines()
    last = tracked[-1].split()
    # The circle's last point is 4 + 1.5 cos 8.97, 3 + 1.5 sin 8.97.
    check(abs(float(last[4]) - 2.650) < 0.1 and abs(float(last[5]) - 3.655) < 0.1, "the fed tracker is not where the robot is", tracked[-1])

    flags = run("pkg-config", "--cflags", "--libs", "roomfix", env={**os.environ, "PKG_CONFIG_PATH": str(library / "pkgconfig")}).split()
    run("g++", "-std=c++20", folder / "cpp/feed_tracker.cpp", "-o", folder / "by_pkg_config", *flags)
    check(run(folder / "by_pkg_config").splitlines() == tracked, "the two builds differ", "")

    inside = folder / "inside"
    inside.mkdir()
    (inside / "main.cpp").write_text('#include <roomfix/version.hpp>\nint main() { return roomfix::version_major; }\n')
    (inside / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.25)\nproject(inside LANGUAGES CXX)\nset(ROOMFIX_PAGE OFF)\n"
        f"add_subdirectory({source} roomfix)\nadd_executable(inside main.cpp)\ntarget_link_libraries(inside PRIVATE roomfix::pipeline)\n"
        "get_target_property(options roomfix_usage INTERFACE_COMPILE_OPTIONS)\n"
        'if(options)\n  message(FATAL_ERROR "flags are forced on others: ${options}")\nendif()\n')
    run("cmake", "-S", inside, "-B", folder / "inside_out", "-G", "Ninja")
print("installed, and used by CMake, by pkg-config and as a subdirectory")

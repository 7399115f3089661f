#!/usr/bin/env bash
# arm64_root.sh FOLDER PACKAGE...: unpacks Debian packages for 64-bit ARM, and all that they need, into FOLDER. Installs nothing on this machine and needs
# no root: apt is told of another machine on which nothing is installed yet.
set -euo pipefail
root=$(realpath -m "$1")
shift
apt=$root/.apt
if [ -e "$root/.unpacked" ] && [ "$(cat "$root/.unpacked")" = "$*" ]; then exit; fi
echo "arm64_root.sh: fetching Debian's arm64 packages into $root" >&2
mkdir -p "$apt/state/lists/partial" "$apt/cache/archives/partial"
touch "$apt/state/status"
cat >"$apt/apt.conf" <<END
APT::Architecture "arm64";
APT::Architectures { "arm64"; };
APT::Install-Recommends "false";
APT::Sandbox::User "$(id -un)";
Dir::State "$apt/state";
Dir::State::status "$apt/state/status";
Dir::Cache "$apt/cache";
Debug::NoLocking "true";
END
export APT_CONFIG=$apt/apt.conf
apt-get update -qq
apt-get install -qq --download-only -y "$@" >/dev/null
for package in "$apt"/cache/archives/*.deb; do dpkg-deb -x "$package" "$root"; done
# Links that begin at the root of a file system begin at this one.
find "$root" -type l -lname '/*' | while read -r link; do ln -sfn "$(realpath -m --relative-to="$(dirname "$link")" "$root$(readlink "$link")")" "$link"; done
# What update-alternatives would have linked, from whichever package brought them.
libraries=$root/usr/lib/aarch64-linux-gnu
for file in "$libraries"/*/libblas.so* "$libraries"/*/liblapack.so*; do
    if [ -e "$file" ]; then ln -sf "$(realpath --relative-to="$libraries" "$file")" "$libraries/$(basename "$file")"; fi
done
# Some packages' CMake files know only where they would have been installed.
find "$libraries/cmake" -name '*.cmake' -exec sed -i -E \
    "s#(_PREFIX|_PREFIX_DIR) \"/usr\"#\1 \"$root/usr\"#; s#([\"; ])/usr/lib/aarch64#\1$root/usr/lib/aarch64#g" {} +
rm -rf "$apt"
echo "$*" >"$root/.unpacked"

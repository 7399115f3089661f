#!/usr/bin/env bash
# arm64_root.sh FOLDER PACKAGE...: unpacks Debian packages for 64-bit ARM, and all that they need, into FOLDER. Installs nothing on this machine and needs
# no root: apt is told of another machine on which nothing is installed yet.
set -euo pipefail
root=$(realpath -m "$1")
shift
apt=$root/.apt
if [ -e "$root/.unpacked" ] && [ "$(cat "$root/.unpacked")" = "$*" ]; then exit; fi
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
rm -rf "$apt"
echo "$*" >"$root/.unpacked"

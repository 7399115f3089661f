#!/usr/bin/env bash
# Manual pages from the program's own help: man_pages.sh PROGRAM FOLDER
set -euo pipefail
program=$1 folder=$2
mkdir -p "$folder"
version=$("$program" --version)
page() {  # page NAME SHORT HELP-OPTIONS
    help2man --no-info --section 1 --version-string "${version#roomfix }" --help-option "$3" --name "$2" --output "$folder/$1.1" "$program"
}
page roomfix "finds robots indoors with ordinary cameras" --help
for command in demo run replay evaluate export fix simulate reproduce calibrate check cameras doctor init; do
    short=$("$program" "$command" --help | head -n 1)
    page "roomfix-$command" "$short" "$command --help"
done

"""Checks that each folder of src/roomfix includes only what stands below it."""
import pathlib
import re
import sys

# From the bottom up. The observers stand side by side and do not know each other.
below = {
    "base": [],
    "geometry": ["base"],
    "imaging": ["base", "geometry"],
    "site": ["base", "geometry"],
    "observation": ["base", "geometry", "site"],
    "ranging": ["base", "geometry", "site", "observation"],
    "ceiling": ["base", "geometry", "imaging", "site", "observation"],
    "corner": ["base", "geometry", "imaging", "site", "observation"],
    "overhead": ["base", "geometry", "imaging", "site", "observation"],
    "estimate": ["base", "geometry", "site", "observation"],
    "smooth": ["base", "geometry", "site", "observation", "estimate"],
    "simulate": ["base", "geometry", "imaging", "site", "observation", "overhead", "ceiling"],
    "calibrate": ["base", "geometry", "imaging", "site", "observation", "overhead", "ceiling", "estimate"],
    "evaluate": ["base", "geometry", "imaging", "site", "observation", "overhead", "ceiling", "corner", "ranging", "estimate", "smooth", "simulate", "calibrate"],
    "connect": ["base", "geometry", "imaging", "site", "observation", "ranging"],
    "pipeline": ["base", "geometry", "imaging", "site", "observation", "overhead", "ceiling", "corner", "ranging", "estimate", "smooth", "calibrate", "connect"],
}
root = pathlib.Path(sys.argv[1])
wrong = []
for file in sorted(root.rglob("*.[ch]pp")):
    folder = file.relative_to(root).parts[0]
    for target in re.findall(r'#include "roomfix/([a-z]+)/', file.read_text()):
        if target != folder and target not in below[folder]:
            wrong.append(f"{file}: {folder}/ must not include {target}/")
print("\n".join(wrong) or f"{len(below)} folders: every include points down")
sys.exit(bool(wrong))

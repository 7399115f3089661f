"""Validates the example sites against docs/site.schema.json, and checks that the schema refuses wrong ones."""
import json
import pathlib
import sys

import jsonschema
import yaml

root = pathlib.Path(sys.argv[1])
schema = json.loads((root / "docs/site.schema.json").read_text())
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)
failures = 0
examples = sorted((root / "examples").rglob("site.yaml"))
assert examples, "no example sites found"
for file in examples:
    for error in validator.iter_errors(yaml.safe_load(file.read_text())):
        print(f"{file}: {error.message}")
        failures += 1
good = yaml.safe_load(examples[0].read_text())
for breakage in (
    lambda s: s.update(roomfix=2),
    lambda s: s.update(camera={}),
    lambda s: next(iter(s["cameras"].values())).pop("size"),
    lambda s: next(iter(s["cameras"].values())).update(height=1.0),
    lambda s: next(iter(s["robots"].values())).update(shape="ball"),
    lambda s: s["robots"].update(r={}),
    lambda s: s["robots"].update(r={"parts": [{"box": [1, 1, 1]}]}),
    lambda s: s["robots"].update(r={"model": "cart.jpg"}),
    lambda s: s["robots"].update(r={"model": "cart.stl", "model_scale": 0}),
    lambda s: s["robots"].update(r={"shape": "box", "size": [1, 1, 1], "model_scale": 0.001}),
    lambda s: s["robots"].update(r={"model": "cart.body", "shape": "box", "size": [1, 1, 1]}),
    lambda s: s["robots"].update(r={"parts": [{"box": [1, 1, 1], "at": [0, 0, 0.5]}], "shape": "box", "size": [1, 1, 1]}),
    lambda s: s.update(plan="plan.png"),
    lambda s: s.update(plan={"image": "plan.png"}),
    lambda s: s.update(outputs={"foxglove": {"operator": {"env": "TOKEN"}}}),
):
    bad = json.loads(json.dumps(good))
    breakage(bad)
    if validator.is_valid(bad):
        print("the schema accepts a site it should refuse")
        failures += 1
for body in (
    {"parts": [{"box": [0.54, 0.1, 0.26], "at": [0, 0.22, 0.13], "yaw_deg": 30}, {"cylinder": [0.1, 0.5], "at": [0, 0, 0.7]}]},
    {"model": "cart.body", "size_sigma": 0.02},
    {"model": "spot/spot.urdf"},
    {"model": "cart.STL", "model_scale": 0.001, "count": "many"},
    {"parts": [{"points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}], "count": "many"},
):
    fine = json.loads(json.dumps(good))
    fine["robots"]["r"] = body
    for error in validator.iter_errors(fine):
        print(f"the schema refuses {body}: {error.message}")
        failures += 1
for part in ({"plan": "maps/hall.yaml"}, {"plan": {"image": "plan.png", "resolution": 0.05, "origin": [-1, 2.5, 90]}},
             {"outputs": {"web": {"token": {"file": "token"}, "operator": {"env": "TOKEN"}}}}):
    for error in validator.iter_errors({**good, **part}):
        print(f"the schema refuses {part}: {error.message}")
        failures += 1
print(f"{len(examples)} example(s), {failures} failure(s)")
sys.exit(failures > 0)

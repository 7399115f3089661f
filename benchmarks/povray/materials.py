"""Colours and finishes in POV-Ray's words. Colours are linear light."""
import colorsys


def rgb(colour):
    return "rgb <" + ",".join(f"{c:.4f}" for c in colour) + ">"


def linear(hue, saturation, value):
    return tuple(c**2.2 for c in colorsys.hsv_to_rgb(hue % 1, saturation, value))


def any_colour(rng, dark=0.08, bright=0.95):
    """From grey to vivid."""
    saturation = rng.uniform(0, 0.1) if rng.random() < 0.45 else rng.uniform(0.2, 0.95)
    return linear(rng.random(), saturation, rng.uniform(dark, bright))


def muted(rng, dark, bright, most=0.25):
    return linear(rng.choice([0.06, 0.09, 0.12, 0.6]) + rng.normal(0, 0.02), rng.uniform(0, most), rng.uniform(dark, bright))


def paint(colour, kind="matte"):
    """Texture of one colour: matte, plastic, gloss (reflects a little) or metal."""
    finish = {"matte": "diffuse 0.85",
              "plastic": "diffuse 0.75 specular 0.25 roughness 0.03",
              "gloss": "diffuse 0.7 specular 0.5 roughness 0.008 reflection { 0.02, 0.2 fresnel on } conserve_energy",
              "metal": "diffuse 0.5 metallic specular 0.6 roughness 0.03 reflection { 0.15 metallic }"}[kind]
    return f"texture {{ pigment {{ {rgb(colour)} }} finish {{ {finish} }} }}" + (" interior { ior 1.5 }" if kind == "gloss" else "")


def any_paint(rng, colour=None):
    return paint(any_colour(rng) if colour is None else colour, rng.choice(["matte", "plastic", "plastic", "gloss", "metal"], p=[0.35, 0.25, 0.2, 0.12, 0.08]))


mask_paint = "texture { pigment { rgb <1,0,0> } finish { ambient 0 diffuse 0 emission 1 } }"
dark_paint = paint((0.02, 0.02, 0.022))

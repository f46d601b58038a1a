"""Effects that the library lacks, each as a law of one's own: its name, its stage, the expression, the parameters with their
values and units, and the quantities that it depends on."""

CASES = [
    (
        "teeth of a drive",
        "sensor",
        "size * sin(2 * PI * x / pitch + phase)",
        {"size": (0.04, "N"), "pitch": (0.8, "mm"), "phase": (1.0, "")},
        {"x"},
    ),
    (
        "a strut that gives way",
        "contact",
        "-size / (1 + exp(-(x - place) / width))",
        {"size": (0.3, "N"), "place": (5.2, "mm"), "width": (0.15, "mm")},
        {"x"},
    ),
    (
        "a rail that rubs at one place",
        "contact",
        "size * exp(-((x - place) / width)^2) * sign(v)",
        {"size": (0.2, "N"), "place": (3.0, "mm"), "width": (0.4, "mm")},
        {"x", "v"},
    ),
    (
        "a drive that drags at one speed",
        "sensor",
        "size * exp(-((abs(v) - speed) / width)^2)",
        {"size": (0.3, "N"), "speed": (5.0, "mm/s"), "width": (1.5, "mm/s")},
        {"v"},
    ),
]


def model(case, base):
    """The base law of `base`, the text of a model file, with this effect."""
    _, stage, expression, parameters, _ = case
    lines = ["", "[[effect]]", 'name = "hidden"', f'stage = "{stage}"', f'expression = "{expression}"']
    for name, (value, unit) in parameters.items():
        lines += [f"[effect.parameters.{name}]", f"value = {value}", f'unit = "{unit}"']
    return base + "\n".join(lines) + "\n"

#!/usr/bin/env python3
"""Living washes in float64, the truth against which Girtin's engines are held.

    python3 fidelity/wash/make_living_goldens.py            # makes every case anew
    python3 fidelity/wash/make_living_goldens.py --check    # runs the stored starts again and compares

The physics is living.py. A case is a folder `living-…` like those of make_goldens.py; its states have the numbers of a
living wash besides, and are stored in float32, whose last digit is a thousandth of the tolerance they are held to.

Decisions taken by the last bits of a number (a sub-step more, a cell wet or dry) would be taken otherwise in float32,
and no tolerance would help. So a case is run again from starts that differ by NOISE, and unless every decision is the
same and every field within STRAY the next seed is tried. Needs Python 3.11, NumPy and Numba.
"""

import itertools
import json
import sys
import tomllib

import numpy as np
from living import LIVING, WashX, arguments
from make_goldens import HERE, PIGMENTS, STEPS, disc, ragged, swirl, waves

# Ten times the last digit of float32.
NOISE = 1e-6
STRAY = 3e-5
FIELDS = {"u": "u", "v": "v", "pressure": "p", "saturation": "s", "suspended": "g", "deposited": "d"}

DEFAULTS = {
    "compressibility": 0.4,
    "viscosity": 0.00625,
    "viscous_drag": 0.01,
    "slope_scale": 0.3,
    "slope_band": 0.25,
    "speed_limit": 0.25,
    "flowing_film": 0.15,
    "least_mobility": 0.1,
    "pigment_diffusion": 0.001875,
    "pigment_dispersion": 0.0375,
    "packing_limit": 1.2,
    "edge_darkening": 0.02,
    "edge_width": 2.5,
    "evaporation": 0.002,
    "pore_evaporation": 0.0004,
    "pore_depth": 0.3,
    "rim_exponent": 4,
    "settling": 0.1,
    "lifting": 4.0,
    "absorption": 0.02,
    "min_diffusing": 0.05,
    "min_receiving": 0.02,
    "capacity": [0.3, 0.9],
    "wetting_film": 0.06,
    "drying_film": 0.01,
    "pinning": 2.0,
    "pin_roughness": 0.5,
    "creep_speed": 0.0625,
    "creep_share": 0.5,
    "tilt": 0.0,
    "tilt_toward": 90.0,
}


def start(rng, rows, columns, wet, pigments, film, damp, r, speed=0.2):
    """A state with something in every field; `damp` is how full the pores are, 0 to 1."""
    shape = (rows, columns)
    wet = np.broadcast_to(np.asarray(wet), shape).astype(bool)
    # Water on its way, though no faster than its film lets it.
    u, v = swirl(rng, *shape, speed * r, 24 * r, 10 * r)
    height = 0.5 + 0.35 * waves(rng, *shape, 9 * r, 3 * r) + rng.uniform(-0.1, 0.1, shape)
    height = np.clip(height, 0.02, 0.98)
    film = film * np.clip(1.0 + 0.8 * waves(rng, *shape, 20 * r, 8 * r), 0.0, None)
    damp = np.clip(damp + 0.3 * waves(rng, *shape, 18 * r, 8 * r), 0.0, 1.0)
    # Paint lies on dry paper too: that must stay as it is.
    return {
        "wet_mask": wet,
        "height": height,
        "u": u,
        "v": v,
        "pressure": np.where(wet, film, 0.0),
        "saturation": damp * (0.3 + 0.6 * height),
        "suspended": rng.uniform(0.0, 0.7, (pigments, *shape)) * wet,
        "deposited": rng.uniform(0.0, 0.5, (pigments, *shape)),
    }


def cases():
    """Name, why, cells a reference cell, start by its random numbers, pigments, changed parameters."""

    def one_cell(rng):
        return start(rng, 1, 1, 1, 1, 0.4, 0.3, 1)

    yield "one-cell", "Every neighbour lies outside the canvas.", 1, one_cell, ["french-ultramarine"], {}

    def one_row(rng):
        wet = np.ones((1, 40))
        wet[0, [3, 11, 12, 30]] = 0
        return start(rng, 1, 40, wet, 2, 0.5, 0.5, 1)

    yield "one-row", "No face has a neighbour above or below.", 1, one_row, ["burnt-umber", "cerulean-blue"], {}

    def damp_paper(rng):
        return start(rng, 40, 48, ragged(rng, 40, 48, 0.5), 1, 0.4, 0.6, 1)

    yield "damp-paper", "Ragged blobs on damp paper.", 1, damp_paper, ["french-ultramarine"], {}

    def three_pigments(rng):
        return start(rng, 44, 48, ragged(rng, 44, 48, 0.6), 3, 0.5, 0.3, 2)

    names = ["quinacridone-rose", "hookers-green", "burnt-umber"]
    yield "three-pigments", "Twice as fine: all that is in millimetres.", 2, three_pigments, names, {}

    def thin_film(rng):
        state = start(rng, 36, 36, ragged(rng, 36, 36, 0.8), 1, 0.05, 0.7, 1, speed=0.02)
        state["pressure"] *= rng.uniform(0.0, 1.0, (36, 36))
        return state

    yield "thin-film", "A film that tears and dries; its pigment settles.", 1, thin_film, ["indian-red"], {}

    def puddle(rng):
        state = start(rng, 48, 48, disc(rng, 48, 48, 12), 1, 0.0, 0.5, 1.5, speed=0.0)
        state["pressure"] = np.where(state["wet_mask"], 2.5 + waves(rng, 48, 48, 18, 9), 0.0)
        return state

    yield (
        "puddle",
        "A deep puddle creeps over damp and dry paper, as fast as water may; one and a half times as fine.",
        1.5,
        puddle,
        ["phthalo-green"],
        {},
    )

    def tilted(rng):
        return start(rng, 40, 40, ragged(rng, 40, 40, 0.6), 1, 0.5, 0.8, 1)

    changed = {"tilt": 25.0, "tilt_toward": 60.0}
    yield "tilt", "The board leans, and water runs down it.", 1, tilted, ["burnt-umber"], changed

    def unusual(rng):
        return start(rng, 40, 40, ragged(rng, 40, 40, 0.5), 2, 0.5, 0.45, 1)

    yield (
        "unusual-parameters",
        "No parameter is its default.",
        1,
        unusual,
        ["quinacridone-rose", "french-ultramarine"],
        {
            "compressibility": 0.3,
            "viscosity": 0.009,
            "viscous_drag": 0.03,
            "slope_scale": 0.5,
            "slope_band": 0.6,
            "speed_limit": 0.1,
            "flowing_film": 0.2,
            "least_mobility": 0.2,
            "pigment_diffusion": 0.003,
            "pigment_dispersion": 0.06,
            "packing_limit": 0.9,
            "edge_darkening": 0.03,
            "edge_width": 3.1,
            "evaporation": 0.004,
            "pore_evaporation": 0.002,
            "pore_depth": 0.4,
            "rim_exponent": 7,
            "settling": 0.2,
            "lifting": 2.0,
            "absorption": 0.03,
            "min_diffusing": 0.2,
            "min_receiving": 0.15,
            "capacity": [0.25, 0.8],
            "wetting_film": 0.04,
            "drying_film": 0.02,
            "pinning": 0.6,
            "pin_roughness": 0.8,
            "creep_speed": 0.09,
            "creep_share": 0.3,
            "tilt": 10.0,
            "tilt_toward": -160.0,
        },
    )


def wash_of(state, settings, noise=None):
    """A wash from a stored start, or from one that differs by some random numbers."""
    jitter = (lambda a: a) if noise is None else lambda a: a * (1.0 + NOISE * noise.uniform(-1.0, 1.0, a.shape))
    handlings = [tomllib.loads((PIGMENTS / f"{name}.toml").read_text()) for name in settings["pigments"]]
    pigments = [tuple(handling[key] for key in ("density", "staining_power", "granulation")) for handling in handlings]
    stored = {key: np.asarray(field, dtype=np.float64) for key, field in state.items()}
    wash = WashX(
        stored["height"],
        stored["wet_mask"] != 0,
        pigments,
        jitter(stored["suspended"]),
        jitter(stored["pressure"]),
        s=jitter(stored["saturation"]),
        r=float(stored["cells_per_mm"]) / 4.0,
        **arguments(settings["living"]),
    )
    wash.d, wash.u, wash.v = (jitter(stored[key]) for key in ("deposited", "u", "v"))
    return wash


def state_of(wash):
    state = {name: getattr(wash, field).astype(np.float32) for name, field in FIELDS.items()}
    numbers = {"cells_per_mm": 4.0 * wash.r, "contact_carry": wash.reach, "evaporated": wash.evaporated, "blotted": 0.0}
    numbers = {name: np.float64(number) for name, number in numbers.items()}
    return {"wet_mask": wash.M.copy(), "height": wash.h.astype(np.float32)} | state | numbers


def run(state, settings, noise=None):
    """The states after STEPS, and the wash."""
    wash = wash_of(state, settings, noise)
    states = {}
    for step in range(1, max(STEPS) + 1):
        wash.step()
        if step in STEPS:
            states[step] = state_of(wash)
    return states, wash


def apart(found, wanted):
    """How far a state is from another: the largest relative error of a field, infinite if a cell is wet in one only."""
    if (found["wet_mask"] != wanted["wet_mask"]).any():
        return np.inf
    return max(
        np.linalg.norm(found[key].astype(float) - wanted[key]) / max(np.linalg.norm(wanted[key].astype(float)), 1e-3)
        for key in FIELDS
    )


def is_steady(state, settings, states, wash):
    for seed in range(4):
        others, other = run(state, settings, np.random.default_rng(seed))
        if other.counts != wash.counts or max(apart(others[step], states[step]) for step in STEPS) > STRAY:
            return False
    return True


def report(name, wash):
    water, sweeps, pigment, wet = (f"{min(c)}..{max(c)}" for c in zip(*wash.counts))
    print(f"{name:28} sub-steps {water} and {pigment}, iterations {sweeps}, wet {wet}")


def toml(why, pigments, parameters):
    # JSON writes words, numbers and lists as TOML does.
    lines = [f"{key} = {json.dumps(value)}" for key, value in parameters.items()]
    head = [f"# {why}", 'model = "living"', f"pigments = {json.dumps(pigments)}", "[living]"]
    return "\n".join([*head, *lines]) + "\n"


def make():
    for name, why, r, begin, pigments, changed in cases():
        folder = HERE / f"living-{name}"
        folder.mkdir(exist_ok=True)
        text = toml(why, pigments, DEFAULTS | changed)
        (folder / "wash.toml").write_text(text)
        settings = tomllib.loads(text)
        for seed in itertools.count(1):
            kinds = {"wet_mask": np.uint8}
            state = {key: a.astype(kinds.get(key, np.float32)) for key, a in begin(np.random.default_rng(seed)).items()}
            state["cells_per_mm"] = np.float64(4.0 * r)
            states, wash = run(state, settings)
            if is_steady(state, settings, states, wash):
                break
        np.savez_compressed(folder / "start.npz", **state)
        for step, after in states.items():
            np.savez_compressed(folder / f"after-{step}.npz", **after)
        report(f"{folder.name}, seed {seed}", wash)


def check():
    made_of = arguments(DEFAULTS)
    for key, value in LIVING.items():
        same = made_of[key] == value if isinstance(value, dict) else np.isclose(made_of[key], value)
        assert same, f"`{key}` is not the default"
    for folder in sorted(HERE.glob("living-*/")):
        with np.load(folder / "start.npz") as state:
            states, wash = run(dict(state), tomllib.loads((folder / "wash.toml").read_text()))
        for step, after in states.items():
            with np.load(folder / f"after-{step}.npz") as stored:
                off = apart(after, stored)
                assert off < 1e-6, f"{folder.name}: after {step} steps {off:.1e} off"
                assert np.isclose(after["evaporated"], stored["evaporated"], rtol=1e-9), folder.name
        report(folder.name, wash)


if __name__ == "__main__":
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(__doc__)
    check() if sys.argv[1:] else make()

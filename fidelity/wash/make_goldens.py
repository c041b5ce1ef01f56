#!/usr/bin/env python3
"""Washes in float64, the truth against which Girtin's engines are held.

    python3 fidelity/wash/make_goldens.py            # makes every case anew
    python3 fidelity/wash/make_goldens.py --check    # runs the stored starts again and compares

This is a second reading of Curtis et al. 1997, §4, with the deviations D1 to D7 of docs/paper-notes.md. It
shares no code with Girtin, has no row kernels, no active regions and no float32, so that a slip would have to
be made twice to go unseen. Needs Python 3.11 and NumPy.

The living wash has its own: make_living_goldens.py. A case is a folder:
  start.npz                                 the state before the first step, float32
  wash.toml                                 model, pigments and every parameter
  after-1.npz, after-10.npz, after-40.npz   the state after so many steps, float64

A simulation takes yes-or-no decisions: how many sub-steps, whether to relax once more, whether a cell becomes
wet. One taken by the last bits of a number would be taken otherwise in float32, and no tolerance would help.
So a case in which any comes closer than MARGIN to its threshold is refused here: give it another seed.
"""

import json
import sys
import tomllib
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
PIGMENTS = HERE.parent.parent / "assets" / "pigments"
STEPS = (1, 10, 40)
FIELDS = ("height", "u", "v", "pressure", "saturation", "suspended", "deposited")
# Ten times what float32 makes of a number near 1 in forty steps.
MARGIN = 1e-5


# The physics. Arrays are [y, x]; u[y, x] is the face before cell x, v[y, x] the one above cell y.


class Wash:
    """A state that runs; `p` are the parameters by their names in wash.toml."""

    def __init__(self, state, p):
        self.wet = np.asarray(state["wet_mask"]) != 0
        for name in FIELDS:
            setattr(self, name, np.array(state[name], dtype=np.float64))
        self.p = p
        handlings = [tomllib.loads((PIGMENTS / f"{name}.toml").read_text()) for name in p["pigments"]]
        self.density, self.staining, self.granulation = (
            np.array([handling[key] for handling in handlings], dtype=np.float64).reshape(-1, 1, 1)
            for key in ("density", "staining_power", "granulation")
        )
        self.margin = np.inf
        self.counts = []  # of each step: sub-steps of water, sweeps, sub-steps of pigment, wet cells

    def state(self):
            return {"wet_mask": self.wet.astype(np.uint8)} | {
            name: getattr(self, name).copy() for name in FIELDS
        }

    def step(self):
        water = self.update_velocities()
        sweeps = self.relax_divergence()
        self.flow_outward()
        pigment = self.move_pigment()
        self.transfer_pigment()
        if "capillary" in self.p:
            self.simulate_capillary_flow(**self.p["capillary"])
        self.counts.append((water, sweeps, pigment, int(self.wet.sum())))

    def decided(self, distance):
        """Notes how far a decision was from falling the other way."""
        self.margin = min(self.margin, float(np.min(np.abs(distance), initial=np.inf)))

    def still(self):
        """D5: nothing flows through faces that touch a dry cell or the rim of the canvas."""
        wet = np.pad(self.wet, 1)
        self.u[~(wet[1:-1, :-1] & wet[1:-1, 1:])] = 0.0
        self.v[~(wet[:-1, 1:-1] & wet[1:, 1:-1])] = 0.0

    def substeps(self, speed):
        """D4."""
        # Below 1 only 1 counts, and there is no other way down.
        self.decided(speed - max(1.0, np.round(speed)))
        return max(1, int(np.ceil(speed)))

    def update_velocities(self):
        """§4.3.1."""
        p, h = self.p, self.height
        self.u[:, 1:-1] -= p["slope_scale"] * np.diff(h, axis=1)  # D7
        self.v[1:-1, :] -= p["slope_scale"] * np.diff(h, axis=0)
        self.still()
        n = self.substeps(max(np.abs(self.u).max(), np.abs(self.v).max()))
        for _ in range(n):
            u, v = self.u, self.v
            u_out, v_out = np.pad(u, 1), np.pad(v, 1)
            # uv at the corner above and before each cell, u² and v² in the middle of each.
            uv = (u_out[:-1, 1:-1] + u_out[1:, 1:-1]) / 2 * (v_out[1:-1, :-1] + v_out[1:-1, 1:]) / 2
            uu = ((u[:, :-1] + u[:, 1:]) / 2) ** 2
            vv = ((v[:-1, :] + v[1:, :]) / 2) ** 2
            push_u = p["viscosity"] * laplacian(u) - p["viscous_drag"] * u  # D1
            push_v = p["viscosity"] * laplacian(v) - p["viscous_drag"] * v
            push_u -= np.diff(uv, axis=0)
            push_v -= np.diff(uv, axis=1)
            push_u[:, 1:-1] -= np.diff(uu, axis=1) + np.diff(self.pressure, axis=1)
            push_v[1:-1, :] -= np.diff(vv, axis=0) + np.diff(self.pressure, axis=0)
            self.u, self.v = u + push_u / n, v + push_v / n
            self.still()
        return n

    def relax_divergence(self):
        """§4.3.2 with D2."""
        p = self.p
        for sweep in range(1, p["relax_max_sweeps"] + 1):
            delta = -p["relax_rate"] * (np.diff(self.u, axis=1) + np.diff(self.v, axis=0)) * self.wet
            self.pressure += delta
            around = np.pad(delta, 1)
            self.u -= np.diff(around[1:-1, :], axis=1)
            self.v -= np.diff(around[:, 1:-1], axis=0)
            self.still()
            largest = np.abs(delta).max()
            if sweep < p["relax_max_sweeps"]:
                # δ is ξ times a sum of velocities, and as much more exact.
                self.decided((largest - p["relax_tolerance"]) / p["relax_rate"])
            if largest <= p["relax_tolerance"]:
                break
        return sweep

    def flow_outward(self):
        """§4.3.3; the blur of D6 as a product of matrices."""
        p, (rows, columns) = self.p, self.wet.shape
        blurred = blur_matrix(rows, p["edge_kernel"]) @ self.wet @ blur_matrix(columns, p["edge_kernel"]).T
        self.pressure -= p["edge_darkening"] * (1.0 - blurred) * self.wet

    def move_pigment(self):
        """§4.4 with D3 and D4."""
        right, left = np.maximum(self.u, 0.0), np.maximum(-self.u, 0.0)
        down, up = np.maximum(self.v, 0.0), np.maximum(-self.v, 0.0)
        leaving = right[:, 1:] + left[:, :-1] + down[1:, :] + up[:-1, :]
        n = self.substeps(max(leaving.max(), np.abs(self.u).max(), np.abs(self.v).max()))
        for _ in range(n):
            g = np.pad(self.suspended, ((0, 0), (1, 1), (1, 1)))
            sideways = (right * g[:, 1:-1, :-1] - left * g[:, 1:-1, 1:]) / n
            downward = (down * g[:, :-1, 1:-1] - up * g[:, 1:, 1:-1]) / n
            self.suspended = self.suspended - np.diff(sideways, axis=2) - np.diff(downward, axis=1)
        return n

    def transfer_pigment(self):
        """§4.5."""
        g, d, h = self.suspended, self.deposited, self.height
        settling = g * (1.0 - h * self.granulation) * self.density
        lifting = d * (1.0 + (h - 1.0) * self.granulation) * self.density / self.staining
        settling = np.where(d + settling > 1.0, np.maximum(0.0, 1.0 - d), settling)
        lifting = np.where(g + lifting > 1.0, np.maximum(0.0, 1.0 - g), lifting)
        exchanged = (settling - lifting) * self.wet
        self.suspended, self.deposited = g - exchanged, d + exchanged

    def simulate_capillary_flow(self, absorption, min_diffusing, min_receiving, wetting_threshold, capacity):
        """§4.6."""
        least, most = capacity
        c = self.height * (most - least) + least
        self.saturation += np.clip(c - self.saturation, 0.0, absorption) * self.wet
        s, gained = self.saturation, np.zeros_like(c)
        rows, columns = s.shape
        # From each cell to its neighbour after it and below it, and back.
        for giver, taker in (
            (np.s_[:, : columns - 1], np.s_[:, 1:]),
            (np.s_[:, 1:], np.s_[:, : columns - 1]),
            (np.s_[: rows - 1, :], np.s_[1:, :]),
            (np.s_[1:, :], np.s_[: rows - 1, :]),
        ):
            flow = np.maximum(0.0, np.minimum(s[giver] - s[taker], c[taker] - s[taker]) / 4.0)
            gives, takes = s[giver] > min_diffusing, s[taker] > min_receiving
            # A threshold decides only where something would flow and the other threshold lets it.
            self.decided((s[giver] - min_diffusing)[(flow > MARGIN) & takes])
            self.decided((s[taker] - min_receiving)[(flow > MARGIN) & gives])
            flow = flow * (gives & takes)
            gained[giver] -= flow
            gained[taker] += flow
        self.saturation = s + gained
        self.decided((self.saturation - wetting_threshold)[~self.wet])
        self.wet |= self.saturation > wetting_threshold


def laplacian(a):
    """D5: neighbours outside the canvas are 0."""
    b = np.pad(a, 1)
    return b[:-2, 1:-1] + b[2:, 1:-1] + b[1:-1, :-2] + b[1:-1, 2:] - 4.0 * a


def blur_matrix(cells, kernel):
    """D5, D6: outside the canvas M is 0, so weights that fall there are lost."""
    radius = kernel // 2

    def gauss(distance):
        return np.exp(-(distance**2) / (2.0 * (kernel / 4.0) ** 2))

    apart = np.arange(cells)[:, None] - np.arange(cells)[None, :]
    return np.where(np.abs(apart) <= radius, gauss(apart), 0.0) / gauss(np.arange(-radius, radius + 1)).sum()


# The cases.

DEFAULTS = {
    "viscosity": 0.1,
    "viscous_drag": 0.01,
    "edge_darkening": 0.02,
    "edge_kernel": 10,
    "relax_max_sweeps": 50,
    "relax_tolerance": 0.01,
    "relax_rate": 0.1,
    "slope_scale": 0.15,
}
CAPILLARY = {
    "absorption": 0.05,
    "min_diffusing": 0.1,
    "min_receiving": 0.01,
    "wetting_threshold": 0.55,
    "capacity": [0.3, 0.9],
}


def waves(rng, rows, columns, longest, shortest):
    """Smooth numbers from −1 to 1: noise from cell to cell would rightly run away as a velocity."""
    y, x = np.mgrid[:rows, :columns]
    total = np.zeros((rows, columns))
    for _ in range(6):
        length, turn, phase = rng.uniform(shortest, longest), rng.uniform(0, np.pi), rng.uniform(0, 2 * np.pi)
        total += np.sin(2 * np.pi * (x * np.cos(turn) + y * np.sin(turn)) / length + phase)
    return total / 6


def swirl(rng, rows, columns, speed, longest, shortest):
    """Velocities that neither gather water nor thin it out, so that relaxation leaves them fast."""
    stream = waves(rng, rows + 1, columns + 1, longest, shortest)
    u, v = np.diff(stream, axis=0), -np.diff(stream, axis=1)
    scale = speed / max(np.abs(u).max(), np.abs(v).max())
    return u * scale, v * scale


def start(rng, rows, columns, wet, pigments, speed=0.3, longest=24, shortest=10):
    """A state with something in every field, over dry paper too: that must stay as it is."""
    shape = (rows, columns)
    u, v = swirl(rng, *shape, speed, longest, shortest)
    height = 0.5 + 0.3 * waves(rng, *shape, 9, 3) + rng.uniform(-0.2, 0.2, shape)
    pressure = 0.4 + 0.4 * waves(rng, *shape, longest, shortest) + rng.uniform(-0.1, 0.1, shape)
    return {
        "wet_mask": wet,
        "height": np.clip(height, 0.0, 1.0),
        "u": u,
        "v": v,
        "pressure": pressure,
        "saturation": np.maximum(0.0, rng.uniform(-0.2, 0.5, shape)),
        "suspended": rng.uniform(0.0, 1.0, (pigments, *shape)),
        "deposited": rng.uniform(0.0, 0.6, (pigments, *shape)),
    }


def ragged(rng, rows, columns, wetness):
    """A frayed blob with islands and single cells."""
    shape = waves(rng, rows, columns, 22, 9) + rng.uniform(-0.25, 0.25, (rows, columns))
    return shape < np.quantile(shape, wetness)


def disc(rng, rows, columns, radius):
    y, x = np.mgrid[:rows, :columns]
    apart = np.hypot(y - rows / 2, x - columns / 2)
    return apart + 2.0 * waves(rng, rows, columns, 20, 6) < radius


def cases():
    """Name, why, start, pigments, changed parameters, capillary parameters or none."""

    def one_cell(rng):
        return start(rng, 1, 1, np.ones((1, 1)), 1)

    yield "one-cell", "Every neighbour lies outside the canvas.", one_cell, ["french-ultramarine"], {}, None

    def one_row(rng):
        wet = np.ones((1, 17))
        wet[0, [3, 11]] = 0
        return start(rng, 1, 17, wet, 1)

    yield "one-row", "No face has a neighbour above or below.", one_row, ["burnt-umber"], {}, None

    def one_column(rng):
        wet = np.ones((23, 1))
        wet[[5, 6, 20]] = 0
        return start(rng, 23, 1, wet, 1)

    yield "one-column", "No face has a neighbour before or after.", one_column, ["quinacridone-rose"], {}, None

    def ragged_edge(rng):
        return start(rng, 21, 33, ragged(rng, 21, 33, 0.6), 1)

    yield "ragged-edge", "Dry cells stop the water everywhere.", ragged_edge, ["french-ultramarine"], {}, None

    def growing_mask(rng):
        state = start(rng, 32, 40, disc(rng, 32, 40, 9), 3)
        state["saturation"] = np.maximum(0.0, 0.35 + 0.3 * waves(rng, 32, 40, 16, 6))
        return state

    yield (
        "growing-mask",
        "Water creeps through the pores and wets new cells, three pigments follow.",
        growing_mask,
        ["cerulean-blue", "indian-red", "hookers-green"],
        {"edge_darkening": 0.03},
        CAPILLARY,
    )

    def fast_water(rng):
        wet = np.ones((40, 48))
        wet[:2, :5] = 0
        return start(rng, 40, 48, wet, 1, speed=1.4, longest=48, shortest=24)

    yield (
        "fast-water",
        "A step needs several sub-steps, of water and of pigment.",
        fast_water,
        ["burnt-umber"],
        {"viscous_drag": 0.0},
        None,
    )

    def unusual_parameters(rng):
        return start(rng, 30, 30, ragged(rng, 30, 30, 0.75), 1, speed=0.5)

    yield (
        "unusual-parameters",
        "No parameter is its default: relaxation stops early, the edge kernel is odd and wider than the canvas.",
        unusual_parameters,
        ["quinacridone-rose"],
        {
            "viscosity": 0.17,
            "viscous_drag": 0.06,
            "edge_darkening": 0.045,
            "edge_kernel": 37,
            "relax_max_sweeps": 70,
            "relax_tolerance": 0.004,
            "relax_rate": 0.19,
            "slope_scale": 0.31,
        },
        {
            "absorption": 0.03,
            "min_diffusing": 0.13,
            "min_receiving": 0.125,
            "wetting_threshold": 0.61,
            "capacity": [0.25, 0.8],
        },
    )


# The seed of each case that keeps its decisions apart from their thresholds.
SEEDS = {
    "one-cell": 1,
    "one-row": 2,
    "one-column": 2,
    "ragged-edge": 2,
    "growing-mask": 16,
    "fast-water": 4,
    "unusual-parameters": 26,
}


def wash_toml(why, pigments, parameters, capillary):
    tables = [{"model": "c97", "pigments": pigments} | parameters, capillary or {}]
    # JSON writes words, numbers and lists as TOML does.
    main, pores = ([f"{key} = {json.dumps(value)}" for key, value in table.items()] for table in tables)
    return "\n".join([f"# {why}", *main, *(["[capillary]", *pores] if pores else [])]) + "\n"


def run(folder):
    """The states after STEPS of the case stored in a folder, and the wash."""
    with np.load(folder / "start.npz") as state:
        wash = Wash(state, tomllib.loads((folder / "wash.toml").read_text()))
    states = {}
    for step in range(1, max(STEPS) + 1):
        wash.step()
        if step in STEPS:
            states[step] = wash.state()
    return states, wash


def accept(name, states, wash):
    """Refuses a case that is no good as a golden, and says what it does."""
    assert wash.margin > MARGIN, f"{name}: a decision was only {wash.margin:.1e} off; take another seed"
    for state in states.values():
        assert all(np.isfinite(field).all() for field in state.values()), name
        assert min(state[key].min() for key in ("saturation", "suspended", "deposited")) >= 0.0, name
    water, sweeps, pigment, wet = (f"{min(c)}..{max(c)}" for c in zip(*wash.counts))
    print(f"{name:20} sub-steps {water} and {pigment}, sweeps {sweeps}, wet {wet}, margin {wash.margin:.1e}")


def make():
    for name, why, begin, pigments, changed, capillary in cases():
        folder = HERE / name
        folder.mkdir(exist_ok=True)
        state = begin(np.random.default_rng(SEEDS[name]))
        kinds = {"wet_mask": np.uint8}
        single = {key: field.astype(kinds.get(key, np.float32)) for key, field in state.items()}
        np.savez_compressed(folder / "start.npz", **single)
        (folder / "wash.toml").write_text(wash_toml(why, pigments, DEFAULTS | changed, capillary))
        states, wash = run(folder)
        accept(name, states, wash)
        for step, state in states.items():
            np.savez_compressed(folder / f"after-{step}.npz", **state)


def check():
    for folder in sorted(path for path in HERE.glob("*/") if not path.name.startswith(("living-", "_"))):
        states, wash = run(folder)
        accept(folder.name, states, wash)
        for step, state in states.items():
            with np.load(folder / f"after-{step}.npz") as stored:
                for key, field in state.items():
                    off = np.abs(stored[key] - field).max()
                    assert off < 1e-9, f"{folder.name}: `{key}` after {step} steps is {off:.1e} off"


if __name__ == "__main__":
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(__doc__)
    check() if sys.argv[1:] else make()

"""The living wash in float64: the model that Girtin's `living` engine is held against.

Curtis et al. 1997 (C97), *Computer-Generated Watercolor*, section 4, with two things changed throughout: the same wash
comes out at any resolution, and film and pores share one amount of water. Each place that differs says what it
replaces and why; L-numbers are those of docs/paper-notes.md. "The first formulation" is that of this model: it already
had the space terms, the packing limit and the one wetness.

Lengths are reference cells (0.25 mm) and times reference steps. At scale r a grid cell is 1/r reference cells and a
step is the same time; velocities are stored in grid cells a step. Arrays are [y, x]; u is (H, W + 1), u[y, x] the face
before cell x; v is (H + 1, W), v[y, x] the face above cell y. Needs NumPy and Numba; shares no code with Girtin.

    wash = WashX(height, mask, ["burnt umber"], suspended, film, r=2, **LIVING)
    wash.step(120)
"""

import numpy as np
from numba import njit

# name: (density, staining power, granulation), Curtis et al. 1997, figure 5.
PIGMENTS = {
    "quinacridone rose": (0.02, 5.5, 0.81),
    "indian red": (0.05, 7.0, 0.40),
    "cadmium yellow": (0.05, 3.4, 0.81),
    "hookers green": (0.09, 1.0, 0.41),
    "cerulean blue": (0.01, 1.0, 0.31),
    "burnt umber": (0.09, 9.3, 0.90),
    "cadmium red": (0.02, 1.0, 0.63),
    "brilliant orange": (0.01, 1.0, 0.14),
    "hansa yellow": (0.06, 1.0, 0.08),
    "phthalo green": (0.02, 1.0, 0.12),
    "french ultramarine": (0.01, 3.1, 0.91),
    "interference lilac": (0.06, 1.0, 0.08),
}

# What belongs to the water's coming and going; the names are those of WashX.step.
WET = {
    "w_flow": 0.15,  # film that flows freely
    "m_min": 0.1,  # what a vanishing film keeps of its speed in a step
    "zeta": 0.3,  # film that one unit of saturation makes
    "evap": 0.002,  # film that dries in a step
    "evap_s": 0.0004,  # saturation that dries in a step where there is no film
    "settle": 0.1,  # pigment that a vanishing film drops in a step
    "lift": 4.0,  # how much more easily than in C97 paint comes up again
    "w_on": 0.06,  # film that creeps over full pores
    "w_off": 0.01,  # film that is gone
    "pin": 2.0,  # how much more film it takes to creep over dry paper
    "rough": 0.5,  # how much more peaks hold than valleys
    "rim_expo": 4,  # how nearly full pores must be to end the edge of a film
    "creep": 0.25,  # reference cells an edge can advance in a step
    "share": 0.5,  # of its film that a cell gives to one that it wets
    "drain_passes": 2,  # times that inflow into thin film is counted in, a reference cell
}

# The parameters of the constructor that make the model; all others are C97's.
LIVING = {
    "relax": 0.4,
    "diff": 0.03,
    "disperse": 0.15,
    "pack": 1.2,
    "eta": 0.02,
    "slope": 0.3,
    "alpha": 0.02,
    "eps": 0.05,
    "delta": 0.02,
    "wet": WET,
}

# Error of the relaxation that is allowed, relative. A tenth of it moves pigment by less than 3 in a thousand.
TOLERANCE = 1e-2

# What a board that stands upright adds to the water's velocity in a step, reference cells.
GRAVITY = 0.2


def pull(tilt, toward):
    """L14. What a board leaning by `tilt` degrees adds to u and v in a step, reference cells; down is `toward`."""
    tilt, toward = np.radians(tilt), np.radians(toward)
    return GRAVITY * np.sin(tilt) * np.cos(toward), GRAVITY * np.sin(tilt) * np.sin(toward)


def arguments(table):
    """The arguments of WashX for a `[living]` table of a wash.toml, whose lengths are millimetres."""
    cell = 0.25
    return {
        "relax": table["compressibility"],
        "mu": table["viscosity"] / cell**2,
        "kappa": table["viscous_drag"],
        "slope": table["slope_scale"],
        "band": table["slope_band"] / cell,
        "cap": table["speed_limit"] / cell,
        "diff": table["pigment_diffusion"] / cell**2,
        "disperse": table["pigment_dispersion"] / cell,
        "pack": table["packing_limit"],
        "eta": table["edge_darkening"],
        "K": table["edge_width"] / cell,
        "alpha": table["absorption"],
        "eps": table["min_diffusing"],
        "delta": table["min_receiving"],
        "cmin": table["capacity"][0],
        "cmax": table["capacity"][1],
        "tilt": pull(table["tilt"], table["tilt_toward"]),
        "wet": {
            "w_flow": table["flowing_film"],
            "m_min": table["least_mobility"],
            "zeta": table["pore_depth"],
            "evap": table["evaporation"],
            "evap_s": table["pore_evaporation"],
            "settle": table["settling"],
            "lift": table["lifting"],
            "w_on": table["wetting_film"],
            "w_off": table["drying_film"],
            "pin": table["pinning"],
            "rough": table["pin_roughness"],
            "rim_expo": table["rim_exponent"],
            "creep": table["creep_speed"] / cell,
            "share": table["creep_share"],
            "drain_passes": WET["drain_passes"],
        },
    }


# Helpers.


@njit(cache=True)
def vmax(u, v):
    m = 0.0
    for y in range(u.shape[0]):
        for x in range(u.shape[1]):
            m = max(m, abs(u[y, x]))
    for y in range(v.shape[0]):
        for x in range(v.shape[1]):
            m = max(m, abs(v[y, x]))
    return m


def gauss_blur_K(a, K):
    """D6: separable Gaussian, sigma K/4 cells, taps -floor(K/2) to floor(K/2), normalised; 0 outside the canvas."""
    n = int(K // 2)
    t = np.arange(-n, n + 1)
    k = np.exp(-t * t / (2 * (K / 4.0)**2))
    k /= k.sum()
    a = np.pad(a.astype(float), n)
    a = np.apply_along_axis(lambda m: np.convolve(m, k, 'valid'), 0, a)
    return np.apply_along_axis(lambda m: np.convolve(m, k, 'valid'), 1, a)


def band_limit(h, width):
    """L8. The height that the slope term sees: its mean over a window `width` cells wide, centred on the cell.

    C97 takes the slope from cell to cell. Grain finer than a reference cell would then push the water the harder the
    finer it is resolved. What lies outside the canvas is left out; a window of one cell is the height itself.
    """
    if width <= 1:
        return h
    n = int(np.floor((width - 1) / 2))
    part = (width - 1) / 2 - n
    k = np.concatenate([[part], np.ones(2 * n + 1), [part]])

    def sums(a):
        for axis in (0, 1):
            a = np.apply_along_axis(lambda m: np.convolve(np.pad(m, n + 1), k, "valid"), axis, a)
        return a

    return sums(h) / sums(np.ones_like(h))


# Water.


@njit(cache=True)
def face_mobility(M, p, w_flow, m_min, mu_, mv_):
    """L6. What a face keeps of its speed in a step: 0 beside a dry cell, 1 under a film of depth w_flow.

    In C97 wet is yes or no. Here a thin film is held by the paper, so that flow dies away as it dries.
    """
    H, W = M.shape
    for y in range(H):
        for x in range(W + 1):
            m = 0.0
            if x > 0 and x < W and M[y, x - 1] and M[y, x]:
                t = max(0.0, min(1.0, 0.5 * (p[y, x - 1] + p[y, x]) / w_flow))
                m = m_min + (1 - m_min) * t * t * (3 - 2 * t)
            mu_[y, x] = m
    for y in range(H + 1):
        for x in range(W):
            m = 0.0
            if y > 0 and y < H and M[y - 1, x] and M[y, x]:
                t = max(0.0, min(1.0, 0.5 * (p[y - 1, x] + p[y, x]) / w_flow))
                m = m_min + (1 - m_min) * t * t * (3 - 2 * t)
            mv_[y, x] = m


@njit(cache=True)
def update_velocities(mu_, mv_, u, v, p, h, visc, kappa, r, cap, gx, gy):
    """C97 UpdateVelocities (D1, D5, D7) at scale r.

    L1. The slope and the gradient of the pressure are differences over 1/r of a reference cell and give r times as many
    cells a step: together r^2; so is the viscosity. Drag is a rate and stays. `h` is slope times the height of L8.
    L9. No face is faster than one reference cell a step (`cap` in cells): without a limit film 8 poured on damp paper
    ended in numbers that are none. L14. gx, gy: the pull of a tilted board.
    """
    H, W = p.shape
    r2 = r * r
    # A plane that drops by g in a reference cell drops g / r in a cell; the slope term is r^2 of that.
    for y in range(H):
        for x in range(1, W):
            u[y, x] = (u[y, x] - r2 * (h[y, x] - h[y, x - 1]) + r * gx) * (mu_[y, x] > 0)
        u[y, 0] = 0.0
        u[y, W] = 0.0
    for x in range(W):
        for y in range(1, H):
            v[y, x] = (v[y, x] - r2 * (h[y, x] - h[y - 1, x]) + r * gy) * (mv_[y, x] > 0)
        v[0, x] = 0.0
        v[H, x] = 0.0
    nu = visc * r2
    # D4 counts the speed there is; what the pressure will give during the step counts here too.
    fastest = 0.0
    for y in range(H):
        for x in range(1, W):
            if mu_[y, x] > 0:
                fastest = max(fastest, abs(u[y, x]) + r2 * abs(p[y, x] - p[y, x - 1]))
    for y in range(1, H):
        for x in range(W):
            if mv_[y, x] > 0:
                fastest = max(fastest, abs(v[y, x]) + r2 * abs(p[y, x] - p[y - 1, x]))
    n = max(1, int(np.ceil(4 * nu)), int(np.ceil(min(64.0, fastest))))
    dt = 1.0 / n
    ku = mu_ ** dt
    kv = mv_ ** dt
    for _ in range(n):
        un = u.copy()
        vn = v.copy()
        for y in range(H):
            for x in range(1, W):
                if mu_[y, x] == 0:
                    continue
                ul = 0.5 * (u[y, x - 1] + u[y, x])
                ur = 0.5 * (u[y, x] + u[y, x + 1])
                ut = 0.5 * ((u[y - 1, x] if y > 0 else 0.0) + u[y, x])
                ub = 0.5 * ((u[y + 1, x] if y < H - 1 else 0.0) + u[y, x])
                vt = 0.5 * (v[y, x - 1] + v[y, x])
                vb = 0.5 * (v[y + 1, x - 1] + v[y + 1, x])
                A = ul * ul - ur * ur + ut * vt - ub * vb
                below = u[y + 1, x] if y < H - 1 else 0.0
                above = u[y - 1, x] if y > 0 else 0.0
                B = u[y, x + 1] + u[y, x - 1] + below + above - 4 * u[y, x]
                un[y, x] = (u[y, x] + dt * (A + nu * B + r2 * p[y, x - 1] - r2 * p[y, x] - kappa * u[y, x])) * ku[y, x]
        for y in range(1, H):
            for x in range(W):
                if mv_[y, x] == 0:
                    continue
                vt = 0.5 * (v[y - 1, x] + v[y, x])
                vb = 0.5 * (v[y, x] + v[y + 1, x])
                vl = 0.5 * ((v[y, x - 1] if x > 0 else 0.0) + v[y, x])
                vr = 0.5 * ((v[y, x + 1] if x < W - 1 else 0.0) + v[y, x])
                ul = 0.5 * (u[y - 1, x] + u[y, x])
                ur = 0.5 * (u[y - 1, x + 1] + u[y, x + 1])
                A = vt * vt - vb * vb + ul * vl - ur * vr
                after = v[y, x + 1] if x < W - 1 else 0.0
                before = v[y, x - 1] if x > 0 else 0.0
                B = after + before + v[y + 1, x] + v[y - 1, x] - 4 * v[y, x]
                vn[y, x] = (v[y, x] + dt * (A + nu * B + r2 * p[y - 1, x] - r2 * p[y, x] - kappa * v[y, x])) * kv[y, x]
        for y in range(H):
            for x in range(1, W):
                un[y, x] = max(-cap, min(cap, un[y, x]))
        for y in range(1, H):
            for x in range(W):
                vn[y, x] = max(-cap, min(cap, vn[y, x]))
        u[:] = un
        v[:] = vn
    return n


@njit(cache=True)
def helm(mu_, mv_, q, b, out):
    H, W = q.shape
    for y in range(H):
        for x in range(W):
            a = 0.0
            if x > 0:
                a += mu_[y, x] * (q[y, x] - q[y, x - 1])
            if x < W - 1:
                a += mu_[y, x + 1] * (q[y, x] - q[y, x + 1])
            if y > 0:
                a += mv_[y, x] * (q[y, x] - q[y - 1, x])
            if y < H - 1:
                a += mv_[y + 1, x] * (q[y, x] - q[y + 1, x])
            out[y, x] = q[y, x] + b * a


@njit(cache=True)
def relax_implicit(mu_, mv_, u, v, B, r, tol, itmax):
    """L2. In place of C97's RelaxDivergence: (1 - B r^2 div m grad) q = div u, then u += B r^2 m grad q.

    C97's n sweeps at rate xi are a compressibility B = n xi, which its loop chose anew each step (1 to 4 sweeps on
    ordinary washes). A fixed B means the same at any r and costs r^3 in all where sweeps cost r^4. Chebyshev's
    iteration on the known spectrum [1, 1 + 8 B r^2] needs no sums over cells. The water itself is moved by `drain`.
    """
    H, W = u.shape[0], v.shape[1]
    b = B * r * r
    rhs = np.zeros((H, W))
    for y in range(H):
        for x in range(W):
            rhs[y, x] = u[y, x + 1] - u[y, x] + v[y + 1, x] - v[y, x]
    q = rhs / (1 + 4 * b)
    Aq = np.zeros((H, W))
    th = 1 + 4 * b
    de = 4 * b
    s1 = th / de
    rho = 1 / s1
    helm(mu_, mv_, q, b, Aq)
    res = rhs - Aq
    d = res / th
    k = (np.sqrt(1 + 8 * b) - 1) / (np.sqrt(1 + 8 * b) + 1)
    it = min(itmax, int(np.ceil(np.log(tol / 2) / np.log(k))))
    for _ in range(it):
        q += d
        helm(mu_, mv_, d, b, Aq)
        res -= Aq
        rn = 1 / (2 * s1 - rho)
        d = rn * rho * d + 2 * rn / de * res
        rho = rn
    q += d
    for y in range(H):
        for x in range(1, W):
            u[y, x] += b * mu_[y, x] * (q[y, x] - q[y, x - 1])
    for y in range(1, H):
        for x in range(W):
            v[y, x] += b * mv_[y, x] * (q[y, x] - q[y - 1, x])
    return it


@njit(cache=True)
def drain(u, v, p, B, passes):
    """L7. The film follows the relaxed flow, p -= B div u, and no cell gives more than it has.

    B u is the water through a face. All that leaves a cell is scaled by its share k, from 0 to 1: first what it holds
    over what is asked of it, then, `passes` times, what it holds and what its neighbours' old shares let in. Shares
    only rise, so the film stays >= 0 after any number of passes. The first formulation had no limit, and film went
    below 0 (-4e-3 at ordinary loads). Without the passes a film thinner than what flows *through* it in a step, as at
    r = 4, would stop the flow, and damp edges faded (CIEDE2000 2.2 where it is 1.5). They are two for each reference
    cell; two at any r gave 6.0 wet-in-wet at r = 4. A film that was below 0 from the start is left to rise.
    """
    H, W = p.shape
    out = np.zeros((H, W))
    k = np.ones((H, W))
    for y in range(H):
        for x in range(W):
            o = B * (max(0.0, -u[y, x]) + max(0.0, u[y, x + 1]) + max(0.0, -v[y, x]) + max(0.0, v[y + 1, x]))
            out[y, x] = o
            held = max(0.0, p[y, x])
            if o > held:
                k[y, x] = held / o
    for _ in range(passes):
        kn = np.ones((H, W))
        for y in range(H):
            for x in range(W):
                a = max(0.0, p[y, x])
                if x > 0:
                    a += B * max(0.0, u[y, x]) * k[y, x - 1]
                if x < W - 1:
                    a += B * max(0.0, -u[y, x + 1]) * k[y, x + 1]
                if y > 0:
                    a += B * max(0.0, v[y, x]) * k[y - 1, x]
                if y < H - 1:
                    a += B * max(0.0, -v[y + 1, x]) * k[y + 1, x]
                if out[y, x] > a:
                    kn[y, x] = a / out[y, x]
        k = kn
    pn = np.zeros((H, W))
    for y in range(H):
        for x in range(W):
            # Faces at the canvas's end carry nothing.
            l = B * u[y, x] * (k[y, x - 1] if x > 0 and u[y, x] > 0 else k[y, x])
            t = B * v[y, x] * (k[y - 1, x] if y > 0 and v[y, x] > 0 else k[y, x])
            rt = B * u[y, x + 1] * (k[y, x + 1] if x < W - 1 and u[y, x + 1] < 0 else k[y, x])
            b = B * v[y + 1, x] * (k[y + 1, x] if y < H - 1 and v[y + 1, x] < 0 else k[y, x])
            pn[y, x] = max(min(p[y, x], 0.0), p[y, x] + ((l - rt) + (t - b)))
    p[:] = pn


# Pigment.


@njit(cache=True)
def limited(a, b, c):
    """Van Leer's slope of b between a and c."""
    d1 = b - a
    d2 = c - b
    return 2 * d1 * d2 / (d1 + d2) if d1 * d2 > 0 else 0.0


@njit(cache=True)
def move_pigment(mu_, mv_, u, v, g, d, diff, disperse, pack, r):
    """In place of C97's MovePigment: van Leer's fluxes, a packing limit, diffusion and dispersion.

    L3. C97's upwind fluxes blur by about a cell a step, that is by less the finer the grid; van Leer's hardly do. C97's
    rim is a cell wide at any resolution (0.27, 0.13, 0.065 mm at r = 1, 2, 4). Here a face lets in 1 - (G / pack)^4 of
    its flux, G all pigment of the receiving cell, so a full rim grows inwards. Pigment also diffuses by diff r^2.
    L4. Water that flows mixes along its flow: a face also diffuses disperse r |velocity|. A stroke pushed out over wet
    paper so gets a softer edge the farther it is pushed. The first formulation had none, and at r = 2 edges were harder
    on wet paper (0.87 mm at 1.6 pore volumes) than where pores were just full (1.08 mm).
    Sub-steps: van Leer needs half the upwind step, mixing and diffusion their own.
    """
    n_k, H, W = g.shape
    worst = 0.0
    for y in range(H):
        for x in range(W):
            o = max(0.0, u[y, x + 1]) + max(0.0, -u[y, x]) + max(0.0, v[y + 1, x]) + max(0.0, -v[y, x])
            worst = max(worst, o)
    dc = diff * r * r
    da = disperse * r
    n = max(1, int(np.ceil((2 + 2 * da) * worst + 4 * dc)))
    dt = 1.0 / n
    G = np.zeros((H, W))
    for _ in range(n):
        G[:] = 0
        for k in range(n_k):
            G += g[k] + d[k]
        for k in range(n_k):
            c = g[k]
            gn = c.copy()
            for y in range(H):
                for x in range(1, W):
                    if mu_[y, x] == 0:
                        continue
                    a = u[y, x]
                    if a > 0:
                        f = c[y, x - 1]
                        if x > 1:
                            f += 0.5 * (1 - a * dt) * limited(c[y, x - 2], c[y, x - 1], c[y, x])
                        f *= a * dt * max(0.0, 1 - (G[y, x] / pack)**4)
                    else:
                        f = c[y, x]
                        if x < W - 1:
                            f -= 0.5 * (1 + a * dt) * limited(c[y, x - 1], c[y, x], c[y, x + 1])
                        f *= a * dt * max(0.0, 1 - (G[y, x - 1] / pack)**4)
                    f += dt * (dc * mu_[y, x] + da * abs(a)) * (c[y, x - 1] - c[y, x])
                    gn[y, x] += f
                    gn[y, x - 1] -= f
            for y in range(1, H):
                for x in range(W):
                    if mv_[y, x] == 0:
                        continue
                    a = v[y, x]
                    if a > 0:
                        f = c[y - 1, x]
                        if y > 1:
                            f += 0.5 * (1 - a * dt) * limited(c[y - 2, x], c[y - 1, x], c[y, x])
                        f *= a * dt * max(0.0, 1 - (G[y, x] / pack)**4)
                    else:
                        f = c[y, x]
                        if y < H - 1:
                            f -= 0.5 * (1 + a * dt) * limited(c[y - 1, x], c[y, x], c[y + 1, x])
                        f *= a * dt * max(0.0, 1 - (G[y - 1, x] / pack)**4)
                    f += dt * (dc * mv_[y, x] + da * abs(a)) * (c[y - 1, x] - c[y, x])
                    gn[y, x] += f
                    gn[y - 1, x] -= f
            g[k] = gn
    return n


@njit(cache=True)
def transfer_pigment(M, g, d, h, rho, omega, gamma, lift):
    """C97 TransferPigment. L11. Paint that is not yet set comes up `lift` times as easily."""
    n, H, W = g.shape
    for k in range(n):
        for y in range(H):
            for x in range(W):
                if M[y, x] == 0:
                    continue
                down = g[k, y, x] * (1 - h[y, x] * gamma[k]) * rho[k]
                up = d[k, y, x] * (1 + (h[y, x] - 1) * gamma[k]) * rho[k] * lift / omega[k]
                if d[k, y, x] + down > 1:
                    down = max(0.0, 1 - d[k, y, x])
                if g[k, y, x] + up > 1:
                    up = max(0.0, 1 - g[k, y, x])
                d[k, y, x] += down - up
                g[k, y, x] += up - down


# One wetness.


@njit(cache=True)
def wettest(M, p, y, x):
    """The deepest film of the four neighbours, at least 0."""
    H, W = M.shape
    b = 0.0
    if y > 0 and M[y - 1, x]:
        b = max(b, p[y - 1, x])
    if y < H - 1 and M[y + 1, x]:
        b = max(b, p[y + 1, x])
    if x > 0 and M[y, x - 1]:
        b = max(b, p[y, x - 1])
    if x < W - 1 and M[y, x + 1]:
        b = max(b, p[y, x + 1])
    return b


@njit(cache=True)
def settle(M, p, g, d, w_flow, rate):
    """L11. A film drops its pigment as it vanishes, up to `rate` of it in a step.

    Without it pools that dried last left contour lines. Film beside a cell holds its pigment as well.
    """
    n_k, H, W = g.shape
    for y in range(H):
        for x in range(W):
            if M[y, x]:
                t = 1 - max(0.0, min(1.0, max(p[y, x], wettest(M, p, y, x)) / w_flow))
                f = rate * t * t
                if f > 0:
                    for k in range(n_k):
                        d[k, y, x] += f * g[k, y, x]
                        g[k, y, x] -= f * g[k, y, x]


@njit(cache=True)
def absorb(M, s, c, p, alpha, zeta):
    """L5. C97's absorption, but the water leaves the film: zeta is the film that one unit of saturation makes."""
    H, W = M.shape
    for y in range(H):
        for x in range(W):
            if M[y, x]:
                a = max(0.0, min(alpha, c[y, x] - s[y, x], p[y, x] / zeta))
                s[y, x] += a
                # Rounding may undercut 0; a film that was below 0 stays.
                p[y, x] = max(min(p[y, x], 0.0), p[y, x] - zeta * a)


@njit(cache=True)
def capillary_flux(sa, sb, ca, cb, eps, delta, part):
    """Water from pore a to pore b in one pass if a is the wetter one, else 0: C97's, times the conductivity.

    L10. Pores conduct as the fourth power of how full the two are on average, as unsaturated soil does with some high
    power. C97 conducts fully as soon as b holds delta. That switched wicking on between dry and barely damp paper:
    strokes there dried faster and had *darker* rims than on dry paper (3.4 where dry paper had 2.9).
    """
    if not (sa > sb and sa > eps and sb > delta):
        return 0.0
    f = min(1.0, 0.5 * (sa / ca + sb / cb))
    f *= f
    f *= f
    return f * max(0.0, part * min(sa - sb, cb - sb))


@njit(cache=True)
def diffuse(s, c, eps, delta, r):
    """C97's capillary diffusion, by faces. L1. It moves r^2 quarters of a difference in a step, and a quarter is the
    limit of a pass: r^2 passes, rounded up."""
    H, W = s.shape
    passes = max(1, int(np.ceil(r * r)))
    part = 0.25 * r * r / passes
    for _ in range(passes):
        # Water through each face, to the right and down.
        fx = np.zeros((H, W + 1))
        fy = np.zeros((H + 1, W))
        for y in range(H):
            for x in range(1, W):
                fx[y, x] = capillary_flux(s[y, x - 1], s[y, x], c[y, x - 1], c[y, x], eps, delta, part) \
                    - capillary_flux(s[y, x], s[y, x - 1], c[y, x], c[y, x - 1], eps, delta, part)
        for y in range(1, H):
            for x in range(W):
                fy[y, x] = capillary_flux(s[y - 1, x], s[y, x], c[y - 1, x], c[y, x], eps, delta, part) \
                    - capillary_flux(s[y, x], s[y - 1, x], c[y, x], c[y - 1, x], eps, delta, part)
        for y in range(H):
            for x in range(W):
                s[y, x] += (fx[y, x] - fx[y, x + 1]) + (fy[y, x] - fy[y + 1, x])


@njit(cache=True)
def creep(M, p, s, c, h, w_on, pin, rough, share):
    """L12. The contact line: a dry cell becomes wet beside a film that stands higher than it needs. One rule from dry
    paper to wet, in place of C97's "pores above sigma join the mask".

    need(j) = w_on + pin (1 - s / c) (1 + rough (2 h - 1)), for a dry cell j. A wet cell i that would wet t of its
    neighbours offers each p_i (1 - (1 - share)^t) / t; a dry cell with several donors takes the mean of their offers.
    All of it is decided by the old mask and film (Jacobi), so what is given is taken and no order matters. The first
    formulation went cell by cell in place, and a mirrored wash did not creep mirrored.
    """
    H, W = M.shape
    need = np.full((H, W), np.inf)
    for y in range(H):
        for x in range(W):
            if M[y, x] == 0:
                need[y, x] = w_on + pin * (1 - min(1.0, s[y, x] / c[y, x])) * (1 + rough * (2 * h[y, x] - 1))
    offer = np.zeros((H, W))  # of wet cells
    part = np.zeros((H, W))  # 1 / donors in dry cells that join, else 0
    for y in range(H):
        for x in range(W):
            takers = 0
            donors = 0
            for k in range(4):
                yy = y + (-1, 0, 0, 1)[k]
                xx = x + (0, -1, 1, 0)[k]
                if yy < 0 or xx < 0 or yy >= H or xx >= W:
                    continue
                if M[y, x] and p[y, x] > need[yy, xx]:
                    takers += 1
                if M[yy, xx] and p[yy, xx] > need[y, x]:
                    donors += 1
            if takers > 0:
                offer[y, x] = p[y, x] * ((1 - (1 - share)**takers) / takers)
            if donors > 0:
                part[y, x] = 1.0 / donors
    pn = p.copy()
    for y in range(H):
        for x in range(W):
            if M[y, x] == 0 and part[y, x] == 0 or M[y, x] and offer[y, x] == 0:
                continue
            t = np.zeros(4)  # from above, left, right, below
            for k in range(4):
                yy = y + (-1, 0, 0, 1)[k]
                xx = x + (0, -1, 1, 0)[k]
                if yy < 0 or xx < 0 or yy >= H or xx >= W:
                    continue
                if M[y, x] == 0:
                    if M[yy, xx] and p[yy, xx] > need[y, x]:
                        t[k] = offer[yy, xx] * part[y, x]
                elif p[y, x] > need[yy, xx]:
                    t[k] = -offer[y, x] * part[yy, xx]
            # Grouped by symmetry: a mirrored wash creeps mirrored to the bit.
            pn[y, x] = p[y, x] + ((t[0] + t[3]) + (t[1] + t[2]))
    for y in range(H):
        for x in range(W):
            if part[y, x] > 0:
                M[y, x] = 1
    p[:] = pn


@njit(cache=True)
def dry(M, p, u, v, s, c, g, d, h, w_off, w_on, zeta):
    """L13. A cell whose film is gone leaves the mask: its pigment settles, the rest of its film soaks in as far as
    there is room and evaporates beyond, its faces stand still. Returns what evaporated.

    In C97 nothing dries. It takes more film to join the wet (w_on) than to stay (w_off), so edges do not flicker; and
    beside film above w_on a cell stays, for it will be filled again.
    """
    n_k, H, W = g.shape
    lost = 0.0
    Mo = M.copy()
    po = p.copy()
    for y in range(H):
        for x in range(W):
            if Mo[y, x] and p[y, x] < w_off * 2 * h[y, x]:
                if wettest(Mo, po, y, x) > w_on:
                    continue
                M[y, x] = 0
                u[y, x] = u[y, x + 1] = v[y, x] = v[y + 1, x] = 0.0
                a = min(max(0.0, p[y, x]), zeta * max(0.0, c[y, x] - s[y, x]))
                s[y, x] += a / zeta
                lost += p[y, x] - a
                p[y, x] = 0.0
                for k in range(n_k):
                    d[k, y, x] += g[k, y, x]
                    g[k, y, x] = 0.0
    return lost


# The wash.


class WashX:
    """h height (H, W), 0 to 1; mask, wet or not; pigments: names or (density, staining power, granulation);
    g suspended (n, H, W); p film; s pores; r the scale. For the parameters see LIVING and WET; mu to cmax are C97's,
    mu, K, diff and disperse in reference cells. band: window of the slope term, reference cells; mach: the flow is kept
    below 1/sqrt(mach) of the speed of waves; cap: the speed limit; tilt: see `pull`.
    """

    def __init__(self, h, mask, pigments, g, p, mu=0.1, kappa=0.01, eta=0.02, K=10, cmin=0.3, cmax=0.9, alpha=0.02,
                 eps=0.05, delta=0.02, s=None, r=1, slope=0.3, relax=0.4, diff=0.03, disperse=0.15, pack=1.2, mach=2.0,
                 cap=1.0, band=1.0, tilt=(0.0, 0.0), wet=WET):
        self.h = np.asarray(h, float)
        self.M = np.asarray(mask).astype(np.uint8)
        H, W = self.M.shape
        self.u = np.zeros((H, W + 1))
        self.v = np.zeros((H + 1, W))
        self.p = np.array(p, float)
        self.g = np.array(g, float)
        self.d = np.zeros_like(self.g)
        self.c = self.h * (cmax - cmin) + cmin
        self.s = np.zeros((H, W)) if s is None else np.array(s, float)
        q = [PIGMENTS[n] if isinstance(n, str) else n for n in pigments]
        self.rho, self.omega, self.gamma = (np.array([a[i] for a in q], float) for i in range(3))
        self.mu, self.kappa, self.eta, self.K = mu, kappa, eta, K
        self.alpha, self.eps, self.delta = alpha, eps, delta
        self.r, self.slope, self.B, self.diff, self.disperse, self.pack = r, slope, relax, diff, disperse, pack
        self.mach, self.cap, self.wet, self.tilt = mach, cap, wet, tilt
        self.mu_ = np.zeros_like(self.u)
        self.mv_ = np.zeros_like(self.v)
        self.hs = band_limit(self.h, band * r)
        self.reach = 0.0  # part of a cell that edges have yet to advance
        self.evaporated = 0.0
        self.counts = []  # of each step: sub-steps of water, iterations, sub-steps of pigment, wet cells

    def water(self):
        """Film and pore water, film times reference cells: with what evaporated it is what was poured on."""
        return (self.p.sum() + self.wet["zeta"] * self.s.sum()) / self.r**2

    def step(self, n=1):
        r, w = self.r, self.wet
        for _ in range(n):
            # 1: momentum.
            face_mobility(self.M, self.p, w["w_flow"], w["m_min"], self.mu_, self.mv_)
            water = update_velocities(self.mu_, self.mv_, self.u, self.v, self.p, self.hs * self.slope, self.mu,
                                      self.kappa, r, self.cap * r, self.tilt[0], self.tilt[1])
            # 2: relaxation, then the water. B is raised where the flow would outrun the waves.
            B = max(self.B, self.mach * (vmax(self.u, self.v) / r) ** 2)
            sweeps = relax_implicit(self.mu_, self.mv_, self.u, self.v, B, r, TOLERANCE, 400)
            drain(self.u, self.v, self.p, B, max(1, int(np.ceil(w["drain_passes"] * r))))
            # 3: edge darkening and evaporation. L5: C97's FlowOutward takes pressure, this takes water that is counted;
            # full pores beside a film hide its edge. rim_expo was 10 in the first formulation; at 4 rims fade earlier
            # from dry paper to damp.
            cover = np.where(self.M > 0, 1.0, np.minimum(1, self.s / self.c) ** w["rim_expo"])
            out = (w["evap"] + self.eta * (1 - gauss_blur_K(cover, self.K * r))) * (self.M > 0)
            out = np.minimum(out, np.maximum(self.p, 0))
            self.p -= out
            es = np.where(self.M > 0, 0, np.minimum(w["evap_s"], self.s))
            self.s -= es
            self.evaporated += (out.sum() + w["zeta"] * es.sum()) / r**2
            # 4: pigment.
            pigment = move_pigment(self.mu_, self.mv_, self.u, self.v, self.g, self.d, self.diff, self.disperse,
                                   self.pack, r)
            transfer_pigment(self.M, self.g, self.d, self.h, self.rho, self.omega, self.gamma, w["lift"])
            settle(self.M, self.p, self.g, self.d, w["w_flow"], w["settle"])
            # 5: pores.
            absorb(self.M, self.s, self.c, self.p, self.alpha, w["zeta"])
            diffuse(self.s, self.c, self.eps, self.delta, r)
            # 6: the contact line.
            self.reach += r * w["creep"]
            while self.reach >= 1:
                self.reach -= 1
                creep(self.M, self.p, self.s, self.c, self.h, w["w_on"], w["pin"], w["rough"], w["share"])
            lost = dry(self.M, self.p, self.u, self.v, self.s, self.c, self.g, self.d, self.h, w["w_off"], w["w_on"],
                       w["zeta"])
            self.evaporated += lost / r**2
            self.counts.append((water, sweeps, pigment, int(self.M.sum())))

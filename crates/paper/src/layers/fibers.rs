//! Single curved fibers lying on each other; thick and soft, the marks of a felt.

use girtin_grid::random::{between, fold, mix, stage};

use crate::samples::{Ground, Patch};

girtin_params::parameters! {
    /// Single curved fibers lying on each other; thick and soft, the marks of a felt.
    pub struct Fibers {
        amount: f64 {
            symbol: "", label: "Amount", unit: "", default: 1.0, hard: (-1.0, 1.0), soft: (-1.0, 1.0),
            acts: Simulation, doc: "Share of the relief. Negative presses them in.", source: "custom",
        }
        length_mm: [f64; 2] {
            symbol: "", label: "Length", unit: "mm", default: [3.0, 8.0], hard: (0.3, 40.0), soft: (0.5, 20.0),
            acts: Simulation, doc: "Shortest and longest fiber.", source: "custom",
        }
        width_mm: [f64; 2] {
            symbol: "", label: "Width", unit: "mm", default: [0.1, 0.25], hard: (0.06, 3.0), soft: (0.08, 0.6),
            acts: Simulation, doc: "Thinnest and thickest fiber.", source: "custom",
        }
        per_mm2: f64 {
            symbol: "", label: "Density", unit: "1/mm²", default: 1.0, hard: (0.001, 20.0), soft: (0.01, 5.0),
            acts: Simulation, doc: "Number of fibers to a square millimetre.", source: "custom",
        }
        curl: f64 {
            symbol: "", label: "Curl", unit: "rad", default: 1.5, hard: (0.0, 12.0), soft: (0.0, 5.0),
            acts: Simulation, doc: "How far a fiber turns from end to end, at most.", source: "custom",
        }
        spread: f64 {
            symbol: "", label: "Spread", unit: "", default: 1.0, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "Directions: from all along the sheet (0) to any (1).", source: "custom",
        }
    }
}

/// A fiber is drawn as straight pieces of about this length or half its width, whichever is longer, mm.
const PIECE_MM: f64 = 0.5;

/// The height a fiber tapers to at its ends.
const TAPER: f32 = 0.3;

impl Fibers {
    pub(super) fn fill(&self, ground: &Ground, number: usize, patch: &Patch, out: &mut [f32]) {
        let side = 1.0 / libm::sqrt(self.per_mm2);
        let lattice = ground.lattice([side, side]);
        let noise = ground.noise(const { stage("paper fibers") }, number, &lattice);
        let reach = 0.5 * (self.length_mm[1] + self.width_mm[1]);
        let cells = |low: f64, high: f64, spacing: f64| {
            libm::floor((low - reach) / spacing) as i64..=libm::floor((high + reach) / spacing) as i64
        };
        let [sx, sy] = lattice.spacing_mm;
        for j in cells(patch.y.start_mm(), patch.y.end_mm(), sy) {
            for i in cells(patch.x.start_mm(), patch.x.end_mm(), sx) {
                let bits = noise.bits([i, j]);
                let [px, py] = noise.point([i, j]);
                let middle = [(i as f64 + px) * sx, (j as f64 + py) * sy];
                Fiber::new(self, bits, middle).draw(patch, out);
            }
        }
    }
}

/// One fiber: where its middle is, and how it runs both ways from there.
struct Fiber {
    middle: [f64; 2],
    direction: [f64; 2],
    length: f64,
    half_width: f64,
    /// Curvature in the middle and its change to the end, radians over the length.
    curl: [f64; 2],
    height: f32,
}

impl Fiber {
    fn new(fibers: &Fibers, bits: u64, middle: [f64; 2]) -> Self {
        let dice = |word: u64| fold(mix(bits), word);
        let angle = fibers.spread * between(dice(0), -0.5, 0.5) * core::f64::consts::PI;
        let [shortest, longest] = fibers.length_mm;
        let [thinnest, thickest] = fibers.width_mm;
        Self {
            middle,
            direction: [libm::cos(angle), libm::sin(angle)],
            length: between(dice(1), shortest, longest),
            half_width: 0.5 * between(dice(2), thinnest, thickest),
            curl: [between(dice(3), -fibers.curl, fibers.curl), between(dice(4), -fibers.curl, fibers.curl)],
            height: between(dice(5), 0.1, 1.0) as f32,
        }
    }

    fn draw(&self, patch: &Patch, out: &mut [f32]) {
        let reach = 0.5 * self.length + self.half_width;
        let [x, y] = self.middle;
        if x + reach < patch.x.start_mm()
            || x - reach > patch.x.end_mm()
            || y + reach < patch.y.start_mm()
            || y - reach > patch.y.end_mm()
        {
            return;
        }
        let pieces = libm::ceil(0.5 * self.length / PIECE_MM.max(0.5 * self.half_width)).max(2.0);
        let piece = 0.5 * self.length / pieces;
        for way in [1.0, -1.0] {
            let mut from = self.middle;
            let mut direction = self.direction.map(|d| way * d);
            for k in 0..pieces as u32 {
                let along = (f64::from(k) + 0.5) / pieces;
                // Half of the turn of one piece, by the rational form of a rotation: no sine needed, unit
                // length kept.
                let curl = way * self.curl[0] + self.curl[1] * along;
                let t = 0.25 * curl / pieces;
                let (c, s) = ((1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t));
                let turn = |[x, y]: [f64; 2]| [c * x - s * y, s * x + c * y];
                direction = turn(direction);
                let to = [from[0] + piece * direction[0], from[1] + piece * direction[1]];
                let taper = |along: f64| self.height * (1.0 - (1.0 - TAPER) * (along * along * along) as f32);
                let (k, pieces) = (f64::from(k), pieces);
                Piece {
                    from,
                    to,
                    half_width: self.half_width,
                    heights: [taper(k / pieces), taper((k + 1.0) / pieces)],
                }
                .draw(patch, out);
                direction = turn(direction);
                from = to;
            }
        }
    }
}

/// A straight piece of a fiber with round ends.
struct Piece {
    from: [f64; 2],
    to: [f64; 2],
    half_width: f64,
    heights: [f32; 2],
}

impl Piece {
    /// Raises the points near the piece to its height: the highest fiber wins, in whatever order they come.
    fn draw(&self, patch: &Patch, out: &mut [f32]) {
        let ([x0, y0], [x1, y1], w) = (self.from, self.to, self.half_width);
        let columns = patch.x.within(x0.min(x1) - w, x0.max(x1) + w);
        let lines = patch.y.within(y0.min(y1) - w, y0.max(y1) + w);
        if columns.is_empty() || lines.is_empty() {
            return;
        }
        // Relative to the piece's start positions are small enough for single precision, and the same for any
        // patch.
        let (ax, ay) = ((x1 - x0) as f32, (y1 - y0) as f32);
        let per_square = 1.0 / (ax * ax + ay * ay);
        let per_width = 1.0 / (w * w) as f32;
        let [h0, h1] = self.heights;
        for line in lines {
            let dy = (patch.y.mm(line) - y0) as f32;
            let row = &mut out[line * patch.x.count..][columns.clone()];
            for (value, column) in row.iter_mut().zip(columns.clone()) {
                let dx = (patch.x.mm(column) - x0) as f32;
                let t = ((dx * ax + dy * ay) * per_square).clamp(0.0, 1.0);
                let (ex, ey) = (dx - t * ax, dy - t * ay);
                let inside = (1.0 - (ex * ex + ey * ey) * per_width).max(0.0);
                *value = value.max((h0 + t * (h1 - h0)) * inside * inside * (3.0 - 2.0 * inside));
            }
        }
    }
}

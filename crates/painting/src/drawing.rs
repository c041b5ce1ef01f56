//! The drawing at any resolution: which figure each sample belongs to.

use girtin_grid::noise::Noise;
use girtin_grid::{Raster, random};
use rayon::prelude::*;

use crate::document::Figure;

/// Label of a sample that belongs to no figure; others are numbers of figures and 1.
pub const BARE: u16 = 0;

/// Contours ready to be filled, mm.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    figures: Vec<Edges>,
}

/// A figure's edges, none of them level, from top to bottom.
#[derive(Clone, Debug)]
struct Edges {
    /// Least and most y.
    rows: [f64; 2],
    /// Upper end, lower end.
    edges: Vec<[[f64; 2]; 2]>,
}

/// A contour is redrawn in pieces of this length, mm.
const PIECE_MM: f64 = 0.5;
/// How far a hand strays, mm, and over which lengths, mm: slowly, and as the paper's tooth holds the brush.
const STRAYS: [(f64, f64); 2] = [(0.7, 13.0), (0.2, 2.2)];
/// Over which length it is steady or not, mm.
const STEADY_MM: f64 = 24.0;

/// A hand that draws: where it goes instead of where it is led to. It depends on the place alone, so two figures that share
/// a contour still do.
struct Hand {
    strays: [[Noise; 2]; 2],
    steady: Noise,
}

impl Hand {
    fn new(seed: u64) -> Self {
        let noise = |name: &str| Noise::new(seed, random::stage(name));
        let strays = [0, 1].map(|k| ["across", "down"].map(|axis| noise(&format!("hand {k} {axis}"))));
        Self { strays, steady: noise("steady") }
    }

    fn at(&self, place: [f64; 2]) -> [f64; 2] {
        let loose = (0.5 + 1.8 * self.steady.gradient(place.map(|mm| mm / STEADY_MM))).clamp(0.2, 1.0);
        let stray = |axis: usize| -> f64 {
            let of = |(noise, (mm, over)): (&[Noise; 2], &(f64, f64))| {
                mm * noise[axis].gradient(place.map(|mm| mm / over))
            };
            self.strays.iter().zip(&STRAYS).map(of).sum()
        };
        [0, 1].map(|axis: usize| place[axis] + loose * stray(axis))
    }

    /// A ring as it is drawn.
    fn ring(&self, ring: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut drawn = Vec::new();
        for (&a, &b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let pieces = libm::ceil(libm::hypot(dx, dy) / PIECE_MM).clamp(1.0, MAX_PIECES);
            // Whoever draws it the other way goes through the same points.
            drawn.extend((0..pieces as usize).map(|piece| {
                let part = piece as f64 / pieces;
                self.at([a[0] + part * dx, a[1] + part * dy])
            }));
        }
        drawn
    }
}

/// Most pieces that a straight run is drawn in.
const MAX_PIECES: f64 = 4000.0;

impl Drawing {
    /// Of these figures, in the order in which they are drawn, by a hand with this seed.
    pub fn new(figures: &[Figure], seed: u64) -> Self {
        let hand = Hand::new(seed);
        Self::through(figures, |ring| hand.ring(ring))
    }

    /// The same exactly as they are led, in any unit.
    pub fn exact(figures: &[Figure]) -> Self {
        Self::through(figures, <[[f64; 2]]>::to_vec)
    }

    fn through(figures: &[Figure], drawn: impl Fn(&[[f64; 2]]) -> Vec<[f64; 2]> + Sync) -> Self {
        let edges = figures.par_iter().map(|figure| {
            let mut edges = Vec::new();
            for ring in figure.rings.iter().map(|ring| drawn(ring)) {
                let next = ring.iter().cycle().skip(1);
                edges.extend(
                    ring.iter()
                        .zip(next)
                        .filter(|(a, b)| a[1] != b[1])
                        .map(|(&a, &b)| if a[1] < b[1] { [a, b] } else { [b, a] }),
                );
            }
            let rows = edges.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| {
                [low.min(a[1]), high.max(b[1])]
            });
            Edges { rows, edges }
        });
        Self { figures: edges.collect() }
    }

    /// Whether nothing is drawn.
    pub fn is_empty(&self) -> bool {
        self.figures.is_empty()
    }

    /// How many figures are drawn.
    pub fn len(&self) -> usize {
        self.figures.len()
    }

    /// The labels of `width` × `rows` samples, `per_mm` of them a millimetre, the first one's corner at `origin` on the
    /// sheet, mm: of the figure drawn last over the middle of each.
    pub fn labels(&self, width: usize, rows: usize, per_mm: f64, origin: [f64; 2]) -> Raster<u16> {
        let mut labels = Raster::new(width, rows, BARE);
        let (top, bottom) = (origin[1], origin[1] + rows as f64 / per_mm);
        let mut crossings: Vec<Vec<f32>> = vec![Vec::new(); rows];
        for (number, figure) in self.figures.iter().enumerate() {
            if figure.rows[1] < top || figure.rows[0] > bottom {
                continue;
            }
            for [a, b] in &figure.edges {
                // Rows whose middle lies in [a, b): an end that two edges share is crossed once.
                let row = |y: f64| libm::ceil((y - top) * per_mm - 0.5).clamp(0.0, rows as f64) as usize;
                let slope = (b[0] - a[0]) / (b[1] - a[1]);
                for (y, row) in (row(a[1])..row(b[1])).zip(&mut crossings[row(a[1])..]) {
                    let middle = top + (y as f64 + 0.5) / per_mm;
                    row.push(((a[0] + (middle - a[1]) * slope - origin[0]) * per_mm) as f32);
                }
            }
            for (y, row) in crossings.iter_mut().enumerate().filter(|(_, row)| !row.is_empty()) {
                row.sort_by(f32::total_cmp);
                let line = labels.row_mut(y);
                for pair in row.chunks_exact(2) {
                    let column = |x: f32| libm::ceilf(x - 0.5).clamp(0.0, width as f32) as usize;
                    line[column(pair[0])..column(pair[1])].fill(number as u16 + 1);
                }
                row.clear();
            }
        }
        labels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(from: f64, to: f64) -> Vec<[f64; 2]> {
        vec![[from, from], [to, from], [to, to], [from, to]]
    }

    #[test]
    fn the_last_figure_drawn_has_the_place_and_holes_are_open() {
        let drawing = Drawing::exact(&[
            Figure { rings: vec![square(0.0, 8.0)] },
            Figure { rings: vec![square(2.0, 7.0), square(4.0, 6.0)] },
        ]);
        let labels = drawing.labels(10, 10, 1.0, [0.0, 0.0]);
        let row: Vec<u16> = labels.row(4).to_vec();
        assert_eq!(row, [1, 1, 2, 2, 1, 1, 2, 1, 0, 0]);
    }

    #[test]
    fn a_band_is_a_part_of_the_whole_and_neighbours_leave_no_gap() {
        let corner = [3.37, 4.11];
        let left = Figure { rings: vec![vec![[0.0, 0.0], corner, [0.0, 9.0]]] };
        let right = Figure { rings: vec![vec![[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0], corner]] };
        let drawing = Drawing::new(&[left, right], 1);
        let whole = drawing.labels(63, 63, 7.0, [0.0, 0.0]);
        let inner = (4..59).flat_map(|y| whole.row(y)[4..59].iter());
        assert!(inner.copied().all(|label| label != BARE));
        let band = drawing.labels(63, 20, 7.0, [0.0, 3.0]);
        assert_eq!(band.as_slice(), &whole.as_slice()[21 * 63..41 * 63]);
    }
}

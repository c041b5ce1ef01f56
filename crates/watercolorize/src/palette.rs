//! A palette for a picture: a few real pigments that can mix its colors, chosen with a painter's taste.

use girtin_optics::pigment::Character;
use girtin_optics::{Lab, LinearRgb, Pigment};
use rayon::prelude::*;

use crate::separate::{Limits, MOST, Paints, lab};

/// Colors that stand for a picture.
const CLUSTERS: usize = 22;
/// Colors that are looked at, at most.
const MOST_COLORS: usize = 160;
/// Palettes that are followed at a time.
const BEAM: usize = 4;
/// Gain, CIEDE2000, below which a further pigment is not worth its place.
const WORTH: f64 = 0.1;

/// Difference, CIEDE2000, that counts twice: one color gone wrong is seen where many that are hardly off are not.
const SEEN: f64 = 10.0;

/// A color of the picture and how much it counts.
pub type Cluster = ([f32; 3], f64);

/// Gathers likely many colors into so many as a palette is chosen for: the two that are nearest each other, by weight, become
/// one, again and again.
pub fn gather(colors: &mut Vec<Cluster>) {
    colors.sort_by(|a, b| b.1.total_cmp(&a.1));
    colors.truncate(MOST_COLORS);
    while colors.len() > CLUSTERS {
        let mut nearest = (f64::INFINITY, 0, 1);
        for i in 0..colors.len() {
            for j in i + 1..colors.len() {
                let ((a, u), (b, v)) = (&colors[i], &colors[j]);
                let square: f64 = a.iter().zip(b).map(|(a, b)| f64::from((a - b) * (a - b))).sum();
                // Ward's: what joining them costs.
                let cost = square * u * v / (u + v).max(1e-12);
                if cost < nearest.0 {
                    nearest = (cost, i, j);
                }
            }
        }
        let (_, i, j) = nearest;
        let (b, v) = colors.remove(j);
        let (a, u) = &mut colors[i];
        let part = (v / (*u + v).max(1e-12)) as f32;
        a.iter_mut().zip(b).for_each(|(a, b)| *a += part * (b - *a));
        *u += v;
    }
    let sum: f64 = colors.iter().map(|color| color.1).sum();
    colors.iter_mut().for_each(|color| color.1 /= sum.max(1e-9));
}

/// What a painter says against a pigment, CIEDE2000.
fn distaste(pigment: &Pigment) -> f64 {
    let says = |character: Character| pigment.character.contains(&character);
    let of = |character, dear: f64| if says(character) { dear } else { 0.0 };
    // Opaque paint kills the paper's light, and mixtures are the palette's own business; washes that granulate or lift are
    // watercolor's charm, strong stains are its peril.
    of(Character::Opaque, 1.2)
        + of(Character::SemiOpaque, 0.35)
        + of(Character::SemiTransparent, 0.05)
        + of(Character::Mixed, 0.25)
        + of(Character::StrongTinting, 0.12)
        + of(Character::WeakTinting, 0.25)
        - of(Character::Granulating, 0.08)
        - of(Character::Lifting, 0.04)
}

/// Whether a palette has a yellow, a red and a blue, as far as the picture has color at all.
fn imbalance(pigments: &[&Pigment], colorful: f64) -> f64 {
    let hue = |pigment: &Pigment| {
        let ground = [LinearRgb::WHITE.0[0] as f32; 3];
        let [_, a, b] = lab(Paints::new([&pigment.coefficients]).over(&[0.6], ground));
        (libm::atan2f(b, a).to_degrees().rem_euclid(360.0), libm::hypotf(a, b))
    };
    let has = |low: f32, high: f32| {
        pigments.iter().any(|pigment| {
            let (hue, chroma) = hue(pigment);
            chroma > 18.0 && (low..high).contains(&hue)
        })
    };
    let is_missing = |there: bool| if there { 0.0 } else { 0.45 * colorful };
    is_missing(has(55.0, 112.0))
        + is_missing(has(0.0, 55.0) || has(335.0, 360.0))
        + is_missing(has(210.0, 310.0))
}

/// Chooses up to `most` of the pigments for a picture's colors over paper; the order is the stock's.
///
/// A beam search: palettes grow by a pigment at a time, the best few are followed, until a further pigment gains little.
pub fn choose<'a>(
    stock: impl IntoIterator<Item = &'a Pigment>,
    clusters: &[Cluster],
    paper: [f32; 3],
    most: usize,
) -> Vec<&'a Pigment> {
    let usable = |pigment: &&Pigment| {
        // White is the paper, and paint that shimmers depends on the light.
        !pigment.character.contains(&Character::Interference) && !pigment.id.ends_with("-white")
    };
    let stock: Vec<&Pigment> = stock.into_iter().filter(usable).collect();
    let limits = Limits { each: 2.0, total: 3.0, thrift: 0.5, keeping: 0.0, rounds: 9, hue: 1.0 };
    let colorful = clusters.iter().map(|([_, a, b], weight)| f64::from(libm::hypotf(*a, *b)) * weight);
    let colorful = (colorful.sum::<f64>() / 15.0).min(1.0);
    let score = |palette: &Vec<usize>| {
        let pigments: Vec<&Pigment> = palette.iter().map(|&at| stock[at]).collect();
        let paints = Paints::new(pigments.iter().map(|pigment| &pigment.coefficients));
        let error: f64 = clusters
            .iter()
            .map(|(wanted, weight)| {
                let (_, error) = paints.separate(*wanted, paper, None, &limits);
                let found = [0, 1, 2].map(|c: usize| wanted[c] + error[c]);
                let off = as_lab(found).ciede2000(as_lab(*wanted));
                weight * off * (1.0 + off / SEEN)
            })
            .sum();
        let taste: f64 = pigments.iter().map(|pigment| distaste(pigment)).sum();
        error + 0.5 * taste + imbalance(&pigments, colorful)
    };
    let mut beam: Vec<(Vec<usize>, f64)> = vec![(Vec::new(), f64::INFINITY)];
    let mut best: (Vec<usize>, f64) = (Vec::new(), f64::INFINITY);
    for size in 1..=most.min(MOST) {
        let mut candidates: Vec<Vec<usize>> = Vec::new();
        for (palette, _) in &beam {
            for at in (0..stock.len()).filter(|at| !palette.contains(at)) {
                let mut longer = palette.clone();
                longer.push(at);
                longer.sort_unstable();
                candidates.push(longer);
            }
        }
        candidates.sort();
        candidates.dedup();
        let scores: Vec<f64> = candidates.par_iter().map(score).collect();
        beam = candidates.into_iter().zip(scores).collect();
        beam.sort_by(|a, b| a.1.total_cmp(&b.1).then_with(|| a.0.cmp(&b.0)));
        beam.truncate(BEAM);
        let Some(first) = beam.first() else { break };
        let gained = best.1 - first.1;
        if gained < WORTH && size > 3 {
            break;
        }
        if gained > 0.0 {
            best = first.clone();
        }
    }
    best.0.into_iter().map(|at| stock[at]).collect()
}

fn as_lab([l, a, b]: [f32; 3]) -> Lab {
    Lab { l: f64::from(l), a: f64::from(a), b: f64::from(b) }
}
